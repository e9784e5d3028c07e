from .payload_file import BodyTable as BodyTable
from .reframe import JointAxis as JointAxis
from .reframe import modified_dh as modified_dh
from .robot_file import robot_toml as robot_toml
