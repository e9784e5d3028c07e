"""Constraints on where a body's mass may be: in an ellipsoid, in the convex hull of points."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...common.arrays import Array
from ...common.errors import InputError
from .constraints import PSEUDO_INERTIA, Constraint, Rows, as_tuples


@dataclass(frozen=True)
class InEllipsoid(Constraint):
    """All mass lies in an ellipsoid: tr(J Q) >= 0 for the pseudo-inertia J (Wensing, Kim and Slotine, 2018).

    Q is the 4 x 4 matrix with [p 1] Q [p 1]' >= 0 for points p inside. Together with ``PossibleBody`` the
    condition is necessary and sufficient.

    Attributes:
        centre: of the ellipsoid [m], shape (3,).
        semi_axes: half the lengths of its axes [m], shape (3,).
        rotation: 3 x 3, its columns are the directions of the axes; the frame's own by default.
    """

    centre: ArrayLike
    semi_axes: ArrayLike
    rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def __post_init__(self) -> None:
        """Refuse axes without length and a matrix that is no rotation."""
        for name, shape in (("centre", (3,)), ("semi_axes", (3,)), ("rotation", (3, 3))):
            object.__setattr__(self, name, as_tuples(getattr(self, name), shape, f"{name} of an ellipsoid"))
        if not (np.asarray(self.semi_axes) > 0.0).all():
            raise InputError(f"semi_axes {self.semi_axes!r} m of an ellipsoid: all three must be positive")
        R = np.asarray(self.rotation)
        if np.abs(R.T @ R - np.eye(3)).max() > 1e-6:
            raise InputError("rotation of an ellipsoid: its columns must be orthonormal")

    @property
    def description(self) -> str:
        """What is demanded, in one line."""
        return f"mass in the ellipsoid around {self.centre!r} with semi-axes {self.semi_axes!r} m"

    @cached_property
    def rows(self) -> Rows:
        """tr(J Q) >= 0 [kg]."""
        c, R = np.asarray(self.centre), np.asarray(self.rotation)
        A = R @ np.diag(1.0 / np.square(self.semi_axes)) @ R.T
        Q = np.block([[-A, (A @ c)[:, None]], [(c @ A)[None], np.array([[1.0 - c @ A @ c]])]])
        return Rows(np.einsum("kij,ij->k", PSEUDO_INERTIA, Q)[None], np.zeros(1))


@dataclass(frozen=True)
class InHull(Constraint):
    """All mass lies in the convex hull of points: f_i' J f_j >= 0 for every two facets i and j.

    A facet's f_i'[p 1] is the distance of p from it, counted inwards: inside the hull a product of two is not
    negative, nor is its integral over the mass. Necessary for every body inside; together with ``PossibleBody``
    sufficient if the hull is a tetrahedron. It implies that the centre of mass lies in the hull. A hull of k facets
    gives k (k - 1) / 2 inequalities: simplify fine meshes first.

    Attributes:
        points: p x 3 [m], p >= 4, not all in one plane.
    """

    points: ArrayLike = field(repr=False)

    def __post_init__(self) -> None:
        """Refuse a hull without volume."""
        object.__setattr__(self, "points", as_tuples(self.points, (None, 3), "points of a hull"))
        points = np.asarray(self.points)
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) if len(points) > 3 else np.zeros(3)
        if spread[-1] <= 1e-9 * spread[0]:
            raise InputError(f"the hull of {len(points)} points has no volume: give points that span a solid")

    @property
    def description(self) -> str:
        """What is demanded, in one line."""
        return f"mass in the convex hull of {len(np.asarray(self.points))} points"

    @cached_property
    def facets(self) -> Array:
        """f_i as rows: unit inward normal and offset, facets x 4."""
        from scipy.spatial import ConvexHull

        # Triangles of one flat facet come with the same equation.
        return np.asarray(-np.unique(ConvexHull(np.asarray(self.points)).equations.round(12), axis=0))

    @cached_property
    def rows(self) -> Rows:
        """f_i' J f_j >= 0 for i < j [kg m^2]."""
        i, j = np.triu_indices(len(self.facets), 1)
        A = np.einsum("pa,kab,pb->pk", self.facets[i], PSEUDO_INERTIA, self.facets[j], optimize=True)
        return Rows(A, np.zeros(len(A)))
