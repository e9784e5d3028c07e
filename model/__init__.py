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
from .inertia import InertialParameters
from .kernel import Kernel
from .kinematics import forward_kinematics
from .motion import Measurement, Motion, Recording
from .newton_euler import inverse_dynamics
from .payload_file import read_payload
from .processing import Processing
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
from .robot import INERTIAL, Joint, Limits, Robot
from .robot_file import load_robot, robot_names

__all__ = [
    "INERTIAL",
    "BaseParameters",
    "Coupling",
    "Drives",
    "InertialParameters",
    "InputError",
    "Joint",
    "Kernel",
    "Limits",
    "Measurement",
    "Motion",
    "Processing",
    "Recording",
    "Robot",
    "Spring",
    "base_parameters",
    "base_regressor",
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
    "generate_code",
    "gravity",
    "inverse_dynamics",
    "inverse_dynamics_base",
    "load_robot",
    "local_transfer_base_parameters",
    "mass_matrix",
    "payload_columns",
    "payload_regressor",
    "read_payload",
    "regressor",
    "robot_names",
    "smooth_dry_friction",
    "smooth_regressor",
    "standard_columns",
    "standard_regressor",
]
