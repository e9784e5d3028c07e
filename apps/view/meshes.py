"""Links as they look, by the meshes that a URDF names, coarse enough for one page; needs the extra ``view``."""

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Robot
from ...model.robot import Mesh
from .shapes import Colour, Shape

_FACES = 24_000  # triangles of all links together: some 0.5 MB of the page
_LARGEST = 100_000_000  # bytes of a file
_CELLS = (256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8)  # along the longest side of a mesh, finest first


class Looks(NamedTuple):
    """Shapes of the links that have meshes, those links' numbers, and what could not be drawn."""

    shapes: tuple[Shape, ...]
    links: frozenset[int]
    notes: tuple[str, ...]


def looks_of(robot: Robot, colour: Colour) -> Looks:
    """Meshes of a robot's links; a link one of whose files is missing or cannot be read has none."""
    links = robot.links.meshes if robot.links is not None else ()
    count = max(sum(map(len, links)), 1)
    shapes: list[Shape] = []
    drawn, failures = set[int](), dict[str, str]()
    for number, meshes in enumerate(links):
        try:
            own = [
                Shape(f"link {number}/mesh {k}", number, *coarse(*_placed(mesh), _FACES // count), colour)
                for k, mesh in enumerate(meshes, start=1)
            ]
        except _Unreadable as failure:
            failures.setdefault(*map(str, failure.args))
            continue
        shapes += own
        drawn |= {number} if own else set()
    return Looks(tuple(shapes), frozenset(drawn), tuple(_notes(failures)))


def _notes(failures: dict[str, str]) -> Iterator[str]:
    for reason, file in failures.items():
        yield f"links are drawn as capsules where a mesh {reason} (such as {file})"


class _Unreadable(Exception):  # noqa: N818
    """Why a file cannot be drawn, and the file."""


def _placed(mesh: Mesh) -> tuple[Array, NDArray[np.uint32]]:
    """Corners in the link's frame [m], (k, 3), and triangles, (m, 3), of a file.

    Raises:
        _Unreadable: if it is not there, or is no mesh.
    """
    path = Path(mesh.file)
    if not path.is_file():
        reason = "is not there: put the description's package beside it, or name it by ROS_PACKAGE_PATH"
        raise _Unreadable(reason, mesh.file)
    if path.stat().st_size > _LARGEST:
        raise _Unreadable(f"is larger than {_LARGEST // 1_000_000} MB", mesh.file)
    try:
        vertices, faces = _read(path)
    except Exception as fault:  # readers of many formats, each with errors of its own
        raise _Unreadable(f"cannot be read ({type(fault).__name__})", mesh.file) from None
    if not len(faces) or not np.isfinite(vertices).all():
        raise _Unreadable("holds no triangles", mesh.file)
    return vertices * mesh.scale @ mesh.pose.R.T + mesh.pose.p, faces


def _read(path: Path) -> tuple[Array, NDArray[np.uint32]]:
    """Corners [m] and triangles of a file; one of Collada says its unit, others are in metres."""
    trimesh: Any = import_module("trimesh")
    scene = trimesh.load_scene(path, process=False)
    solid = scene.to_mesh()
    unit = re.fullmatch(r"([\d.eE+-]+) \* meters", str(scene.units or ""))
    size = float(unit[1]) if unit else 1.0
    return size * np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces).astype(np.uint32)


def coarse(vertices: Array, faces: NDArray[np.uint32], most: int) -> tuple[Array, NDArray[np.uint32]]:
    """At most so many triangles: corners that share a cell of a grid become one, at their mean (Rossignac 1993).

    Args:
        vertices: shape (k, 3).
        faces: corners of each triangle, shape (m, 3).
        most: triangles; the coarsest grid may leave more.
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
