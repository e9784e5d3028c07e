"""The payload as single joints see it: the sharpest free test of drive gains, friction and description.

By torque differences (29) where there are pairs, otherwise by the loaded torques less the robot's (23).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import Decomposition, decomposed
from ..fit.least_squares import weighted
from ..fit.robust import student95
from .problem import FixedWeights, PayloadProblem
from .robust import deletions

WITHOUT_BLOCKS = 4.0
"""Factor on the formula's standard deviations where no jackknife is possible: on real data they are up to 4.1 times
too small."""
_BLURRED = 0.05
"""Share of noise in the torque that the other joints' payload predicts, above which a factor on it says nothing."""
_HIDDEN = 1e-6
"""Share of the mass in undetermined directions above which it is not visible."""


@dataclass(frozen=True)
class JointsMass:
    """The mass by the equations of some joints alone, all ten parameters of the payload unknown.

    Attributes:
        joints: their numbers.
        mass: [kg]; None where their torques leave it undetermined, alone or together with other parameters.
        sigma: standard deviation [kg], the larger of the formula's and the block jackknife's, or ``WITHOUT_BLOCKS``
            times the formula's; gains as exact.
        degrees_of_freedom: of Student's t for the interval.
    """

    joints: tuple[int, ...]
    mass: float | None
    sigma: float = float("nan")
    degrees_of_freedom: float = float("inf")

    @cached_property
    def interval95(self) -> tuple[float, float] | None:
        """95 % interval [kg]."""
        if self.mass is None:
            return None
        half = student95(self.degrees_of_freedom) * self.sigma
        return self.mass - half, self.mass + half

    @property
    def name(self) -> str:
        """The joints in words: "joint 3" or "joints 4-6"."""
        if len(self.joints) == 1:
            return f"joint {self.joints[0]}"
        if self.joints == tuple(range(self.joints[0], self.joints[-1] + 1)):
            return f"joints {self.joints[0]}-{self.joints[-1]}"
        return f"joints {', '.join(map(str, self.joints))}"


@dataclass(frozen=True)
class JointShare:
    """How much of the payload a joint shows: 1 where its torque is what the other joints' payload demands.

    Attributes:
        joint: its number.
        share: factor on the torque that the payload identified by all other joints causes there; None where they
            determine it too badly.
        sigma: standard deviation, the larger of the formula's and the block jackknife's.
    """

    joint: int
    share: float | None
    sigma: float = float("nan")


@dataclass(frozen=True)
class ByJoints:
    """The payload as single joints see it.

    Attributes:
        masses: by every joint alone, then by the arm's and by the wrist's joints together.
        shares: of every joint against the others.
    """

    masses: tuple[JointsMass, ...]
    shares: tuple[JointShare, ...]


def joint_groups(n: int) -> tuple[tuple[int, ...], ...]:
    """Every joint alone, and the arm's and the wrist's together (all but the last three, the last three)."""
    alone = tuple((joint,) for joint in range(1, n + 1))
    if n <= 3:
        return alone
    return (*alone, tuple(range(1, n - 2)), tuple(range(n - 2, n + 1)))


def payload_by_joints(problem: PayloadProblem, weights: FixedWeights) -> ByJoints:
    """Mass and share by joints, with standard deviations that hold for autocorrelated noise if there are blocks.

    Args:
        problem: the reduced recordings.
        weights: per joint; they matter within a group only.
    """
    n = problem.robot.n

    def parts() -> list[Iterator[JointEquations]]:
        if problem.blocks is None:
            raise InputError("no blocks of time")
        return [(_equations(part, weights) for part in group) for group in deletions(problem)]

    return joints_view(_equations(problem, weights), parts, joint_groups(n), range(1, n + 1))


def joints_view(
    whole: "JointEquations",
    parts: "Callable[[], Sequence[Iterable[JointEquations]]]",
    groups: Sequence[tuple[int, ...]],
    joints: Sequence[int],
) -> ByJoints:
    """Masses by groups of joints, shares of single ones.

    Args:
        whole: the equations.
        parts: gives the same without each block of time, group by group of blocks that are left out together;
            raises InputError where there are too few.
        groups: of joints, for the masses.
        joints: for the shares, each against all others with equations.
    """
    numbers: list[Callable[[JointEquations], _Number | None]] = [_mass_of(group) for group in groups]
    numbers += [_share_of(joint) for joint in joints]
    found = [number(whole) for number in numbers]
    variances, dof = _variances(parts, numbers, found)
    sigmas = [float(np.sqrt(v)) for v in variances]
    masses = [
        JointsMass(group, one.value, sigma, dof) if one else JointsMass(group, None)
        for group, one, sigma in zip(groups, found, sigmas, strict=False)
    ]
    k = len(groups)
    shares = [
        JointShare(joint, one.value if one else None, sigma)
        for joint, one, sigma in zip(joints, found[k:], sigmas[k:], strict=True)
    ]
    return ByJoints(tuple(masses), tuple(shares))


