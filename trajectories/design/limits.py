"""Limits of a motion as numbers that must stay within an interval, with their slopes.

Every limit is written as low <= y(x) <= high with y of the order of 1. Slopes in y are pulled back to the states
and, for torques, to the entries of the observation matrix, from where the design's one adjoint takes them on. The
augmented Lagrangian of ``descent`` makes a motion keep them.

Torques keep their limits for one load, or for a set of payloads not known yet: every body of at most a mass within
a region at the flange, down to none. A joint's torque is linear in a body's mass distribution, a mixture of points
of the region. So the largest torque over all bodies is the larger of zero and the mass times the largest torque of
a unit point: a quadratic in the point's three coordinates.

Over the unit ball its largest value is the trust-region problem's, solved to global optimality by its dual (Conn,
Gould and Toint, Trust-Region Methods, chapter 7). In the eigenvectors of Q, with beta = V' b / 2,

    max over |s| <= 1 of s' Q s + b' s  =  min over mu >= max(0, lambda) of mu + sum beta_i^2 / (mu - lambda_i),

and every such mu bounds the left side from above: what is returned is a bound wherever the iteration stands. Over
the unit cube it is taken at a stationary point of the inside, of a face, of an edge, or in a corner: 27 candidates.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, Literal

import casadi as ca
import numpy as np

from ...common import Array, ArrayLike, Brief, Document, InputError, freeze_fields
from ...common.errors import listed
from ...model import BaseParameters, InertialParameters, Pose, Robot
from ...model.drives import SPRING
from ...model.kernel.kernel import Kernel
from ...model.regressors import payload_columns
from ..motions.family import JointBounds, Samples
from .goal import RegressorKernel

_SWEEPS = 4  # of Jacobi's rotations: a 3 x 3 matrix is then diagonal to rounding
_NEWTON = 8  # steps: with seven, rows of the shipped arms were bounded to 1e-12, with eight to rounding
_TINY = 1e-13  # of the quadratic's size: distance that mu keeps from the largest eigenvalue
_LEAST = 1e-300
_SIGMAS = 2.0  # standard deviations of the robot's own torque that count

Region = Literal["ball", "cube"]  # region that holds a body: an ellipsoid or a box along its axes

Penalty = Callable[[Samples, Samples], float]
"""Function that evaluates terms which limits add to a criterion; slopes in the samples are added to the second."""
Pullback = Callable[[Array, Samples], object]
"""Function that adds what a slope in a limit's values means for samples and entries."""
Measure = Callable[[Samples], tuple[Array, Pullback]]
"""Function that gives the values y of a motion, a row per sample or one for all of it, and their pullback."""


@dataclass(frozen=True, eq=False, repr=False)
class Limit(Brief):
    """Limit of one kind, the interval of each column."""

    kind: Literal["state", "torque", "duration", "clearance"]  # what it takes to know it
    name: str
    labels: tuple[str, ...]  # what each column belongs to ("joint 3")
    low: Array
    high: Array
    middle: Array  # the value in SI units is middle + y * unit
    unit: Array
    measure: Measure

    def values(self, state: Samples) -> Array:
        """Evaluate y alone."""
        return self.measure(state)[0]


def state_limits(bounds: JointBounds, reach: tuple[Array, Array] | None = None) -> tuple[Limit, ...]:
    """Limit position, within a family's ``reach`` or else the bounds, speed and acceleration; 1 at the limit."""
    v, a, limits = bounds.speed, bounds.acceleration, []
    ranges = {"position": reach or (bounds.low, bounds.high), "speed": (-v, v), "acceleration": (-a, a)}
    for index, (name, ends) in enumerate(ranges.items(), start=1):
        low, high = np.atleast_2d(*ends)
        middle, half, unit = 0.5 * (low + high), 0.5 * (high - low), np.ones(low.shape[1])
        measure = partial(_states, index, middle, half)
        # In messages the first part stands for all; each sample is judged by its own.
        labels = tuple(f"joint {j + 1}" for j in range(len(unit)))
        limits.append(Limit("state", name, labels, -unit, unit, middle[0], half[0], measure))
    return tuple(limits)


