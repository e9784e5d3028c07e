"""Payloads that are not known yet: every body of at most a mass within a region at the flange, down to none.

A joint's torque is linear in a body's mass distribution, and the distribution is a mixture of points of the region.
So the largest torque over all bodies is the larger of zero and the mass times the largest torque of a unit point:
a quadratic in the point's three coordinates.
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import Pose
from ...model.kernel import Kernel
from .extremes import Eigen, eigen, largest_in_ball, largest_in_cube
from .information import RegressorKernel
from .limits import Limit, State, joint_labels

Region = Literal["ball", "cube"]
"""An ellipsoid or a box, before its axes."""


class PayloadTorque(NamedTuple):
    """Extreme torque over a set of payloads, and a body that has it.

    Attributes:
        torque: [N·m or N], shape (k,).
        body: ten parameters of the point mass, zero for no payload, shape (k, 10).
    """

    torque: Array
    body: Array


@dataclass(frozen=True, eq=False)
class PayloadSet:
    """Every body of at most a mass within an ellipsoid or a box, and no body at all.

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
        """Lock the arrays and check them.

        Raises:
            InputError: for a mass or an axis that is not positive.
        """
        for name, shape in (("centre", (3,)), ("axes", (3, 3))):
            object.__setattr__(self, name, frozen_array(getattr(self, name), shape, name))
        if not 0.0 < self.mass < np.inf or not (self.half > 0.0).all():
            raise InputError("payloads within bounds need a positive mass and a region of positive size")

    @staticmethod
    def within(
        mass: float, half: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0), box: bool = False
    ) -> "PayloadSet":
        """Bodies in a region along the frame's axes.

        Args:
            mass: largest [kg].
            half: radius of a ball, or the three half axes or half edges [m].
            centre: of the region [m], shape (3,).
            box: whether it is a box, not an ellipsoid.
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

    def seen_from(self, pose: Pose) -> "PayloadSet":
        """Describe the set in the frame in which its own frame stands at ``pose``."""
        return PayloadSet(self.mass, pose.p + pose.R @ self.centre, pose.R @ self.axes, self.region)

    def lighter(self, mass: float) -> "PayloadSet":
        """Keep the bodies of at most ``mass`` [kg]."""
        return PayloadSet(min(mass, self.mass), self.centre, self.axes, self.region)

    def extremes(self, columns: Array) -> tuple[PayloadTorque, PayloadTorque]:
        """Largest and smallest torque over all bodies of the set.

        Args:
            columns: k rows of a payload's regressor in the set's frame, shape (k, 10), XX XY .. MZ M.
        """
        bounds = np.concatenate([[self.mass], self.centre, self.axes.T.ravel()])
        rows = _kernel(self.region)(columns, bounds)
        return PayloadTorque(rows[0], rows[1:11].T), PayloadTorque(rows[11], rows[12:].T)


def points(places: Array) -> Array:
    """Ten parameters of unit point masses at places (k, 3) [m], shape (k, 10)."""
    return np.stack(_point(*places.T), axis=1)


def _point(x: Any, y: Any, z: Any) -> list[Any]:
    """Ten parameters of a unit point mass, of numbers, arrays or expressions."""
    return [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y, x, y, z, 1.0 + 0.0 * x]


@functools.cache
def _kernel(region: Region) -> Kernel:
    """Largest torque, its body, smallest torque, its body, from a regressor's row and the set's numbers."""
    row, bounds = ca.SX.sym("row", 10), ca.SX.sym("bounds", 13)
    mass, centre, axes = bounds[0], bounds[1:4], ca.reshape(bounds[4:], 3, 3)
    Q = _quadratic(row)
    slope = ca.mtimes(axes.T, row[6:9] + 2.0 * ca.mtimes(Q, centre))
    at_centre = ca.dot(row, ca.vertcat(*_point(*ca.vertsplit(centre))))
    Q = ca.mtimes([axes.T, Q, axes])
    if region == "ball":
        basis = eigen(Q)
        opposite = Eigen([-value for value in basis.values], basis.vectors)
        extremes = [largest_in_ball(basis, slope), largest_in_ball(opposite, -slope)]
    else:
        extremes = [largest_in_cube(Q, slope), largest_in_cube(-Q, -slope)]
    rows = []
    for sign, extreme in zip((1.0, -1.0), extremes, strict=True):
        value = mass * (at_centre + sign * extreme.value)
        worse = sign * value > 0.0
        body = _point(*ca.vertsplit(centre + ca.mtimes(axes, ca.vertcat(*extreme.place))))
        rows += [ca.if_else(worse, x, 0.0) for x in (value, *(mass * number for number in body))]
    return Kernel(ca.Function("payload_extremes", [row, bounds], [ca.cse(ca.densify(ca.vertcat(*rows)))]))


def _quadratic(row: ca.SX) -> ca.SX:
    """Q with torque = r' Q r + (MX MY MZ columns)' r + (M column) for a unit point mass at r."""
    XX, XY, XZ, YY, YZ, ZZ = ca.vertsplit(row[:6])
    rows = [[YY + ZZ, -0.5 * XY, -0.5 * XZ], [-0.5 * XY, XX + ZZ, -0.5 * YZ], [-0.5 * XZ, -0.5 * YZ, XX + YY]]
    return ca.vertcat(*(ca.horzcat(*entries) for entries in rows))


@dataclass(frozen=True, eq=False)
class RobotTorque:
    """The robot's own torque W chi and how sure it is.

    Attributes:
        chi: in the kernel's columns, shape (c,).
        root: C = root root' is the covariance of chi, c x r; r = 0 where it is taken as exact.
        sigmas: so many standard deviations count.
    """

    chi: Array
    root: Array
    sigmas: float = 2.0


def payload_limit(
    kernel: RegressorKernel, own: RobotTorque, torque: Array, payloads: PayloadSet, columns: Sequence[str]
) -> Limit:
    """Largest and smallest torque of each joint over its limit, of all payloads of a set.

    Where the worst body is unique, the slope of the largest torque is that of the worst body's torque (Danskin's
    envelope theorem). The first n values are the largest torques, bounded above alone, the others the smallest,
    bounded below alone.

    Args:
        kernel: holds the payload's columns.
        own: torque without payload.
        torque: limits [N·m or N], shape (n,), infinite where there is none.
        payloads: in the last link's frame.
        columns: names of the payload's ten columns.
    """
    n, finite = len(torque), np.isfinite(torque)
    unit = np.where(finite, torque, 1.0)
    none, bound = np.full(n, np.inf), np.where(finite, 1.0, np.inf)
    torques = _PayloadTorques(kernel, own, payloads, tuple(columns))

    def values(state: State) -> Array:
        return np.asarray(torques.values(state.entries) / np.tile(unit, 2))

    def pullback(state: State, slope: Array, into: State) -> None:
        torques.pullback(state.entries, slope / np.tile(unit, 2), into.entries)

    return Limit(
        "torque",
        f"torque with any payload up to {payloads.mass:g} kg",
        joint_labels(n) * 2,
        np.concatenate([-none, -bound]),
        np.concatenate([bound, none]),
        np.zeros(2 * n),
        np.tile(unit, 2),
        values,
        pullback,
    )


class _PayloadTorques:
    """Extreme torques [N·m or N] from a regressor's entries, and their slopes."""

    def __init__(
        self, kernel: RegressorKernel, own: RobotTorque, payloads: PayloadSet, columns: tuple[str, ...]
    ) -> None:
        """Find the payload's columns among each joint's entries."""
        self._kernel, self._own, self._payloads = kernel, own, payloads
        place = {kernel.columns.index(name): k for k, name in enumerate(columns)}
        self._rows: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
        for part, names in kernel.parts:
            pairs = [(part.start + i, place[name]) for i, name in enumerate(names) if name in place]
            rows, numbers = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
            self._rows.append((rows, numbers))
        self._last: tuple[Array, tuple[PayloadTorque, PayloadTorque]] | None = None

    def values(self, entries: Array) -> Array:
        """Largest, then smallest torques, (N, 2 n)."""
        torque, doubt = self._kernel.torque(entries, self._own.chi), self._doubt(entries)[0]
        largest, smallest = (extreme.torque.reshape(torque.T.shape).T for extreme in self._extremes(entries))
        return np.hstack([torque + doubt + largest, torque - doubt + smallest])

    def pullback(self, entries: Array, slope: Array, seed: Array) -> None:
        """Add to ``seed`` what slopes in the torques (N, 2 n) mean for the entries."""
        up, down = np.split(slope, 2, axis=1)
        self._kernel.torque_slope(up + down, self._own.chi, seed)
        self._doubt_slope(entries, up - down, seed)
        for share, extreme in zip((up, down), self._extremes(entries), strict=True):
            bodies = extreme.body.T.reshape(10, len(self._rows), -1)
            for j, (rows, numbers) in enumerate(self._rows):
                if share[:, j].any():
                    seed[rows] += bodies[numbers, j] * share[:, j]

    def _extremes(self, entries: Array) -> tuple[PayloadTorque, PayloadTorque]:
        """Joint after joint, (n N,) and (n N, 10); kept until other entries come, for slopes follow values."""
        if self._last is None or self._last[0] is not entries:
            self._last = entries, self._searched(entries)
        return self._last[1]

    def _searched(self, entries: Array) -> tuple[PayloadTorque, PayloadTorque]:
        columns = np.zeros((len(self._rows), entries.shape[1], 10))
        for own, (rows, numbers) in zip(columns, self._rows, strict=True):
            own[:, numbers] = entries[rows].T
        return self._payloads.extremes(columns.reshape(-1, 10))

    def _doubt(self, entries: Array) -> tuple[Array, list[Array]]:
        """So many standard deviations of the robot's own torque, (N, n), and root' w of each joint, r x N."""
        spread = [self._own.root[names].T @ entries[part] for part, names in self._kernel.parts]
        sizes = [np.sqrt((share**2).sum(axis=0)) for share in spread]
        return self._own.sigmas * np.stack(sizes, axis=1), spread

    def _doubt_slope(self, entries: Array, slope: Array, seed: Array) -> None:
        if not self._own.root.shape[1]:
            return
        doubt, spread = self._doubt(entries)
        for j, (part, names) in enumerate(self._kernel.parts):
            size = np.where(doubt[:, j] > 0.0, doubt[:, j], 1.0) / self._own.sigmas**2
            seed[part] += self._own.root[names] @ spread[j] * (slope[:, j] / size)
