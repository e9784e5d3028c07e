from .apps.logs import read_recording as read_recording
from .common.errors import InputError as InputError
from .estimation import Equations as Equations
from .estimation import Estimate as Estimate
from .estimation import Settings as Settings
from .estimation import answer_payload as answer_payload
from .estimation import identify as identify
from .estimation import identify_gains as identify_gains
from .estimation import identify_payload as identify_payload
from .estimation import payload_problem as payload_problem
from .estimation import weigh as weigh
from .estimation import weigh_at_rest as weigh_at_rest
from .estimation.answers.identification import equations as equations
from .model import InertialParameters as InertialParameters
from .model import Recording as Recording
from .model import Robot as Robot
from .model import base_parameters as base_parameters
from .model import load_robot as load_robot
from .trajectories import RX90_NOISE as RX90_NOISE
from .trajectories import Simulator as Simulator
from .trajectories import random_via_points as random_via_points

__version__: str
