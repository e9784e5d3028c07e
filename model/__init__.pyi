from ..common.errors import InputError as InputError
from . import codegen as codegen
from . import drives as drives
from . import dynamics as dynamics
from . import frames as frames
from . import friction as friction
from . import inertia as inertia
from . import kinematics as kinematics
from . import motion as motion
from . import pose as pose
from . import regressors as regressors
from . import robot as robot
from . import stand_in as stand_in
from . import visibility as visibility
from .base.closed_form import closed_form_base_parameters as closed_form_base_parameters
from .base.parameters import BaseParameters as BaseParameters
from .base.parameters import base_regressor as base_regressor
from .base.parameters import essential_regressor as essential_regressor
from .base.rank import base_parameters as base_parameters
from .codegen import generate_code as generate_code
from .drives import Coupling as Coupling
from .drives import Drives as Drives
from .drives import Spring as Spring
from .dynamics import coriolis as coriolis
from .dynamics import coriolis_matrix as coriolis_matrix
from .dynamics import forward_dynamics as forward_dynamics
from .dynamics import forward_dynamics_base as forward_dynamics_base
from .dynamics import gravity as gravity
from .dynamics import inverse_dynamics as inverse_dynamics
from .dynamics import inverse_dynamics_base as inverse_dynamics_base
from .dynamics import mass_matrix as mass_matrix
from .files.payload_file import read_payload as read_payload
from .files.reframe import JointAxis as JointAxis
from .files.reframe import modified_dh as modified_dh
from .files.robot_file import load_robot as load_robot
from .files.robot_file import robot_names as robot_names
from .files.robot_file import robot_toml as robot_toml
from .frames import mounted as mounted
from .frames import with_gravity as with_gravity
from .frames import with_tool as with_tool
from .friction import PAPER as PAPER
from .friction import Friction as Friction
from .friction import friction_terms as friction_terms
from .inertia import InertialParameters as InertialParameters
from .kinematics import forward_kinematics as forward_kinematics
from .motion import Motion as Motion
from .motion import Processing as Processing
from .motion import Recording as Recording
from .pose import Pose as Pose
from .regressors import payload_regressor as payload_regressor
from .regressors import regressor as regressor
from .regressors import standard_columns as standard_columns
from .regressors import standard_regressor as standard_regressor
from .robot import INERTIAL as INERTIAL
from .robot import Joint as Joint
from .robot import Limits as Limits
from .robot import Robot as Robot
from .stand_in import with_stand_in as with_stand_in

__all__ = [
    "INERTIAL",
    "PAPER",
    "BaseParameters",
    "Coupling",
    "Drives",
    "Friction",
    "InertialParameters",
    "InputError",
    "Joint",
    "Limits",
    "Motion",
    "Pose",
    "Processing",
    "Recording",
    "Robot",
    "Spring",
    "base_parameters",
    "base_regressor",
    "closed_form_base_parameters",
    "coriolis",
    "coriolis_matrix",
    "essential_regressor",
    "forward_dynamics",
    "forward_dynamics_base",
    "forward_kinematics",
    "friction_terms",
    "generate_code",
    "gravity",
    "inverse_dynamics",
    "inverse_dynamics_base",
    "load_robot",
    "mass_matrix",
    "mounted",
    "payload_regressor",
    "read_payload",
    "regressor",
    "robot_names",
    "standard_columns",
    "standard_regressor",
    "with_gravity",
    "with_stand_in",
    "with_tool",
]
