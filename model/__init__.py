"""The robot and its dynamics: what torque a motion needs, and which parameters the torque shows.

Imports no other room.
"""

from .base.grouping import closed_form_base_parameters
from .base.local_transfers import local_transfer_base_parameters
from .base.parameters import BaseParameters
from .base.rank import base_parameters
from .codegen import code_names, generate_code
from .drives import Coupling, Drives, Spring
from .dynamics import (
    coriolis,
    coriolis_matrix,
    drive_torque,
    dry_friction_names,
    forward_dynamics,
    forward_dynamics_base,
    gravity,
    inverse_dynamics_base,
    mass_matrix,
    smooth_dry_friction,
)
from .errors import InputError
from .frames import (
    MOUNTS,
    LinkBody,
    bodies_in_link_frames,
    frames_at,
    mounted,
    step,
    with_gravity,
    with_tool,
)
from .inertia import InertialParameters
from .kernel import Kernel
from .kinematics import forward_kinematics
from .motion import Measurement, Motion, Recording
from .newton_euler import inverse_dynamics
from .payload_file import read_payload
from .pose import Pose
from .processing import Processing
from .reframe import JointAxis, Reframed, modified_dh
from .regressor import (
    base_regressor,
    essential_regressor,
    payload_columns,
    payload_regressor,
    regressor,
    smooth_regressor,
    standard_columns,
    standard_regressor,
)
from .robot import INERTIAL, Joint, Limits, Links, Robot
from .robot_file import load_robot, robot_names
from .robot_writer import robot_toml
from .visibility import PayloadVisibility, friction_columns, payload_visibility, visibility_of

__all__ = [
    "INERTIAL",
    "MOUNTS",
    "BaseParameters",
    "Coupling",
    "Drives",
    "InertialParameters",
    "InputError",
    "Joint",
    "JointAxis",
    "Kernel",
    "Limits",
    "LinkBody",
    "Links",
    "Measurement",
    "Motion",
    "PayloadVisibility",
    "Pose",
    "Processing",
    "Recording",
    "Reframed",
    "Robot",
    "Spring",
    "base_parameters",
    "base_regressor",
    "bodies_in_link_frames",
    "closed_form_base_parameters",
    "code_names",
    "coriolis",
    "coriolis_matrix",
    "drive_torque",
    "dry_friction_names",
    "essential_regressor",
    "forward_dynamics",
    "forward_dynamics_base",
    "forward_kinematics",
    "frames_at",
    "friction_columns",
    "generate_code",
    "gravity",
    "inverse_dynamics",
    "inverse_dynamics_base",
    "load_robot",
    "local_transfer_base_parameters",
    "mass_matrix",
    "modified_dh",
    "mounted",
    "payload_columns",
    "payload_regressor",
    "payload_visibility",
    "read_payload",
    "regressor",
    "robot_names",
    "robot_toml",
    "smooth_dry_friction",
    "smooth_regressor",
    "standard_columns",
    "standard_regressor",
    "step",
    "visibility_of",
    "with_gravity",
    "with_tool",
]
