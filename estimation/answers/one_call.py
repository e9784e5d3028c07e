"""One call for one question: recordings in, the result out, with what it was made from as ``result.working``."""

from collections.abc import Sequence

from ...common.errors import InputError
from ...model import Recording, Robot
from ..fit.estimate import Estimate
from ..fit.settings import DEFAULTS, Settings
from ..gains.known_load import KnownLoad
from ..gains.problem import gain_problem
from ..payload.long_motion import payload_problem
from ..payload.weighing import difference_weighing, known_robot_weighing
from ..possible.constraints import Constraint
from ..possible.payload import POSSIBLE
from ..results.payload import PayloadResult
from ..results.robot import GainsResult
from .gains import answer_gains
from .payload import answer_payload


def identify_payload(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify a payload from motions of every joint, by the paper's four methods (22) to (30), and judge it.

    Args:
        loaded: recordings with the payload.
        unloaded: recordings without; the k-th of the same trajectory as the k-th of ``loaded`` for method 3.
        known: the robot's parameters from an earlier identification, instead of ``unloaded`` or beside them.
        constraints: what is known of the payload; that it can exist is always demanded.

    Raises:
        InputError: if the recordings cannot be used, or show no payload.
        SolverError: if no body that holds the constraints comes near the data.
    """
    problem = payload_problem(robot, loaded, unloaded, known, settings)
    return answer_payload(problem, constraints=constraints).result


def weigh(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: Estimate | None = None,
    constraints: Sequence[Constraint] = POSSIBLE,
    settings: Settings = DEFAULTS,
) -> PayloadResult:
    """Identify what a short motion near one pose shows of a payload, and judge each quantity.

    Torque differences answer where there are recordings without payload; the robot's parameters, where they are
    known too, are compared with them.

    Args:
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.
        known: the robot's parameters from an earlier identification, instead of ``unloaded`` or beside them.
        constraints: what is known of the payload; that it can exist is always demanded.

    Raises:
        InputError: if the recordings cannot be used, or nothing shows the mass.
        SolverError: if no body that holds the constraints comes near the data.
    """
    problems = []
    if unloaded:
        problems.append(difference_weighing(robot, loaded, unloaded, settings))
    if known is not None:
        problems.append(known_robot_weighing(robot, loaded, known, settings))
    if not problems:
        raise InputError(
            "give recordings without payload or the robot's parameters: without either nothing can be compared"
        )
    settings.progress("estimating")
    first, *others = problems
    return answer_payload(first, constraints=constraints, gains=settings.gains, others=others).result


def identify_gains(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> GainsResult:
    """Identify drive gains from motor currents without and with a weight that is known, and judge them.

    Args:
        unloaded: recordings without the weight, whose ``torque`` holds motor currents [A].
        loaded: the same with it.
        load: the weight, or that of each mounting.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    return answer_gains(gain_problem(robot, unloaded, loaded, settings, load, mounting), load).result
