"""Which method's payload to use: the one with the least expected error, that of the robot's model included.

On one path method 3 cancels what the robot's model lacks, and weighs the joints by what is left then; methods 1, 2
and 4 carry it. Where the paths differ, method 3 takes off what the robot itself needs more on one of them, with an
error that method 4, which uses every equation, does not have.
"""

from collections.abc import Iterable
from typing import NamedTuple

from .methods import PayloadProblem

PREFERRED = (3, 4, 1, 2)
"""The methods in the order of their expected errors, where each can be used and a pair ran one path."""
ONE_PATH = 2e-3
"""rad or m: positions of a pair that differ by more, rms of the worst joint, are not of one path."""


class Recommendation(NamedTuple):
    """``method``: whose payload to use; ``reason``: why, where others are there too, else empty."""

    method: int
    reason: str


def recommended_method(problem: PayloadProblem, methods: Iterable[int]) -> Recommendation:
    """Recommend one of the methods, never by the shortest interval: that would choose too short ones.

    Args:
        problem: the recordings.
        methods: those that gave a payload, one at least.
    """
    there = sorted(methods, key=PREFERRED.index)
    apart = max((pair.rms_mismatch for pair in problem.source.compared), default=float("inf"))
    if there[:2] == [3, 4] and apart > ONE_PATH:
        there.remove(3)
    method, reason = there[0], ""
    if len(there) > 1 and method == 3:
        unit = "mrad" if all(joint.revolute for joint in problem.robot.joints) else "mrad or mm"
        reason = f"one path, within {max(1e3 * apart, 0.01):.2g} {unit}, so what the model lacks cancels"
    elif len(there) > 1 and method == 4 and apart > ONE_PATH:
        which = "not every pair" if len(problem.source.compared) > 1 else "no pair"
        reason = f"{which} ran one path, so all equations count at once"
    return Recommendation(method, reason)
