"""Payload by single joints: the sharpest free test of drive gains, friction and description.

By torque differences (29) where there are pairs, otherwise by the loaded torques less the robot's (23).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.errors import InputError
from ...common.linear import decomposed
from ..equations.equations import PAYLOAD
from ..fit.covariance import jackknife, student95
from ..fit.linear_problem import LinearProblem
from .methods import PayloadProblem, from_difference, from_robot
from .short_motion import ShortMotion

_BLURRED = 0.05
"""Fraction of noise in the torque that the other joints' payload predicts, above which a ratio says nothing."""
_HIDDEN = 1e-6
"""Fraction of the mass in undetermined directions above which it is not visible."""
WITHOUT_BLOCKS = 4.0
"""Factor on the formula's standard deviations where no jackknife is possible: on real data they are up to 4.1 times
too small."""


@dataclass(frozen=True, repr=False)
class JointsMass(Brief):
    """Mass by the equations of some joints alone, all ten parameters of the payload unknown.

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
        """Name the joints: "joint 3" or "joints 4-6"."""
        if len(self.joints) == 1:
            return f"joint {self.joints[0]}"
        if self.joints == tuple(range(self.joints[0], self.joints[-1] + 1)):
            return f"joints {self.joints[0]}-{self.joints[-1]}"
        return f"joints {', '.join(map(str, self.joints))}"


@dataclass(frozen=True)
class JointShare:
    """Payload ratio of a joint: 1 where its torque is what the other joints' payload demands.

    Attributes:
        share: factor on the torque that the payload identified by all other joints causes there; None where they
            determine it too badly.
        sigma: standard deviation, the larger of the formula's and the block jackknife's.
    """

    joint: int
    share: float | None
    sigma: float = float("nan")


@dataclass(frozen=True, repr=False)
class ByJoints(Brief):
    """Mass and payload ratio by single joints.

    Attributes:
        masses: by every joint alone, then by the arm's and by the wrist's joints together.
        shares: of every joint against the others.
        without: the masses by all joints but one.
    """

    masses: tuple[JointsMass, ...]
    shares: tuple[JointShare, ...]
    without: tuple[JointsMass, ...] = ()


def joint_groups(n: int) -> tuple[tuple[int, ...], ...]:
    """List every joint alone, and the arm's and the wrist's together (all but the last three, the last three)."""
    single = tuple((joint,) for joint in range(1, n + 1))
    if n <= 3:
        return single
    return (*single, tuple(range(1, n - 2)), tuple(range(n - 2, n + 1)))


def moving_groups(joints: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """List every moving joint alone; then the arm's, those from the elbow on, the wrist's, and all together."""
    single = [(joint,) for joint in joints]
    parts = [
        tuple(j for j in joints if j <= 3),
        tuple(j for j in joints if j >= 3),
        tuple(j for j in joints if j >= 4),
        tuple(joints),
    ]
    return tuple(dict.fromkeys([*single, *(part for part in parts if len(part) > 1)]))


class _JointEquations(NamedTuple):
    """Weighted factors [W_L Y] of the payload per joint, and W of what was taken off.

    ``covariance`` of the parameters taken off; ``lasting``: of them, what no block of time shows.
    """

    payload: tuple[Array, ...]
    taken: tuple[Array, ...]
    covariance: Array
    lasting: Array
    rows: tuple[float, ...]


_Number = tuple[float, float, float] | None
"""Number: value, variance by the formula, and the between-session part of it; None where undetermined."""


def payload_by_joints(problem: PayloadProblem, weights: Array) -> ByJoints:
    """Estimate mass and ratio by joints, all ten unknown, with standard deviations for autocorrelated noise.

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
    sought: list[Callable[[_JointEquations], _Number]] = [partial(_mass, group) for group in (*groups, *without)]
    sought += [partial(_share, joint) for joint in joints]
    equations = _equations(whole, weights)
    numbers = [number(equations) for number in sought]
    variance, dof = _variances(sought, numbers, whole, weights)
    pairs = [(number and number[0], float(sigma)) for number, sigma in zip(numbers, np.sqrt(variance), strict=True)]
    masses = [
        JointsMass(group, mass, sigma, dof) if mass is not None else JointsMass(group, None)
        for group, (mass, sigma) in zip((*groups, *without), pairs, strict=False)
    ]
    shares = [JointShare(joint, *pair) for joint, pair in zip(joints, pairs[len(masses) :], strict=True)]
    return ByJoints(tuple(masses[: len(groups)]), tuple(shares), tuple(masses[len(groups) :]))


