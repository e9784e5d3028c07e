from ..model.base import check_mass_visible as check_mass_visible
from .design.goal import ASSUMED_NOISE as ASSUMED_NOISE
from .design.goal import ASSUMED_RATIO as ASSUMED_RATIO
from .design.goal import ASSUMED_STICTION as ASSUMED_STICTION
from .design.goal import INDEPENDENT as INDEPENDENT
from .design.goal import MEMORY as MEMORY
from .design.goal import Earlier, Goal, NearGoal
from .design.goal import Shape as Shape
from .design.goal import assumed_noise as assumed_noise
from .design.goal import second_pose as second_pose
from .design.limits import Loads, PayloadSet
from .design.problem import DesignProblem, build_design
from .design.scene import Scene, read_scene
from .design.scene import usual_scene as usual_scene
from .design.score import REHEARSAL as REHEARSAL
from .design.score import Rung as Rung
from .design.score import Score, score_motion
from .design.score import check_held as check_held
from .design.score import missed_on_run as missed_on_run
from .design.score import speed_ladder as speed_ladder
from .design.search import Design, floor_under, solve_design
from .design.search import Floor as Floor
from .motions.family import JointBounds
from .motions.family import Plan as Plan
from .motions.fourier import Fourier, FourierShape, NearShape
from .motions.planned import PointToPoint, SampledTrajectory, plan_point_to_point
from .motions.planned import joined as joined
from .motions.via_points import Quintic as Quintic
from .motions.via_points import StaticShape, Trapezoid, ViaPoints, ViaPointShape, random_via_points
from .motions.via_points import random_points as random_points
from .simulation import CONTROLLERS as CONTROLLERS
from .simulation import RX90_DISTURBANCES as RX90_DISTURBANCES
from .simulation import RX90_NOISE, Controller, Disturbances, Experiment, Simulator, Task, run_experiment
from .simulation import RX90_SLOW_NOISE as RX90_SLOW_NOISE
from .simulation import no_disturbances as no_disturbances
from .simulation import relative_disturbances as relative_disturbances
from .simulation import remembered_disturbances as remembered_disturbances

__all__ = [
    "RX90_NOISE",
    "Controller",
    "Design",
    "DesignProblem",
    "Disturbances",
    "Earlier",
    "Experiment",
    "Fourier",
    "FourierShape",
    "Goal",
    "JointBounds",
    "Loads",
    "NearGoal",
    "NearShape",
    "PayloadSet",
    "PointToPoint",
    "SampledTrajectory",
    "Scene",
    "Score",
    "Simulator",
    "StaticShape",
    "Task",
    "Trapezoid",
    "ViaPointShape",
    "ViaPoints",
    "build_design",
    "floor_under",
    "plan_point_to_point",
    "random_via_points",
    "read_scene",
    "run_experiment",
    "score_motion",
    "solve_design",
]
