"""Payloads that are not known yet: every body of at most a mass within a region at the flange, down to none.

A joint's torque is linear in a body's mass distribution, and the distribution is a mixture of points of the region.
So the largest torque over all bodies is the larger of zero and the mass times the largest torque of a unit point:
a quadratic in the point's three coordinates.
"""

import functools
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import Pose
from ...model.kernel.kernel import Kernel
from .extremes import Eigen, eigen, largest_in_ball, largest_in_cube

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