def _equations(problem: LinearProblem, weights: Array) -> _JointEquations:
    """Take the payload's ten alone, for weights of the joints."""
    unknown = problem.unknown.select(PAYLOAD)
    factors = problem.equations.whole.select([name for group in problem.fixed for name in group.names]).factors
    none, lasting = np.zeros((0, 0)), [group.lasting for group in problem.fixed]
    # What an earlier identification's jackknife says counts instead of its formula.
    covariance = [group.lasting if group.lasting.any() else group.covariance for group in problem.fixed]
    return _JointEquations(
        tuple(w * factor for w, factor in zip(weights, unknown.factors, strict=True)),
        tuple(w * factor[:, :-1] for w, factor in zip(weights, factors, strict=True)),
        np.asarray(block_diag(none, *covariance)),
        np.asarray(block_diag(none, *lasting)),
        unknown.effective_rows,
    )


def _mass(joints: Sequence[int], equations: _JointEquations) -> _Number:
    """Estimate the mass by the equations of some joints (from 1)."""
    indices = [joint - 1 for joint in joints]
    factor = np.vstack([equations.payload[j] for j in indices])
    parts, Y = decomposed(factor[:, :-1]), factor[:, -1]
    if parts.hidden[-1] > _HIDDEN:
        return None
    row, error = parts.inverse[-1], Y - factor[:, :-1] @ parts.solution(Y)
    spare = max(sum(equations.rows[j] for j in indices) - parts.rank, 1.0)
    # Errors of the parameters that were taken off carry over.
    gain = row @ np.vstack([equations.taken[j] for j in indices])
    own = float(error @ error) / spare * float(row @ row)
    return float(row @ Y), own + float(gain @ equations.covariance @ gain), float(gain @ equations.lasting @ gain)


def _share(joint: int, equations: _JointEquations) -> _Number:
    """Estimate the payload ratio of a joint (from 1); None where the others determine it too badly."""
    factor = np.vstack([equations.payload[j] for j in range(len(equations.payload)) if j != joint - 1])
    parts = decomposed(factor[:, :-1])
    if parts.hidden.max() > _HIDDEN:
        return None
    inverse = parts.inverse
    A, y = equations.payload[joint - 1][:, :-1], equations.payload[joint - 1][:, -1]
    predicted = A @ (inverse @ factor[:, -1])
    # Errors of the others' payload are part of the error of what is predicted; large ones bias the ratio.
    noise = A @ inverse @ inverse.T @ A.T
    if not np.trace(noise) < _BLURRED * float(predicted @ predicted):
        return None
    # Generalised least squares of y = ratio predicted, errors of covariance 1 + noise.
    whitened = np.linalg.solve(np.eye(len(A)) + noise, predicted)
    size = float(whitened @ predicted)
    return float(whitened @ y) / size, 1.0 / size, 0.0


def _variances(
    sought: Sequence[Callable[[_JointEquations], _Number]],
    numbers: Sequence[_Number],
    whole: LinearProblem,
    weights: Array,
) -> tuple[Array, float]:
    """Estimate variances of the numbers, nan where there is none, and their degrees of freedom.

    The larger of the formula's and the jackknife's; without blocks the formula's, widened.
    """
    values, variance, lasting = np.array([number or (0.0, np.nan, np.nan) for number in numbers]).T

    def again(part: LinearProblem) -> Array:
        """Estimate the numbers by what is left; one that it leaves undetermined counts as unchanged."""
        left, anew = _equations(part, weights), np.array(values)
        for k, known in enumerate(numbers):
            if known is not None and (number := sought[k](left)) is not None:
                anew[k] = number[0]
        return anew

    try:
        # Without each block with payload; then without each of those that the robot's parameters come from.
        groups = [whole.without_each()]
        for k, group in enumerate(whole.fixed):
            if (left := group.left_out()) is not None:
                before, after = whole.fixed[:k], whole.fixed[k + 1 :]
                groups.append([replace(whole, fixed=(*before, group._replace(values=x), *after)) for x in left])
        robust = jackknife([map(again, group) for group in groups], values, 0.0)
    except InputError:  # too few blocks
        return WITHOUT_BLOCKS**2 * variance, float("inf")
    return np.maximum(variance, np.diag(robust.covariance) + lasting), max(float(robust.degrees_of_freedom), 1.0)
