"""The problem of drive gains: currents without and with a payload, reduced."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.paged import empty, parts
from ...common.progress import Progress, silent
from ...model import BaseParameters, Processing, Recording, Robot
from ...model.drives import SPRING
from ...model.names import parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..fit.drive_gains import Fingerprints, fingerprints
from ..payload.long_motion import payload_problem
from ..payload.problem import PayloadProblem
from .current_side import CurrentFit, current_weights, gauss_newton
from .known_load import KnownLoad, known_mass

_USUAL = 10.0  # N·m/A: the size of an arm's gains, so that checks of torques see torques; divided out again


@dataclass(frozen=True)
class GainProblem:
    """Equations i_j = k_j (W_j chi + W_Lj chi_L) + rho_j, motor by motor, k_j = 1 / K_j.

    Of coupled drives W_j are the rows of the motors on the joint side; a known spring is a column of W whose
    parameter is 1.

    Attributes:
        robot: the robot, its equations those of the motors (``Robot.for_currents``).
        base: its base parameters.
        equations: the factors of [W W_L i], columns base, then ``PAYLOAD``; the right-hand side is a current [A].
        weights: per joint, one over the standard deviation of its current's error [1/A].
        deletions: the equations without each block of time, for the jackknife; one tuple a group.
        block_length: of those blocks [s]; 0 where there are none.
        without_blocks: why there are none.
        recordings: by which later recordings are known for the same.
    """

    robot: Robot
    base: BaseParameters
    equations: Equations
    weights: Array
    deletions: tuple[tuple[Equations, ...], ...] = ()
    block_length: float = 0.0
    without_blocks: str = ""
    recordings: Fingerprints = field(default_factory=dict)


def gain_problem(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
    load: KnownLoad | None = None,
) -> GainProblem:
    """Process recordings of currents and reduce them.

    Args:
        robot: the robot.
        unloaded: recordings without payload whose ``torque`` holds motor currents [A].
        loaded: the same with the known payload.
        processing: settings; the robot's own by default.
        progress: told what is being worked on.
        load: the known payload; needed by arms with a spring alone, whose known torque has a scale as well.

    Raises:
        InputError: if the recordings cannot be used.
    """
    robot = robot.for_currents()
    if not unloaded:
        raise InputError("drive gains need recordings without and with the payload: give both")
    scaled = _scaled(robot, loaded, unloaded, np.full(robot.n, _USUAL))
    first = payload_problem(robot, *scaled, None, processing, progress)
    both = _in_currents(first.both, np.full(robot.n, _USUAL))
    weights = current_weights(both)
    # How long residuals remember shows only once the joints' torques are to scale; all of them by one factor is
    # enough.
    K = 1.0 / free_gains(both, weights, load or known_mass(1.0)).k
    K *= _USUAL / K.mean()
    problem = payload_problem(robot, *_scaled(robot, loaded, unloaded, K), None, processing, progress, robust=True)
    recordings = fingerprints(unloaded, loaded)
    return GainProblem(robot, first.base, both, weights, *_without_blocks(problem, K), recordings)


def free_gains(equations: Equations, weights: Array, load: KnownLoad) -> CurrentFit:
    """Gains, base parameters and what is unknown of the payload, without constraints.

    Raises:
        InputError: if the recordings leave a gain undetermined, or one is negative.
    """
    springs = [k for k, name in enumerate(equations.columns) if parameter_kind(name) == SPRING]
    free = [k for k, name in enumerate(equations.columns) if name not in load.known and k not in springs]
    known = np.zeros(len(equations.columns))
    known[-len(PAYLOAD) :], known[springs] = load.ten, 1.0
    found = gauss_newton(equations, weights, free, known)
    wrong = [str(j) for j, value in enumerate(found.k, 1) if value <= 0.0]
    if wrong:
        raise InputError(
            f"the current of motor {', '.join(wrong)} pushes against its motion: turn its sign (--signs, or sign "
            "in a log map), or check the order of joints"
        )
    return found


def _scaled(
    robot: Robot, loaded: Sequence[Recording], unloaded: Sequence[Recording], K: Array
) -> tuple[list[Recording], list[Recording]]:
    """The recordings with joint torques that gains K would give."""
    with_payload, without = (
        [replace(one, torque=_torques(robot, one.torque, K)) for one in group] for group in (loaded, unloaded)
    )
    return with_payload, without


def _torques(robot: Robot, currents: Array, K: Array) -> Array:
    torque = empty(currents.shape)
    for part in parts(len(torque)):
        motors = currents[part] * K
        torque[part] = robot.coupling.joint_torques(motors) if robot.coupling else motors
    torque.setflags(write=False)
    return torque


def _in_currents(problem: Equations, K: Array) -> Equations:
    """Right-hand sides over K_j."""
    factors = []
    for factor, gain in zip(problem.factors, K, strict=True):
        factors.append(factor / np.append(np.ones(factor.shape[1] - 1), gain))
    return replace(problem, factors=tuple(factors))


def _without_blocks(problem: PayloadProblem, K: Array) -> tuple[tuple[tuple[Equations, ...], ...], float, str]:
    """The currents without each block, groups of them; the blocks' length; else why there are none."""
    try:
        groups = tuple(tuple(_in_currents(part.both, K) for part in group) for group in problem.without_blocks)
    except InputError as error:
        return (), 0.0, str(error)
    return groups, problem.loaded.block_length, ""
