"""Motions that excite the parameters, and recordings simulated on them. Imports only the model room."""

from .closed_loop import ClosedLoop, Reference, Run
from .controller import Controller
from .disturbances import (
    RX90_DISTURBANCES,
    RX90_SLOW_NOISE,
    Disturbances,
    RobotErrors,
    no_disturbances,
    relative_disturbances,
)
from .experiment import RATE, Experiment, SimulatedRun, Task, mean_friction, run_experiment
from .integrator import Ripple
from .point_to_point import PointToPoint, plan_point_to_point, random_points
from .sampled import SampledTrajectory
from .simulation import RX90_NOISE, Simulator, parameter_vector
from .via_points import ViaPoints, random_via_points, shortest_durations

__all__ = [
    "RATE",
    "RX90_DISTURBANCES",
    "RX90_NOISE",
    "RX90_SLOW_NOISE",
    "ClosedLoop",
    "Controller",
    "Disturbances",
    "Experiment",
    "PointToPoint",
    "Reference",
    "Ripple",
    "RobotErrors",
    "Run",
    "SampledTrajectory",
    "SimulatedRun",
    "Simulator",
    "Task",
    "ViaPoints",
    "mean_friction",
    "no_disturbances",
    "parameter_vector",
    "plan_point_to_point",
    "random_points",
    "random_via_points",
    "relative_disturbances",
    "run_experiment",
    "shortest_durations",
]
