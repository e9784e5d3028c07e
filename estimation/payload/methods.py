"""The paper's four methods by number."""

from functools import partial

from .frame import in_payload_frame
from .from_change import from_change
from .from_difference import from_difference
from .from_robot import from_robot
from .global_fit import global_fit
from .problem import PayloadProblem
from .result import PayloadEstimate
from .robust import Method, with_robust

METHODS: dict[int, Method] = {
    1: from_robot,
    2: from_change,
    3: from_difference,
    4: global_fit,
}
"""The paper's methods by number."""


def identify_payload(problem: PayloadProblem, method: int, free_friction: bool = False) -> PayloadEstimate:
    """Estimate the payload by one method; with robust standard deviations if the problem has ``blocks``.

    Args:
        problem: the reduced recordings.
        method: 1 robot known (22)-(23), 2 change of the base parameters (24)-(28), 3 torque difference (29),
            4 robot and payload together (30).
        free_friction: method 1 only: estimate friction anew under load.

    Raises:
        InputError: if the problem lacks what the method needs.
        KeyError: for another method.
    """
    solve = method_of(method, free_friction)
    estimate, reason = with_robust(problem, solve, solve(problem, None))
    estimate = in_payload_frame(problem.robot, estimate)
    return PayloadEstimate(method, estimate, problem.robot.payload_frame, reason)


def method_of(number: int, free_friction: bool = False) -> Method:
    """The method by its number; the first may estimate friction anew under load."""
    return partial(from_robot, free_friction=free_friction) if number == 1 else METHODS[number]


def usable_methods(problem: PayloadProblem) -> tuple[int, ...]:
    """Methods for which the problem holds what they need."""
    bare = problem.unloaded is not None
    usable = {1: bare or problem.known is not None, 2: bare, 3: problem.difference is not None, 4: bare}
    return tuple(method for method, there in usable.items() if there)
