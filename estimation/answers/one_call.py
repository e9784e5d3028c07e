"""One call for one question: recordings in, the result out, with what it was made from as ``result.working``."""

from collections.abc import Sequence

from ...common.errors import InputError
from ...model import Recording, Robot
from ..fit.estimate import Estimate
from ..fit.settings import DEFAULTS, Settings
from ..gains.known_load import KnownLoad
from ..gains.problem import gain_problem
from ..payload.problem import payload_problem
from ..payload.weighing import difference_weighing, known_robot_weighing
from ..possible.constraints import Constraint
from ..possible.payload import POSSIBLE
from ..results.payload import PayloadResult
from ..results.robot import GainsResult, RobotResult
from .gains import answer_gains
from .payload import answer_payload


def identify_payload(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: RobotResult | Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify a payload from motions of every joint, by the paper's four methods (22) to (30), and judge it.

    Args:
        loaded: recordings with the payload.
        unloaded: recordings without; the k-th of the same trajectory as the k-th of ``loaded`` for method 3.
        known: the robot's parameters from an earlier identification, instead of ``unloaded`` or beside them: its
            result, or the estimate of the same robot's base parameters.
        constraints: what is known of the payload; that it can exist is always demanded.

    Raises:
        InputError: if the recordings cannot be used, or show no payload.
        SolverError: if no body that holds the constraints comes near the data.
    """
    _check_lists(loaded, unloaded)
    robot, stored = _described(robot, known)
    problem = payload_problem(robot, loaded, unloaded, stored, settings)
    return answer_payload(problem, constraints=constraints).result


def weigh(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: RobotResult | Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify what a short motion near one pose shows of a payload, and judge each quantity.

    Torque differences answer where there are recordings without payload; the robot's parameters, where they are
    known too, are compared with them.

    Args:
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.
        known: the robot's parameters from an earlier identification, instead of ``unloaded`` or beside them: its
            result, or the estimate of the same robot's base parameters.
        constraints: what is known of the payload; that it can exist is always demanded.

    Raises:
        InputError: if the recordings cannot be used, or nothing shows the mass.
        SolverError: if no body that holds the constraints comes near the data.
    """
    _check_lists(loaded, unloaded)
    problems, (robot, stored) = [], _described(robot, known)
    if unloaded:
        problems.append(difference_weighing(robot, loaded, unloaded, settings))
    if stored is not None:
        problems.append(known_robot_weighing(robot, loaded, stored, settings))
    if not problems:
        raise InputError(
            "give recordings without payload or the robot's parameters: without either nothing can be compared"
        )
    settings.progress("estimating")
    first, *others = problems
    return answer_payload(first, constraints=constraints, gains=settings.gains, others=others).result


def identify_gains(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> GainsResult:
    """Identify drive gains from motor currents without and with a weight that is known, and judge them.

    Args:
        loaded: recordings with the weight, whose ``torque`` holds motor currents [A].
        unloaded: the same without it.
        load: the weight, or that of each mounting.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    _check_lists(loaded, unloaded)
    return answer_gains(gain_problem(robot, unloaded, loaded, settings, load, mounting), load).result


def _check_lists(*groups: Sequence[Recording]) -> None:
    """Refuse a recording where a list of them is meant."""
    if any(isinstance(group, Recording) for group in groups):
        raise InputError("a single recording: give a list of recordings, [recording]")


def _described(robot: Robot, known: RobotResult | Estimate | None) -> tuple[Robot, Estimate | None]:
    """The robot as an earlier identification described it, which must be of this one, and its parameters."""
    if isinstance(known, RobotResult):
        return known.applied_to(robot), known.estimate
    if known is not None and not isinstance(known, Estimate):
        raise InputError(f"known: give the result or the estimate of an identification, not {type(known).__name__}")
    return robot, known
