"""Shapes of a view as triangles and lines, each fixed to a frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array

_AROUND, _UP = 20, 11  # corners of a sphere around its axis, and from pole to pole
Colour = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles in a frame.

    Attributes:
        name: unique in a view.
        frame: number of the frame it is fixed to; 0 is the base's.
        vertices: [m], shape (k, 3).
        faces: corners of each triangle, shape (m, 3).
        colour: red, green, blue, 0 to 255.
        opacity: 0 to 1.
        shown: at which of the view's times; always if None.
    """

    name: str
    frame: int
    vertices: Array
    faces: NDArray[np.uint32]
    colour: Colour
    opacity: float = 1.0
    shown: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False)
class Path:
    """A line through points in the base's frame, coloured piece by piece.

    Attributes:
        name: unique in a view.
        points: [m], shape (k, 3).
        colours: of the pieces, shape (k - 1, 3), 0 to 255.
    """

    name: str
    points: Array
    colours: NDArray[np.uint8]


def capsule(start: Array, end: Array, radius: float) -> tuple[Array, NDArray[np.uint32]]:
    """Points within ``radius`` of a line [m]: two halves of a sphere, drawn apart along it."""
    sphere, faces = _sphere()
    axis = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(axis))
    R = _along(axis / length if length > 0.0 else np.array([0.0, 0.0, 1.0]))
    ends = np.where(sphere[:, 2:] > 0.0, np.asarray(end), np.asarray(start))
    return ends + radius * sphere @ R.T, faces


def ellipsoid(centre: Array, axes: Array) -> tuple[Array, NDArray[np.uint32]]:
    """An ellipsoid whose half axes are the columns of ``axes`` [m]."""
    sphere, faces = _sphere()
    return centre + sphere @ axes.T, faces


def box(centre: Array, axes: Array) -> tuple[Array, NDArray[np.uint32]]:
    """A box whose half edges are the columns of ``axes`` [m]."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    return centre + corners @ axes.T, np.array(faces, dtype=np.uint32)


def plane(normal: Sequence[float], offset: float, half: float) -> tuple[Array, NDArray[np.uint32]]:
    """A square of a floor or a wall, thin, below the point of the surface that is nearest to the base [m]."""
    R, thin = _along(np.asarray(normal, dtype=float) / np.linalg.norm(normal)), 1e-3 * half
    return box((offset - thin) * R[:, 2], R * [half, half, thin])


def inertia_axes(mass: float, inertia: Array) -> Array:
    """Half axes of the homogeneous ellipsoid of a mass [kg] and an inertia about its centre [kg m^2], 3 x 3 [m].

    Second moments of an ellipsoid are m a^2 / 5; those of a body tr(I)/2 - I. Negative ones, which no body has,
    count as zero.
    """
    moments, directions = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    return np.asarray(directions * np.sqrt(5.0 * np.maximum(moments, 0.0) / mass))


def _along(z: Array) -> Array:
    """Axes of a frame whose z axis is given, as columns."""
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _sphere() -> tuple[Array, NDArray[np.uint32]]:
    """Unit sphere about z; poles and equator doubled, so that it can be drawn apart there."""
    tilts = np.concatenate(
        [np.linspace(0.0, 0.5 * np.pi, _UP // 2 + 1), np.linspace(0.5 * np.pi, np.pi, _UP // 2 + 1)]
    )
    turns = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    tilt, turn = (x.ravel() for x in np.meshgrid(tilts, turns, indexing="ij"))
    vertices = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    vertices[np.abs(vertices) < 1e-12] = 0.0
    # The first of the two equators belongs to the upper half.
    vertices[_UP // 2 * _AROUND : (_UP // 2 + 1) * _AROUND, 2] = 1e-12
    faces = []
    for row in range(len(tilts) - 1):
        for k in range(_AROUND):
            a, b = row * _AROUND + k, row * _AROUND + (k + 1) % _AROUND
            faces += [(a, a + _AROUND, b), (b, a + _AROUND, b + _AROUND)]
    return vertices, np.array(faces, dtype=np.uint32)
