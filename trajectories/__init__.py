"""Motions that excite the parameters, and recordings simulated on them. Imports only the model room."""

from .bound import Floor, floor_of
from .bounds import JointBounds
from .build import FourierShape, Loads, ViaPointShape, build_design
from .collision import Capsule, HalfSpace, Scene
from .design import Design, Step, solve_design
from .fourier import Fourier
from .goal import Earlier, Goal
from .limits import LimitCheck
from .problem import DesignProblem
from .score import Learnt, Score, score_motion
from .simulation import RX90_NOISE, Simulator, parameter_vector
from .via_points import ViaPoints, random_via_points, shortest_durations

__all__ = [
    "RX90_NOISE",
    "Capsule",
    "Design",
    "DesignProblem",
    "Earlier",
    "Floor",
    "Fourier",
    "FourierShape",
    "Goal",
    "HalfSpace",
    "JointBounds",
    "Learnt",
    "LimitCheck",
    "Loads",
    "Scene",
    "Score",
    "Simulator",
    "Step",
    "ViaPointShape",
    "ViaPoints",
    "build_design",
    "floor_of",
    "parameter_vector",
    "random_via_points",
    "score_motion",
    "shortest_durations",
    "solve_design",
]
