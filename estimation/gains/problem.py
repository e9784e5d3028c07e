"""The problem of drive gains: currents without and with a payload, reduced."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...model import BaseParameters, InputError, Processing, Recording, Robot
from ...model.arrays import Array
from ..names import PAYLOAD
from ..payload.problem import PayloadProblem, payload_problem
from ..problem import ReducedProblem, merged
from ..progress import Progress, silent
from .current_side import CurrentFit, current_weights, gauss_newton
from .known_load import KnownLoad, known_mass
from .same_recordings import GainRecordings

_USUAL = 10.0  # N·m/A: the size of an arm's gains, so that checks of torques see torques; divided out again


@dataclass(frozen=True)
class GainProblem:
    """Equations i_j = k_j (W_j chi + W_Lj chi_L) + rho_j, joint by joint, k_j = 1 / K_j.

    Attributes:
        robot: the robot.
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
    equations: ReducedProblem
    weights: Array
    deletions: tuple[tuple[ReducedProblem, ...], ...] = ()
    block_length: float = 0.0
    without_blocks: str = ""
    recordings: GainRecordings = GainRecordings()


def gain_problem(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
) -> GainProblem:
    """Process recordings of currents and reduce them.

    Args:
        robot: the robot.
        unloaded: recordings without payload whose ``torque`` holds motor currents [A].
        loaded: the same with the known payload.
        processing: settings; the robot's own by default.
        progress: told what is being worked on.

    Raises:
        InputError: if the recordings cannot be used, or the robot's drives do not give one torque per current.
    """
    if robot.spring is not None:
        raise InputError(
            f"{robot.name} has a gravity spring: gains of such an arm are not identified from currents"
        )
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        raise InputError(
            f"joints {j} and {k} of {robot.name} share their drives: no one current belongs to one joint's torque; "
            "gains of such an arm are not identified"
        )
    if not unloaded:
        raise InputError("drive gains need recordings without and with the payload: give both")
    scaled = _scaled(loaded, unloaded, np.full(robot.n, _USUAL))
    first = payload_problem(robot, *scaled, None, processing, progress)
    assert first.unloaded is not None
    both = _in_currents(_together(first.loaded, first.unloaded), np.full(robot.n, _USUAL))
    weights = current_weights(both)
    # How long residuals remember shows only once the joints' torques are to scale; all of them by one factor is
    # enough.
    K = 1.0 / free_gains(both, weights, known_mass(1.0)).k
    K *= _USUAL / K.mean()
    problem = payload_problem(robot, *_scaled(loaded, unloaded, K), None, processing, progress, robust=True)
    deletions, length, reason = _deletions(problem)
    deletions = tuple(tuple(_in_currents(part, K) for part in group) for group in deletions)
    recordings = GainRecordings.of(unloaded, loaded)
    return GainProblem(robot, first.base, both, weights, deletions, length, reason, recordings)


def free_gains(equations: ReducedProblem, weights: Array, load: KnownLoad) -> CurrentFit:
    """Gains, base parameters and what is unknown of the payload, without constraints.

    Raises:
        InputError: if the recordings leave a gain undetermined, or one is negative.
    """
    free = [k for k, name in enumerate(equations.columns) if name not in load.known]
    known = np.zeros(len(equations.columns))
    known[-len(PAYLOAD) :] = load.ten
    found = gauss_newton(equations, weights, free, known)
    wrong = [str(j) for j, value in enumerate(found.k, 1) if value <= 0.0]
    if wrong:
        raise InputError(
            f"the current of joint {', '.join(wrong)} pushes against its motion: turn its sign (--signs, or sign "
            "in a log map), or check the order of joints"
        )
    return found


def _scaled(
    loaded: Sequence[Recording], unloaded: Sequence[Recording], K: Array
) -> tuple[list[Recording], list[Recording]]:
    """The recordings with torques that gains K would give."""
    with_payload, without = ([replace(r, torque=r.torque * K) for r in group] for group in (loaded, unloaded))
    return with_payload, without


def _in_currents(problem: ReducedProblem, K: Array) -> ReducedProblem:
    """Right-hand sides over K_j."""
    factors = []
    for factor, gain in zip(problem.factors, K, strict=True):
        factors.append(factor / np.append(np.ones(factor.shape[1] - 1), gain))
    return replace(problem, factors=tuple(factors))


def _together(loaded: ReducedProblem, unloaded: ReducedProblem) -> ReducedProblem:
    return merged([loaded, unloaded.renamed(loaded.columns)])


def _deletions(problem: PayloadProblem) -> tuple[tuple[tuple[ReducedProblem, ...], ...], float, str]:
    """The equations without each block; blocks of one motion are left out together."""
    blocks, bare = problem.blocks, problem.unloaded
    if blocks is None or bare is None:
        return (), 0.0, problem.without_blocks
    try:
        if blocks.difference:
            pairs = zip(blocks.loaded_without, blocks.unloaded_without, strict=True)
            return (tuple(_together(*pair) for pair in pairs),), blocks.length, ""
        loaded = tuple(_together(part, bare) for part in blocks.loaded_without)
        unloaded = tuple(_together(problem.loaded, part) for part in blocks.unloaded_without)
    except InputError as error:
        return (), 0.0, str(error)
    return (loaded, unloaded), blocks.length, ""
