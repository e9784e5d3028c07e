"""A payload from a short motion of a few joints near a pose."""

from .answer import Agreement, WeighAnswer, answer_weighing
from .judge import USABLE, Judged
from .problem import WeighProblem, difference_weighing, known_robot_weighing
from .repeats import Repeats
from .run import Run
from .solve import WeighEstimate, solve_weighing, weigh_by_joints
from .stand_in import StandIn

__all__ = [
    "USABLE",
    "Agreement",
    "Judged",
    "Repeats",
    "Run",
    "StandIn",
    "WeighAnswer",
    "WeighEstimate",
    "WeighProblem",
    "answer_weighing",
    "difference_weighing",
    "known_robot_weighing",
    "solve_weighing",
    "weigh_by_joints",
]