def _states(index: int, middle: Array, half: Array, state: Samples) -> tuple[Array, Pullback]:
    x = state[index]
    if len(half) > 1:
        middle, half = (np.repeat(parts, len(x) // len(parts), axis=0) for parts in (middle, half))
    return (x - middle) / half, lambda slope, into: np.add(into[index], slope / half, out=into[index])


def total_time(longest: float, state: Samples) -> tuple[Array, Pullback]:
    """Measure the time that the whole motion takes, over the longest [s]."""
    share = np.array([[state.weight.sum() / longest]])
    return share, lambda slope, into: np.add(into.weight, slope[0, 0] / longest, out=into.weight)


def slowed(kernel: RegressorKernel, limit: Limit, speed: float, state: Samples) -> tuple[Array, Pullback]:
    """Measure a limit at a fraction of the speed: speeds shrink by it, accelerations by its square."""
    weight, q, qd, qdd, _, width = state
    slow = kernel.state(Samples(weight / speed, q, speed * qd, speed**2 * qdd), speed * float(width[0]))
    values, own = limit.measure(slow)

    def pullback(slope: Array, into: Samples) -> None:
        slopes = Samples(*map(np.zeros_like, slow))
        own(slope, slopes)
        for part, by, power in zip(into[1:4], kernel.state_slope(slow, slopes.entries), (0, 1, 2), strict=True):
            part += speed**power * by

    return values, pullback


class LimitCheck(Document, frozen=True):
    """Result of a check: how near a motion comes to one limit on a fine grid.

    Attributes:
        name: of the limit.
        worst: what comes nearest ("joint 3").
        value, limit: there, SI units.
        violation: by how much the limit is missed, SI units; 0 where it is met.
        relative: ``violation`` in units of the limit.
        room: what is left to the limit, in units of the limit; negative where it is missed.
    """

    name: str
    worst: str
    value: float
    limit: float
    violation: float
    relative: float
    room: float

    def __str__(self) -> str:
        """Write the check in one line."""
        state = f"violated by {self.violation:.4g}" if self.violation > 0.0 else "met"
        return f"{self.name} of {self.worst}: {self.value:.4g} against {self.limit:.4g}, {state}"


def excess(limit: Limit, values: Array) -> Array:
    """Distance of each value outside its interval, in the limit's units; negative inside."""
    return np.maximum(values - limit.high, limit.low - values)


def check(limit: Limit, state: Samples) -> LimitCheck:
    """Find where a motion comes nearest to a limit, or misses it most."""
    values = limit.values(state)
    over = excess(limit, values)
    row, column = np.unravel_index(int(np.argmax(over)), over.shape)
    middle, unit, low, high = (float(x[column]) for x in (limit.middle, limit.unit, limit.low, limit.high))
    value, beyond = float(values[row, column]), float(over[row, column])
    nearest = high if value - high >= low - value else low
    missed, shown = max(beyond, 0.0), (middle + value * unit, middle + nearest * unit)
    return LimitCheck(limit.name, limit.labels[int(column)], *shown, missed * unit, missed, -beyond)


@dataclass(frozen=True, eq=False, repr=False)
class PayloadSet(Brief):
    """Set of every body of at most a mass within an ellipsoid or a box, and of no body at all.

    Attributes:
        mass: largest mass [kg].
        centre: of the region [m], shape (3,).
        axes: half axes of the ellipsoid, or half edges of the box, as columns [m], 3 x 3.
        region: "ball" for the ellipsoid, "cube" for the box.
    """

    mass: float
    centre: Array
    axes: Array
    region: Region = "ball"

    def __post_init__(self) -> None:
        freeze_fields(self, centre=(3,), axes=(3, 3))
        if not 0.0 < self.mass < np.inf or not (self.half > 0.0).all():
            raise InputError("payloads within bounds need a positive mass and a region of positive size")

    @staticmethod
    def within(mass: float, half: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0), box: bool = False) -> PayloadSet:
        """Make the set of bodies of at most ``mass`` [kg] in a ball, an ellipsoid or a box along the frame's axes.

        ``half``: radius of a ball, or the three half axes or half edges [m].
        """
        sides = np.broadcast_to(np.asarray(half, dtype=float), (3,))
        return PayloadSet(mass, np.asarray(centre, dtype=float), np.diag(sides), "cube" if box else "ball")

    @property
    def half(self) -> Array:
        """Lengths of the half axes or half edges [m], shape (3,)."""
        return np.asarray(np.linalg.norm(self.axes, axis=0))

    @property
    def radius(self) -> float:
        """Radius of the ball about the centre that holds the region [m]."""
        return float(np.linalg.norm(self.half) if self.region == "cube" else self.half.max())

    def seen_from(self, pose: Pose) -> PayloadSet:
        """Describe the set in the frame in which its own frame stands at ``pose``."""
        return replace(self, centre=pose.p + pose.R @ self.centre, axes=pose.R @ self.axes)

    def lighter(self, mass: float) -> PayloadSet:
        """Keep the bodies of at most ``mass`` [kg]."""
        return replace(self, mass=min(mass, self.mass))

    def extremes(self, columns: Array) -> Array:
        """Compute largest and smallest torque over all bodies of the set, each with a point mass that has it.

        From k rows of a payload's regressor in the set's frame, shape (k, 10), XX XY .. MZ M, to torques [N·m or N]
        and ten parameters, zero for no payload, of the largest and the smallest; (2, 11, k).
        """
        bounds = np.concatenate([[self.mass], self.centre, self.axes.T.ravel()])
        return _kernel(self.region)(columns, bounds).reshape(2, 11, -1)


def unit_point(x: Any, y: Any, z: Any) -> list[Any]:
    """Compute the ten parameters of a unit point mass, of numbers, arrays or expressions."""
    return [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y, x, y, z, 1.0 + 0.0 * x]


@functools.cache
def _kernel(region: Region) -> Kernel:
    row, bounds = ca.SX.sym("row", 10), ca.SX.sym("bounds", 13)
    mass, centre, axes = bounds[0], bounds[1:4], ca.reshape(bounds[4:], 3, 3)
    # The torque of a unit point mass at r is r' Q r + (MX MY MZ columns)' r + (M column).
    XX, XY, XZ, YY, YZ, ZZ = ca.vertsplit(row[:6])
    quadratic = [[YY + ZZ, -0.5 * XY, -0.5 * XZ], [-0.5 * XY, XX + ZZ, -0.5 * YZ], [-0.5 * XZ, -0.5 * YZ, XX + YY]]
    Q = ca.blockcat(quadratic)
    slope = ca.mtimes(axes.T, row[6:9] + 2.0 * ca.mtimes(Q, centre))
    at_centre = ca.dot(row, ca.vertcat(*unit_point(*ca.vertsplit(centre))))
    Q = ca.mtimes([axes.T, Q, axes])
    if region == "ball":
        values, V = _eigen(Q)
        extremes = [_largest_in_ball(values, V, slope), _largest_in_ball([-x for x in values], V, -slope)]
    else:
        extremes = [_largest_in_cube(Q, slope), _largest_in_cube(-Q, -slope)]
    rows = []
    for sign, (largest, point) in zip((1.0, -1.0), extremes, strict=True):
        value = mass * (at_centre + sign * largest)
        worse = sign * value > 0.0
        body = unit_point(*ca.vertsplit(centre + ca.mtimes(axes, ca.vertcat(*point))))
        rows += [ca.if_else(worse, x, 0.0) for x in (value, *(mass * number for number in body))]
    return Kernel(ca.Function("payload_extremes", [row, bounds], [ca.cse(ca.densify(ca.vertcat(*rows)))]))


def _eigen(Q: ca.SX) -> tuple[list[ca.SX], ca.SX]:
    """Eigenvalues, and eigenvectors as columns, of a symmetric 3 x 3 matrix by Jacobi's rotations."""
    A = [[Q[i, j] for j in range(3)] for i in range(3)]
    V = [[ca.SX(float(i == j)) for j in range(3)] for i in range(3)]
    for p, q in [(0, 1), (0, 2), (1, 2)] * _SWEEPS:
        r, apart, twice = 3 - p - q, A[q][q] - A[p][p], 2.0 * A[p][q]
        root = ca.sqrt(apart * apart + twice * twice)
        t = twice / (ca.fabs(apart) + root + _LEAST)
        t = ca.if_else(apart < 0.0, -t, t)
        c = 1.0 / ca.sqrt(1.0 + t * t)
        s = t * c
        A[p][p], A[q][q] = A[p][p] - t * A[p][q], A[q][q] + t * A[p][q]
        A[p][q] = A[q][p] = ca.SX(0.0)
        first, second = c * A[r][p] - s * A[r][q], s * A[r][p] + c * A[r][q]
        A[r][p] = A[p][r] = first
        A[r][q] = A[q][r] = second
        for row in V:
            row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
    return [A[i][i] for i in range(3)], ca.blockcat(V)


def _largest_in_ball(values: list[ca.SX], V: ca.SX, b: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
    """Compute the largest value over the unit ball, and never less than it; and where it is taken."""
    eigenvalues = ca.vertcat(*values)
    beta = 0.5 * ca.mtimes(V.T, b)
    top, ends = functools.reduce(ca.fmax, values), eigenvalues + ca.fabs(beta)
    size = functools.reduce(ca.fmax, ca.vertsplit(ca.fabs(eigenvalues))) + ca.sum1(ca.fabs(beta))
    # No term of |s|^2 may exceed 1, so that mu is at least each lambda_i + |beta_i|.
    mu = least = functools.reduce(ca.fmax, [top + _TINY * size + _LEAST, ca.SX(0.0), *ca.vertsplit(ends)])
    for _ in range(_NEWTON):
        inverse = 1.0 / (mu - eigenvalues)
        terms = (beta * inverse) ** 2
        square, bend = ca.sum1(terms), ca.sum1(terms * inverse)
        # 1/|s| is concave in mu: from the left of the root Newton's steps stay left of it.
        mu = ca.fmax(mu + (ca.sqrt(square) - 1.0) * square / (bend + _LEAST), least)
    s = beta / (mu - eigenvalues)
    value = mu + ca.dot(beta, s)
    # On the sphere unless mu is 0. In the hard case the largest eigenvalue's direction makes up for what s lacks.
    outside, point = mu > 0.0, ca.vertsplit(s)
    free = outside
    for i in range(3):
        largest = values[i] >= top
        lacking = ca.sqrt(ca.fmax(1.0 - sum(point[j] ** 2 for j in range(3) if j != i), 0.0))
        filled = ca.if_else(point[i] < 0.0, -lacking, lacking)
        point[i] = ca.if_else(ca.logic_and(free, largest), filled, point[i])
        free = ca.logic_and(free, ca.logic_not(largest))
    length = ca.sqrt(sum(x * x for x in point))
    point = [ca.if_else(outside, x / (length + _LEAST), x) for x in point]
    return value, ca.vertsplit(ca.mtimes(V, ca.vertcat(*point)))


def _largest_in_cube(Q: ca.SX, b: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
    value, point = ca.SX(-ca.inf), [ca.SX(0.0)] * 3
    for pattern in product((-1.0, 1.0, 0.0), repeat=3):
        s = [ca.SX(side) for side in pattern]
        free, fixed = ([i for i in range(3) if (pattern[i] == 0.0) == inside] for inside in (True, False))
        slopes = ca.vertcat(*(-0.5 * b[i] - sum(pattern[j] * Q[i, j] for j in fixed) for i in free))
        adjugate = ca.adj(Q[free, free]) if len(free) > 1 else ca.SX.eye(len(free))
        for row, i in enumerate(free):
            # By cofactors. Along directions of a singular system the largest value is taken on a smaller face too.
            determinant = ca.mtimes(Q[free[0], free], adjugate[:, 0])
            x = ca.if_else(determinant == 0.0, 0.0, ca.mtimes(adjugate[row, :], slopes) / determinant)
            s[i] = ca.fmin(ca.fmax(x, -1.0), 1.0)
        here = sum(s[i] * (b[i] + sum(Q[i, j] * s[j] for j in range(3))) for i in range(3))
        better = here > value
        value = ca.if_else(better, here, value)
        point = [ca.if_else(better, new, old) for new, old in zip(s, point, strict=True)]
    return value, point


@dataclass(frozen=True, eq=False, repr=False)
class Loads(Brief):
    """Loads: parameters that torque limits are computed from.

    Attributes:
        parameters: standard or base parameters of the robot by name.
        heaviest: the heaviest payload expected, in the last link's frame; the limits then hold without and
            with it. A set: they hold for each of its bodies, and without any.
        covariance: of ``parameters`` in their order; None where they are taken as exact. It counts for a set, by
            two standard deviations of the robot's own torque.
        margin: fraction of the torque limits that stays free.
    """

    parameters: Mapping[str, float]
    heaviest: InertialParameters | PayloadSet | None = None
    covariance: Array | None = None
    margin: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", dict(self.parameters))
        if not 0.0 <= self.margin < 1.0:
            raise InputError(f"a torque margin of {self.margin:g}: give a share of the limits from 0 to below 1")


def torque_limits(
    robot: Robot, base: BaseParameters, kernel: RegressorKernel, torque: Array, loads: Loads
) -> list[Limit]:
    """Limit the torque of each joint over ``torque`` [N·m or N], (n,), infinite where there is no limit.

    For a set of payloads the first n values are the largest torques, bounded above alone, the others the smallest,
    bounded below alone; slopes are those of the torque of the worst body (Danskin's envelope theorem).
    """
    known, heaviest, finite, index = loads.parameters, loads.heaviest, np.isfinite(torque), kernel.columns.index
    if all(name in known for name in base.standard):
        values = base.value(known)
    elif missing := [name for name in base.columns if name not in known]:
        fault = f"torque limits need the parameters of robot {robot.name!r}: {listed(missing)} are missing"
        raise InputError(f"{fault}; identify the robot first, or omit torque limits")
    else:
        values = np.array([known[name] for name in base.columns])
    unit, bound = np.where(finite, (1.0 - loads.margin) * torque, 1.0), np.where(finite, 1.0, np.inf)
    chi = np.array([-1.0 if name == SPRING else 0.0 for name in kernel.columns])
    places, low, high = [*map(index, base.columns)], -bound, bound
    chi[places] = values
    measures: dict[str, Measure] = {"torque": partial(_torques, kernel, chi, unit)}
    if isinstance(heaviest, PayloadSet):
        # C = root root' is the covariance of chi, c x r; r = 0 where it is taken as exact.
        root = np.zeros((len(chi), 0))
        if loads.covariance is not None:
            names = list(known)
            if not set(base.columns) <= set(names) or np.shape(loads.covariance) != (len(names),) * 2:
                needed = "that of all base parameters, in their order"
                raise InputError(f"a covariance of the torques' parameters must be {needed}")
            variances, V = np.linalg.eigh(loads.covariance)
            root = np.zeros((len(chi), len(names)))
            root[places] = (V * np.sqrt(np.maximum(variances, 0.0)))[[*map(names.index, base.columns)]]
        ten, none, unit = [*map(index, payload_columns(robot))], np.full(robot.n, np.inf), np.tile(unit, 2)
        low, high = np.concatenate([-none, -bound]), np.concatenate([bound, none])
        measure = partial(_extreme_torques, (kernel, chi, root), (heaviest, ten), unit)
        measures = {f"torque with any payload up to {heaviest.mass:g} kg": measure}
    elif heaviest is not None:
        loaded = chi.copy()
        loaded[places] += base.effect_of(payload_columns(robot)) @ heaviest.vector
        with_it = partial(_torques, kernel, loaded, unit)
        measures = {"torque without payload": measures["torque"], "torque with the heaviest payload": with_it}
    labels = tuple(f"joint {j + 1}" for j in range(robot.n)) * (len(unit) // robot.n)
    return [Limit("torque", name, labels, low, high, 0.0 * unit, unit, each) for name, each in measures.items()]


def _torques(kernel: RegressorKernel, chi: Array, unit: Array, state: Samples) -> tuple[Array, Pullback]:
    torque = kernel.torque(state.entries, chi) / unit
    return torque, lambda slope, into: kernel.torque_slope(slope / unit, chi, into.entries)


def _extreme_torques(
    robot: tuple[RegressorKernel, Array, Array], load: tuple[PayloadSet, list[int]], unit: Array, state: Samples
) -> tuple[Array, Pullback]:
    (kernel, chi, root), (payloads, ten) = robot, load
    own = kernel.torque(state.entries, chi)
    extremes = payloads.extremes(kernel.matrix(state)[:, :, ten].reshape(-1, 10))
    spread = [root[names].T @ state.entries[part] for part, names in kernel.parts]
    doubt = np.stack([np.sqrt((part**2).sum(axis=0)) for part in spread], axis=1)
    largest, smallest = (torque.reshape(own.T.shape).T for torque in extremes[:, 0])

    def pullback(slope: Array, into: Samples) -> None:
        up, down = np.split(slope / unit, 2, axis=1)
        kernel.torque_slope(up + down, chi, into.entries)
        if root.shape[1]:
            for j, (part, names) in enumerate(kernel.parts):
                size = np.where(doubt[:, j] > 0.0, doubt[:, j], 1.0) / _SIGMAS
                into.entries[part] += root[names] @ spread[j] * ((up - down)[:, j] / size)
        for weight, extreme in zip((up, down), extremes[:, 1:], strict=True):
            if weight.any():
                bodies = np.zeros((len(kernel.columns), *weight.T.shape))
                bodies[ten] = extreme.reshape(10, *weight.T.shape)
                kernel.torque_slope(weight, bodies, into.entries)

    return np.hstack([own + _SIGMAS * doubt + largest, own - _SIGMAS * doubt + smallest]) / unit, pullback
