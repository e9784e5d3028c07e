from .answers.gains import KnownLoad as KnownLoad
from .answers.gains import answer_gains as answer_gains
from .answers.gains import gain_problem as gain_problem
from .answers.gains import identify_gains as identify_gains
from .answers.gains import known_mass as known_mass
from .answers.identification import Identification as Identification
from .answers.identification import identification_system as identification_system
from .answers.identification import identify as identify
from .answers.identification import payload_system as payload_system
from .answers.identification import robot_result as robot_result
from .answers.payload import PayloadAnswer as PayloadAnswer
from .answers.payload import answer_payload as answer_payload
from .answers.payload import identify_payload as identify_payload
from .answers.payload import weigh as weigh
from .answers.payload import weigh_at_rest as weigh_at_rest
from .diagnosis.evidence import Finding as Finding
from .diagnosis.evidence import Verdict as Verdict
from .diagnosis.kinematics import ToolPoses as ToolPoses
from .diagnosis.kinematics import check_pose as check_pose
from .diagnosis.kinematics import rank_readings as rank_readings
from .equations.equations import PAYLOAD as PAYLOAD
from .equations.equations import Equations as Equations
from .fit.estimate import Estimate as Estimate
from .fit.estimate import Gains as Gains
from .fit.estimate import Parameter as Parameter
from .fit.linear_problem import SigmaBound as SigmaBound
from .fit.linear_problem import SigmaRatio as SigmaRatio
from .fit.linear_problem import StopRule as StopRule
from .fit.linear_problem import weighted as weighted
from .fit.settings import FRICTION_CHANGE as FRICTION_CHANGE
from .fit.settings import METHOD_NAMES as METHOD_NAMES
from .fit.settings import Candidates as Candidates
from .fit.settings import Settings as Settings
from .payload.long_motion import LongMotion as LongMotion
from .payload.long_motion import payload_problem as payload_problem
from .payload.methods import PayloadProblem as PayloadProblem
from .payload.methods import payload_estimate as payload_estimate
from .payload.methods import selected as selected
from .payload.methods import with_robust as with_robust
from .payload.short_motion import ShortMotion as ShortMotion
from .payload.short_motion import difference_weighing as difference_weighing
from .payload.short_motion import known_robot_weighing as known_robot_weighing
from .possible.constraints import CentreOfMassInBox as CentreOfMassInBox
from .possible.constraints import Constraint as Constraint
from .possible.constraints import InEllipsoid as InEllipsoid
from .possible.constraints import KnownMass as KnownMass
from .possible.constraints import MassBounds as MassBounds
from .possible.constraints import PossibleBody as PossibleBody
from .possible.constraints import SolverError as SolverError
from .possible.intervals import profile_intervals as profile_intervals
from .possible.payload import build_constrained as build_constrained
from .possible.payload import solve_constrained as solve_constrained
from .possible.robot import PossibleRobot as PossibleRobot
from .possible.robot import build_constrained_base as build_constrained_base
from .possible.robot import solve_constrained_base as solve_constrained_base
from .possible.whole_robot import BUDGET as BUDGET
from .possible.whole_robot import Labelled as Labelled
from .possible.whole_robot import LinkNumbers as LinkNumbers
from .possible.whole_robot import PriorRobot as PriorRobot
from .possible.whole_robot import WholeRobot as WholeRobot
from .possible.whole_robot import has_prior as has_prior
from .possible.whole_robot import robot_prior as robot_prior
from .possible.whole_robot import solve_constrained_prior as solve_constrained_prior
from .possible.whole_robot import whole_robot as whole_robot
from .results.payload import ObservationSystem as ObservationSystem
from .results.payload import PayloadResult as PayloadResult
from .results.payload import StandIn as StandIn
from .results.robot import GainsResult as GainsResult
from .results.robot import RobotResult as RobotResult
from .signals.filtering import measurement as measurement

__all__ = [
    "PAYLOAD",
    "Candidates",
    "CentreOfMassInBox",
    "Equations",
    "Estimate",
    "Gains",
    "GainsResult",
    "Identification",
    "InEllipsoid",
    "KnownMass",
    "LongMotion",
    "MassBounds",
    "Parameter",
    "PayloadAnswer",
    "PayloadResult",
    "PossibleBody",
    "PossibleRobot",
    "RobotResult",
    "Settings",
    "ShortMotion",
    "SigmaBound",
    "SigmaRatio",
    "SolverError",
    "Verdict",
    "answer_payload",
    "build_constrained",
    "build_constrained_base",
    "identify",
    "identify_gains",
    "identify_payload",
    "payload_estimate",
    "payload_problem",
    "profile_intervals",
    "robot_prior",
    "solve_constrained",
    "solve_constrained_base",
    "weigh",
    "weigh_at_rest",
    "weighted",
]
