"""The payload as single joints see it: the sharpest free test of drive gains, friction and description.

By torque differences (29) where there are pairs, otherwise by the loaded torques less the robot's (23).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import Decomposition, decomposed
from ..equations.equations import PAYLOAD
from ..fit.covariance import jackknife, student95
from ..fit.linear_problem import LinearProblem
from .methods import PayloadProblem, from_difference, from_robot
from .short_motion import ShortMotion

_BLURRED = 0.05
"""Share of noise in the torque that the other joints' payload predicts, above which a factor on it says nothing."""
_HIDDEN = 1e-6
"""Share of the mass in undetermined directions above which it is not visible."""


class Number(NamedTuple):
    """``variance`` by the formula; ``lasting``: the part of it that no block of time shows."""

    value: float
    variance: float
    lasting: float = 0.0


class JointEquations(NamedTuple):
    """Per joint weighted factors [W_L Y] of the payload, and W of what was taken off.

    ``covariance`` of the parameters taken off; ``lasting``: of them, what no block of time shows.
    """

    payload: tuple[Array, ...]
    taken: tuple[Array, ...]
    covariance: Array
    lasting: Array
    rows: tuple[float, ...]

    @staticmethod
    def of(problem: LinearProblem, weights: Array) -> "JointEquations":
        """The payload's ten alone, for weights of the joints."""
        unknown = problem.unknown.select(PAYLOAD)
        factors = problem.equations.whole.select([name for group in problem.fixed for name in group.names]).factors
        lasting = _together([group.lasting for group in problem.fixed])
        # What an earlier identification's jackknife says counts instead of its formula.
        covariance = _together(
            [group.lasting if group.lasting.any() else group.covariance for group in problem.fixed]
        )
        return JointEquations(
            tuple(w * factor for w, factor in zip(weights, unknown.factors, strict=True)),
            tuple(w * factor[:, :-1] for w, factor in zip(weights, factors, strict=True)),
            covariance,
            lasting,
            unknown.effective_rows,
        )


def _together(covariances: Sequence[Array]) -> Array:
    """Covariance of independent groups of parameters."""
    return np.asarray(block_diag(*covariances)) if covariances else np.zeros((0, 0))


def mass_of(joints: Sequence[int]) -> Callable[[JointEquations], Number | None]:
    """Gives the mass by the equations of some joints (from 1); none where they leave it undetermined."""
    places = [joint - 1 for joint in joints]

    def mass(equations: JointEquations) -> Number | None:
        factor = np.vstack([equations.payload[j] for j in places])
        parts = decomposed(factor[:, :-1])
        return _number(equations, places, factor, parts, -1) if parts.hidden[-1] <= _HIDDEN else None

    return mass


def share_of(joint: int) -> Callable[[JointEquations], Number | None]:
    """Gives the share of the payload that a joint (from 1) shows; none where the others determine it too badly."""
    own = joint - 1

    def share(equations: JointEquations) -> Number | None:
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
        return Number(float(whitened @ y) / size, 1.0 / size)

    return share


def _number(
    equations: JointEquations, places: Sequence[int], factor: Array, parts: Decomposition, k: int
) -> Number:
    """Parameter k of [A Y], A decomposed, with the variance of the residual and of the parameters taken off."""
    Y, row = factor[:, -1], parts.inverse[k]
    error = Y - factor[:, :-1] @ parts.solution(Y)
    spare = max(sum(equations.rows[j] for j in places) - parts.rank, 1.0)
    gain = row @ np.vstack([equations.taken[j] for j in places])
    own = float(error @ error) / spare * float(row @ row)
    lasting = float(gain @ equations.lasting @ gain)
    return Number(float(row @ Y), own + float(gain @ equations.covariance @ gain), lasting)


