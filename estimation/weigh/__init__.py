"""A payload from a short motion of a few joints near a pose."""

from .answer import Agreement, WeighAnswer, answer_weighing
from .following import Change, Following, FollowingChange, following_change, read_following
from .judge import USABLE, Judged
from .offsets import OFFSET_SHARE
from .problem import WeighProblem, difference_weighing, known_robot_weighing
from .repeats import Repeats
from .ripple import RIPPLE_CHANCE
from .run import Run
from .solve import WeighEstimate, solve_weighing, weigh_by_joints
from .stand_in import StandIn

__all__ = [
    "OFFSET_SHARE",
    "RIPPLE_CHANCE",
    "USABLE",
    "Agreement",
    "Change",
    "Following",
    "FollowingChange",
    "Judged",
    "Repeats",
    "Run",
    "StandIn",
    "WeighAnswer",
    "WeighEstimate",
    "WeighProblem",
    "answer_weighing",
    "difference_weighing",
    "following_change",
    "known_robot_weighing",
    "read_following",
    "solve_weighing",
    "weigh_by_joints",
]