class _Number(NamedTuple):
    """``variance`` by the formula; ``known``: the part of it from a robot known earlier, which no block shows."""

    value: float
    variance: float
    known: float = 0.0


class JointEquations(NamedTuple):
    """Per joint weighted factors [W_L Y] of the payload, and W of a robot that was subtracted, C its covariance.

    ``known``: whether the robot was known earlier.
    """

    payload: tuple[Array, ...]
    robot: tuple[Array, ...]
    C: Array
    rows: tuple[float, ...]
    known: bool = False


def _equations(problem: PayloadProblem, weights: FixedWeights) -> JointEquations:
    if problem.difference is not None:
        own, factors = problem.difference, problem.difference.factors
        payload = tuple(w * factor for w, factor in zip(weights.own, factors, strict=True))
        return JointEquations(payload, tuple(f[:, :0] for f in payload), np.zeros((0, 0)), own.effective_rows)
    known = problem.known
    if known is None:
        assert problem.unloaded is not None
        known = weighted(problem.unloaded, weights.robot)
    k = len(known.values)
    loaded = tuple(w * factor for w, factor in zip(weights.own, problem.loaded.factors, strict=True))
    rest = tuple(np.column_stack([f[:, k:-1], f[:, -1] - f[:, :k] @ known.values]) for f in loaded)
    C = known.robust.covariance if known.robust is not None else known.covariance
    robot, rows = tuple(f[:, :k] for f in loaded), problem.loaded.effective_rows
    return JointEquations(rest, robot, C, rows, problem.known is not None)


def _mass_of(joints: Sequence[int]) -> Callable[[JointEquations], _Number | None]:
    places = [joint - 1 for joint in joints]

    def mass(equations: JointEquations) -> _Number | None:
        factor = np.vstack([equations.payload[j] for j in places])
        parts = decomposed(factor[:, :-1])
        return _number(equations, places, factor, parts, -1) if parts.hidden[-1] <= _HIDDEN else None

    return mass


def _share_of(joint: int) -> Callable[[JointEquations], _Number | None]:
    own = joint - 1

    def share(equations: JointEquations) -> _Number | None:
        others = [j for j in range(len(equations.payload)) if j != own]
        factor = np.vstack([equations.payload[j] for j in others])
        parts = decomposed(factor[:, :-1])
        if parts.hidden.max() > _HIDDEN:
            return None
        inverse = parts.inverse
        x = inverse @ factor[:, -1]
        A, y = equations.payload[own][:, :-1], equations.payload[own][:, -1]
        predicted = A @ x
        # Errors of the others' payload are part of the error of what is predicted; large ones bias the factor.
        noise = A @ inverse @ inverse.T @ A.T
        if not np.trace(noise) < _BLURRED * float(predicted @ predicted):
            return None
        whitened = np.linalg.solve(np.eye(len(A)) + noise, predicted)
        size = float(whitened @ predicted)
        return _Number(float(whitened @ y) / size, 1.0 / size)

    return share


def _number(
    equations: JointEquations, places: Sequence[int], factor: Array, parts: Decomposition, k: int
) -> _Number:
    """Parameter k of [A Y], A decomposed, with the variance of the residual and of the robot's parameters."""
    Y, row = factor[:, -1], parts.inverse[k]
    error = Y - factor[:, :-1] @ parts.solution(Y)
    spare = max(sum(equations.rows[j] for j in places) - parts.rank, 1.0)
    gain = row @ np.vstack([equations.robot[j] for j in places])
    robots = float(gain @ equations.C @ gain)
    own = float(error @ error) / spare * float(row @ row)
    return _Number(float(row @ Y), own + robots, robots if equations.known else 0.0)


_Parts = Callable[[], Sequence[Iterable[JointEquations]]]
_Numbers = Sequence[Callable[[JointEquations], _Number | None]]


def _variances(parts: _Parts, numbers: _Numbers, found: Sequence[_Number | None]) -> tuple[Array, float]:
    """The larger of the formula's variance and the jackknife's of each number, and the degrees of freedom."""
    formula = np.array([one.variance if one else np.nan for one in found])
    try:
        variances, dof = _jackknife(parts(), numbers, found)
    except InputError:  # too few blocks
        return WITHOUT_BLOCKS**2 * formula, float("inf")
    known = np.array([one.known if one else np.nan for one in found])
    return np.maximum(formula, variances + known), dof


def _jackknife(
    groups: Sequence[Iterable[JointEquations]], numbers: _Numbers, found: Sequence[_Number | None]
) -> tuple[Array, float]:
    """Variance of each number by leaving out blocks, and the degrees of freedom."""
    variances, fewest = np.zeros(len(numbers)), np.inf
    for group in groups:
        rows = []
        for equations in group:
            values = [number(equations) if one else None for number, one in zip(numbers, found, strict=True)]
            rows.append([value.value if value else np.nan for value in values])
        changes = np.array(rows) - [one.value if one else np.nan for one in found]
        variances += (1.0 - 1.0 / len(rows)) * np.nansum(changes**2, axis=0)
        fewest = min(fewest, len(rows))
    return variances, max(fewest - 1.0, 1.0)
