"""The problem of drive gains: currents without and with a payload, reduced."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...model import BaseParameters, InputError, Processing, Recording, Robot
from ...model.arrays import Array
from ..payload.problem import PayloadProblem, payload_problem
from ..problem import ReducedProblem, merged
from ..progress import Progress, silent
from .free import free_gains
from .known_load import known_mass

_FLOOR = 1e-9  # of the current: data without noise still need finite weights


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
    """

    robot: Robot
    base: BaseParameters
    equations: ReducedProblem
    weights: Array
    deletions: tuple[tuple[ReducedProblem, ...], ...] = ()
    block_length: float = 0.0
    without_blocks: str = ""


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
        raise InputError(f"{robot.name} has a gravity spring: gains of such an arm are not identified from currents")
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        raise InputError(
            f"joints {j} and {k} of {robot.name} share their drives: no one current belongs to one joint's torque; "
            "gains of such an arm are not identified"
        )
    if not unloaded:
        raise InputError("drive gains need recordings without and with the payload: give both")
    first = payload_problem(robot, loaded, unloaded, None, processing, progress)
    assert first.unloaded is not None
    both = _together(first.loaded, first.unloaded)
    weights = current_weights(both)
    # How long residuals remember shows only once the joints' torques are to scale; all of them by one factor is enough.
    K = 1.0 / free_gains(both, known_mass(1.0), weights).k
    K /= K.mean()
    scaled = [[replace(r, torque=r.torque * K) for r in recordings] for recordings in (loaded, unloaded)]
    problem = payload_problem(robot, scaled[0], scaled[1], None, processing, progress, robust=True)
    deletions, length, reason = _deletions(problem)
    deletions = tuple(tuple(_in_currents(part, K) for part in group) for group in deletions)
    return GainProblem(robot, first.base, both, weights, deletions, length, reason)


def current_weights(equations: ReducedProblem) -> Array:
    """One over the standard deviation of each joint's error [1/A], shape (n,).

    From the joint's own equations with parameters of their own, so that neither gains nor other joints matter.
    """
    sigma = []
    for factor, rows in zip(equations.factors, equations.effective_rows, strict=True):
        W, d = factor[:, :-1], factor[:, -1]
        scale = np.linalg.norm(W, axis=0)
        scale[scale == 0.0] = 1.0
        x, _, rank, _ = np.linalg.lstsq(W / scale, d, rcond=1e-10)
        error = np.linalg.norm(d - (W / scale) @ x) / np.sqrt(max(rows - rank, 1.0))
        sigma.append(max(float(error), _FLOOR * float(np.linalg.norm(d)) / np.sqrt(max(rows, 1.0))))
    return 1.0 / np.array(sigma)


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