WITHOUT_BLOCKS = 4.0
"""Factor on the formula's standard deviations where no jackknife is possible: on real data they are up to 4.1 times
too small."""


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
        without: the masses by all joints but one.
    """

    masses: tuple[JointsMass, ...]
    shares: tuple[JointShare, ...]
    without: tuple[JointsMass, ...] = ()


def joint_groups(n: int) -> tuple[tuple[int, ...], ...]:
    """Every joint alone, and the arm's and the wrist's together (all but the last three, the last three)."""
    alone = tuple((joint,) for joint in range(1, n + 1))
    if n <= 3:
        return alone
    return (*alone, tuple(range(1, n - 2)), tuple(range(n - 2, n + 1)))


def moving_groups(joints: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Every moving joint alone; then the arm's, those from the elbow on, the wrist's, and all together."""
    alone = [(joint,) for joint in joints]
    parts = [
        tuple(j for j in joints if j <= 3),
        tuple(j for j in joints if j >= 3),
        tuple(j for j in joints if j >= 4),
        tuple(joints),
    ]
    return tuple(dict.fromkeys([*alone, *(part for part in parts if len(part) > 1)]))


def payload_by_joints(problem: PayloadProblem, weights: Array) -> ByJoints:
    """Mass and share by joints, all ten unknown, with standard deviations that hold for autocorrelated noise.

    Args:
        problem: the reduced recordings; without blocks of time standard deviations are ``WITHOUT_BLOCKS`` times the
            formula's.
        weights: per joint, shape (n,); they matter within a group only.
    """
    if isinstance(problem, ShortMotion):
        joints, groups, whole = problem.joints, moving_groups(problem.joints), problem.posed(PAYLOAD)
    else:
        joints, groups = tuple(range(1, problem.robot.n + 1)), joint_groups(problem.robot.n)
        whole = from_difference(problem) if problem.difference is not None else from_robot(problem)
    # What one joint shows does not correct the robot: its parameters stay as they are.
    whole = replace(whole, fixed=whole.given, prior=None)

    without = [tuple(other for other in joints if other != joint) for joint in joints if len(joints) > 1]
    sought: list[Callable[[JointEquations], Number | None]] = [mass_of(group) for group in (*groups, *without)]
    sought += [share_of(joint) for joint in joints]
    equations = JointEquations.of(whole, weights)
    numbers = [number(equations) for number in sought]
    variance, dof = _variances(sought, numbers, whole, weights)
    pairs = [
        (number.value if number else None, float(sigma))
        for number, sigma in zip(numbers, np.sqrt(variance), strict=True)
    ]
    masses = [
        JointsMass(group, mass, sigma, dof) if mass is not None else JointsMass(group, None)
        for group, (mass, sigma) in zip((*groups, *without), pairs, strict=False)
    ]
    shares = [JointShare(joint, *pair) for joint, pair in zip(joints, pairs[len(masses) :], strict=True)]
    return ByJoints(tuple(masses[: len(groups)]), tuple(shares), tuple(masses[len(groups) :]))


def _variances(
    sought: Sequence[Callable[[JointEquations], Number | None]],
    numbers: Sequence[Number | None],
    whole: LinearProblem,
    weights: Array,
) -> tuple[Array, float]:
    """Variances of the numbers, nan where there is none, and their degrees of freedom.

    The larger of the formula's and the jackknife's; without blocks the formula's, widened.
    """
    table: Array = np.array(
        [(number.variance, number.lasting, number.value) if number else (np.nan, np.nan, 0.0) for number in numbers]
    )
    variance, lasting, values = table[:, 0], table[:, 1], table[:, 2]

    def again(part: LinearProblem) -> Array:
        """The numbers by what is left; one that it leaves undetermined counts as unchanged."""
        left, anew = JointEquations.of(part, weights), values.copy()
        for k in [k for k, number in enumerate(numbers) if number is not None]:
            number = sought[k](left)
            anew[k] = number.value if number else values[k]
        return anew

    try:
        # Without each block with payload; then without each of those that the robot's parameters come from.
        groups = [whole.without_each()]
        for k, group in enumerate(whole.fixed):
            if (left := group.left_out()) is not None:
                others = whole.fixed[:k], whole.fixed[k + 1 :]
                groups.append(
                    [replace(whole, fixed=(*others[0], group._replace(values=x), *others[1])) for x in left]
                )
        robust = jackknife([map(again, group) for group in groups], values, 0.0)
    except InputError:  # too few blocks
        return WITHOUT_BLOCKS**2 * variance, float("inf")
    return (
        np.maximum(variance, np.diag(robust.covariance) + lasting),
        max(float(robust.degrees_of_freedom), 1.0),
    )
