"""Shapes of a view as triangles and lines, each fixed to a frame.

Links look as the meshes that a URDF names, coarse enough for one page; these need the extra ``view``.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.robot import Mesh

_FACES = 24_000  # triangles of all links together: some 0.5 MB of the page
_LARGEST = 100_000_000  # bytes of a file
_CELLS = (256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8)  # along the longest side of a mesh, finest first
_CORNERS = (20, 16)  # of a capsule around its axis, and from pole to pole
_HALVED = 2  # times that an icosahedron's edges are halved for a sphere
Triangles = tuple[Array, NDArray[np.uint32]]
"""Corners (k, 3) [m] and, turning outwards, the three of each triangle (m, 3)."""
Colour = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles in a frame; its name is unique in a view.

    Attributes:
        frame: number of the frame it is fixed to; 0 is the base's.
        vertices: [m], shape (k, 3).
        faces: corners of each triangle, shape (m, 3).
        colour: red, green, blue, 0 to 255.
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
class Line:
    """A line through points (k, 3) in the base's frame [m], with a colour for each of its k - 1 pieces."""

    name: str
    points: Array
    colours: NDArray[np.uint8]


def capsule(start: Array, end: Array, radius: float) -> Triangles:
    """Points within ``radius`` of a line [m]."""
    trimesh, axis = _trimesh(), np.asarray(end, dtype=float) - start
    turned = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], axis if axis.any() else [0.0, 0.0, 1.0])
    turned[:3, 3] = start + 0.5 * axis
    return _triangles(trimesh.creation.capsule(np.linalg.norm(axis), radius, _CORNERS, turned))


def ellipsoid(centre: Array, axes: Array) -> Triangles:
    """An ellipsoid whose half axes are the columns of ``axes`` [m]."""
    sphere, faces = _triangles(_trimesh().creation.icosphere(_HALVED))
    return centre + sphere @ axes.T, faces


def box(centre: Array, axes: Array) -> Triangles:
    """A box whose half edges are the columns of ``axes`` [m]."""
    corners, faces = _triangles(_trimesh().creation.box((2.0, 2.0, 2.0)))
    return centre + corners @ axes.T, faces


def plane(normal: Sequence[float], offset: float, half: float) -> Triangles:
    """A square of a floor or a wall, thin, below the point of the surface that is nearest to the base [m]."""
    R, thin = _trimesh().geometry.align_vectors([0.0, 0.0, 1.0], normal)[:3, :3], 1e-3 * half
    return box((offset - thin) * R[:, 2], R * [half, half, thin])


def inertia_axes(mass: float, inertia: Array) -> Array:
    """Half axes of the homogeneous ellipsoid of a mass [kg] and an inertia about its centre [kg m^2], 3 x 3 [m].

    Second moments of an ellipsoid are m a^2 / 5; those of a body tr(I)/2 - I. Negative ones, which no body has,
    count as zero.
    """
    moments, directions = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    return np.asarray(directions * np.sqrt(5.0 * np.maximum(moments, 0.0) / mass))


def _trimesh() -> Any:
    return import_module("trimesh")


def _triangles(mesh: Any) -> Triangles:
    return np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces).astype(np.uint32)


def looks_of(robot: Robot, colour: Colour) -> tuple[list[Shape], set[int], list[str]]:
    """Meshes of a robot's links; a link one of whose files is missing or cannot be read has none.

    Returns:
        The shapes, the numbers of the links that have them, and what could not be drawn.
    """
    links = robot.links.meshes if robot.links is not None else ()
    most = _FACES // max(sum(map(len, links)), 1)
    shapes: list[Shape] = []
    drawn, failures = set[int](), dict[str, str]()
    for number, meshes in enumerate(links):
        own: list[Shape] = []
        try:
            for mesh in meshes:
                name = f"link {number}/mesh {len(own) + 1}"
                own.append(Shape(name, number, *coarse(*_placed(mesh), most), colour))
        except InputError as failure:
            failures.setdefault(str(failure), mesh.file)
            continue
        shapes += own
        drawn |= {number} if own else set()
    notes = [
        f"links are drawn as capsules where a mesh {reason} (such as {file})" for reason, file in failures.items()
    ]
    return shapes, drawn, notes


def _placed(mesh: Mesh) -> Triangles:
    """Triangles of a file in the link's frame."""
    path = Path(mesh.file)
    if not path.is_file():
        reason = "is not there: put the description's package beside it, or name it by ROS_PACKAGE_PATH"
        raise InputError(reason)
    if path.stat().st_size > _LARGEST:
        raise InputError(f"is larger than {_LARGEST // 1_000_000} MB")
    try:
        scene = _trimesh().load_scene(path, process=False)
        vertices, faces = _triangles(scene.to_mesh())
        # A file of Collada says its unit, others are in metres.
        unit = re.fullmatch(r"([\d.eE+-]+) \* meters", str(scene.units or ""))
        vertices = (float(unit[1]) if unit else 1.0) * vertices
    except Exception as fault:  # readers of many formats, each with errors of its own
        raise InputError(f"cannot be read ({type(fault).__name__})") from None
    if not len(faces) or not np.isfinite(vertices).all():
        raise InputError("holds no triangles")
    return vertices * mesh.scale @ mesh.pose.R.T + mesh.pose.p, faces


def coarse(vertices: Array, faces: NDArray[np.uint32], most: int) -> Triangles:
    """At most so many triangles: corners that share a cell of a grid become one, at their mean (Rossignac 1993).

    The coarsest grid may leave more.
    """
    if len(faces) <= most:
        return vertices, faces
    low = vertices.min(axis=0)
    size = max(float(np.ptp(vertices, axis=0).max()), 1e-12)
    corners, triangles = vertices, faces.astype(np.intp)
    for cells in _CELLS:
        places = np.floor((vertices - low) * (cells / size)).astype(np.int64)
        _, which, count = np.unique(places, axis=0, return_inverse=True, return_counts=True)
        which = which.ravel()
        corners = np.stack([np.bincount(which, vertices[:, k]) / count for k in range(3)], axis=1)
        triangles = which[faces]
        a, b, c = triangles.T
        triangles = np.unique(triangles[(a != b) & (b != c) & (c != a)], axis=0)
        if len(triangles) <= most:
            break
    used, places = np.unique(triangles, return_inverse=True)
    return corners[used], places.reshape(-1, 3).astype(np.uint32)
