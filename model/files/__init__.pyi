from .reframe import JointAxis as JointAxis
from .reframe import modified_dh as modified_dh
from .robot_writer import robot_toml as robot_toml
