"""Motions that excite the parameters, and recordings simulated on them. Imports only the model room."""

from .blends import BlendedPoints
from .bound import Floor, floor_of, floor_under
from .bounds import JointBounds
from .build import Loads, build_design
from .closed_loop import ClosedLoop, Reference, Run
from .collision import Capsule, HalfSpace, Scene
from .controller import Controller
from .design import Design, Solver, solve_design
from .disturbances import (
    RX90_DISTURBANCES,
    RX90_SLOW_NOISE,
    Disturbances,
    RobotErrors,
    no_disturbances,
    relative_disturbances,
)
from .experiment import RATE, Experiment, SimulatedRun, Task, mean_friction, run_experiment
from .fourier import Fourier
from .goal import Earlier, Goal
from .integrator import Ripple
from .limits import LimitCheck
from .load import load_torques
from .near import NearDesign, NearRequest, check_mass_visible, design_near
from .near_motion import NearMotion
from .near_prediction import predicted_spread
from .near_second import second_pose
from .point_to_point import PointToPoint, plan_point_to_point, plan_stops, random_points
from .problem import DesignProblem
from .sampled import SampledTrajectory
from .scene_file import read_scene
from .score import Learnt, Score, score_motion
from .search import Step
from .segments import Quintic, Segment, Trapezoid
from .shapes import BlendShape, FourierShape, ViaPointShape
from .simulation import RX90_NOISE, Simulator, parameter_vector
from .via_points import ViaPoints, random_via_points, shortest_durations

__all__ = [
    "RATE",
    "RX90_DISTURBANCES",
    "RX90_NOISE",
    "RX90_SLOW_NOISE",
    "BlendShape",
    "BlendedPoints",
    "Capsule",
    "ClosedLoop",
    "Controller",
    "Design",
    "DesignProblem",
    "Disturbances",
    "Earlier",
    "Experiment",
    "Floor",
    "Fourier",
    "FourierShape",
    "Goal",
    "HalfSpace",
    "JointBounds",
    "Learnt",
    "LimitCheck",
    "Loads",
    "NearDesign",
    "NearMotion",
    "NearRequest",
    "PointToPoint",
    "Quintic",
    "Reference",
    "Ripple",
    "RobotErrors",
    "Run",
    "SampledTrajectory",
    "Scene",
    "Score",
    "Segment",
    "SimulatedRun",
    "Simulator",
    "Solver",
    "Step",
    "Task",
    "Trapezoid",
    "ViaPointShape",
    "ViaPoints",
    "build_design",
    "check_mass_visible",
    "design_near",
    "floor_of",
    "floor_under",
    "load_torques",
    "mean_friction",
    "no_disturbances",
    "parameter_vector",
    "plan_point_to_point",
    "plan_stops",
    "predicted_spread",
    "random_points",
    "random_via_points",
    "read_scene",
    "relative_disturbances",
    "run_experiment",
    "score_motion",
    "second_pose",
    "shortest_durations",
    "solve_design",
]
