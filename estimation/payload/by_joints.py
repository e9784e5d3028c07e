"""The mass as single joints see it: the sharpest free test of drive gains, friction and description.

Each joint's equations alone, all ten parameters of the payload unknown. A joint whose equations leave the mass
undetermined, alone or in combination with other parameters, does not see it: no number is given then.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...model.arrays import Array
from ..estimate import Estimate
from ..problem import RANK_TOLERANCE, ReducedProblem
from .equations import PAYLOAD
from .problem import PayloadProblem

_HIDDEN = 1e-6
"""Share of the mass in an undetermined direction above which it is not visible."""


@dataclass(frozen=True)
class JointsMass:
    """The mass as some joints see it.

    Attributes:
        joints: their numbers.
        mass: [kg]; None where they do not see it.
        sigma: standard deviation [kg], the larger of the formula's and the block jackknife's.
        quantile95: half width of a 95 % interval in standard deviations.
    """

    joints: tuple[int, ...]
    mass: float | None
    sigma: float = float("nan")
    quantile95: float = float("nan")

    @property
    def visible(self) -> bool:
        """Whether the joints' torques hold the mass."""
        return self.mass is not None

    @cached_property
    def interval95(self) -> tuple[float, float] | None:
        """95 % interval [kg]; drive gains taken as exact."""
        if self.mass is None:
            return None
        half = self.quantile95 * self.sigma
        return self.mass - half, self.mass + half

    @property
    def name(self) -> str:
        """ "joint 3" or "joints 4-6"."""
        if len(self.joints) == 1:
            return f"joint {self.joints[0]}"
        return f"joints {self.joints[0]}-{self.joints[-1]}"


def joint_groups(n: int) -> tuple[tuple[int, ...], ...]:
    """Every joint alone, and the arm's and the wrist's together (all but the last three, the last three)."""
    alone = tuple((joint,) for joint in range(1, n + 1))
    if n <= 3:
        return alone
    return (*alone, tuple(range(1, n - 2)), tuple(range(n - 2, n + 1)))


def mass_by_joints(problem: PayloadProblem, weights: Array) -> tuple[JointsMass, ...]:
    """The mass as every joint alone and as groups of joints see it.

    Torque differences (29) where there are pairs; otherwise each group's own equations without and with payload
    together (30); with a robot known from earlier, the loaded equations less its torque.

    Args:
        problem: the reduced recordings.
        weights: per joint [1/(N·m) or 1/N]; they matter within a group only.
    """
    return tuple(_weighed(problem, group, weights) for group in joint_groups(problem.robot.n))


def _weighed(problem: PayloadProblem, joints: tuple[int, ...], weights: Array) -> JointsMass:
    places = [joint - 1 for joint in joints]
    whole = _equations(problem, places, weights)
    if whole is None:
        return JointsMass(joints, None)
    weigh = _visible_mass(whole)
    if weigh is None:
        return JointsMass(joints, None)
    mass, variance = weigh
    variance += _robots_share(problem, places, weights)
    changes, quantile = _without_blocks(problem, places, weights, mass)
    return JointsMass(joints, mass, float(np.sqrt(max(variance, changes))), quantile)


@dataclass(frozen=True)
class _Equations:
    """A factor of weighted equations, its last ten columns before the torque those of ``PAYLOAD``."""

    factor: Array
    rows: float


def _equations(problem: PayloadProblem, joints: Sequence[int], weights: Array) -> _Equations | None:
    """What a group of joints says about the payload; None where nothing is left."""
    if problem.difference is not None:
        parts = [problem.difference]
    elif problem.unloaded is not None:
        parts = [problem.unloaded.renamed(problem.loaded.columns), problem.loaded]
    elif problem.known is not None:
        parts = [_less_robot(problem.loaded, problem.known)]
    else:
        return None
    factor = np.vstack([weights[j] * part.factors[j] for part in parts for j in joints])
    rows = sum(part.effective_rows[j] for part in parts for j in joints)
    return _Equations(factor, rows) if len(factor) else None


def _less_robot(loaded: ReducedProblem, known: Estimate) -> ReducedProblem:
    k = len(known.values)
    factors = tuple(np.column_stack([f[:, k:-1], f[:, -1] - f[:, :k] @ known.values]) for f in loaded.factors)
    return ReducedProblem(PAYLOAD, factors, loaded.rows, loaded.effective_rows)


def _visible_mass(equations: _Equations) -> tuple[float, float] | None:
    """Mass and the formula's variance; None where the equations leave it undetermined."""
    direction = _mass_row(equations.factor[:, :-1])
    if direction is None:
        return None
    values, rank = direction
    Y = equations.factor[:, -1]
    error = Y - _projected(equations.factor[:, :-1], Y)
    spare = max(equations.rows - rank, 1.0)
    return float(values @ Y), float(error @ error) / spare * float(values @ values)


def _mass_row(A: Array) -> tuple[Array, int] | None:
    """a with M = a'Y for the mass, the last column of A, and the rank; None where A does not determine it."""
    norms = np.linalg.norm(A, axis=0)
    if norms[-1] == 0.0:
        return None
    seen = norms > 0.0
    U, singular, Vt = np.linalg.svd(A[:, seen] / norms[seen], full_matrices=False)
    kept = singular > RANK_TOLERANCE * singular[0]
    along = Vt[kept, -1]
    if 1.0 - float(along @ along) > _HIDDEN:
        return None
    return np.asarray(U[:, kept] @ (along / singular[kept]) / norms[-1]), int(kept.sum())


def _projected(A: Array, Y: Array) -> Array:
    norms = np.linalg.norm(A, axis=0)
    norms[norms == 0.0] = 1.0
    return np.asarray(A @ (np.linalg.lstsq(A / norms, Y, rcond=RANK_TOLERANCE)[0] / norms))


def _robots_share(problem: PayloadProblem, joints: Sequence[int], weights: Array) -> float:
    """Variance of the mass that comes from a robot known from earlier."""
    if problem.difference is not None or problem.unloaded is not None or problem.known is None:
        return 0.0
    k = len(problem.known.values)
    stacked = np.vstack([weights[j] * problem.loaded.factors[j] for j in joints])
    direction = _mass_row(stacked[:, k:-1])
    if direction is None:
        return 0.0
    gain = direction[0] @ stacked[:, :k]
    return float(gain @ problem.known.covariance @ gain)


def _without_blocks(
    problem: PayloadProblem, joints: Sequence[int], weights: Array, mass: float
) -> tuple[float, float]:
    """Jackknife variance of the mass, and the quantile of its 95 % interval."""
    variance, fewest = 0.0, 0
    for group in _deletions(problem):
        parts = [_equations(part, joints, weights) for part in group]
        masses = [weigh[0] for part in parts if part is not None and (weigh := _visible_mass(part)) is not None]
        if len(masses) < 2:
            continue
        variance += (1.0 - 1.0 / len(masses)) * float(np.sum((np.array(masses) - mass) ** 2))
        fewest = len(masses) if not fewest else min(fewest, len(masses))
    return variance, _quantile(fewest)


def _quantile(blocks: int) -> float:
    from scipy.special import ndtri, stdtrit

    return float(stdtrit(blocks - 1, 0.975)) if blocks > 1 else float(ndtri(0.975))


def _deletions(problem: PayloadProblem) -> Iterator[Iterator[PayloadProblem]]:
    from .robust import deletions

    return iter(deletions(problem)) if problem.blocks is not None else iter(())
