"""Shapes of a view as triangles, each fixed to a frame.

Links look as the meshes that a URDF names, coarse enough for one page; these need the extra ``view``.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh import Trimesh

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.robot import Mesh

_FACES = 24_000  # triangles of all links together: some 0.5 MB of the page
_LARGEST = 100_000_000  # bytes of a file
_CELLS = (256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8)  # along the longest side of a mesh, finest first
_CORNERS = (20, 16)  # of a capsule around its axis, and from pole to pole
_HALVED = 2  # times that an icosahedron's edges are halved for a sphere
Colour = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles in a frame [m]; its name is unique in a view.

    Attributes:
        frame: number of the frame it is fixed to; 0 is the base's.
        colour: red, green, blue, 0 to 255.
        shown: at which of the view's times; always if None.
    """

    name: str
    frame: int
    mesh: Trimesh
    colour: Colour
    opacity: float = 1.0
    shown: NDArray[np.bool_] | None = None


def capsule(start: Array, end: Array, radius: float) -> Trimesh:
    """Points within ``radius`` of a line [m]."""
    axis = np.asarray(end, dtype=float) - start
    pose = _affine(_along(axis if axis.any() else [0.0, 0.0, 1.0]), start + 0.5 * axis)
    return trimesh.creation.capsule(float(np.linalg.norm(axis)), radius, _CORNERS, pose)


def ellipsoid(centre: Array, axes: Array) -> Trimesh:
    """An ellipsoid whose half axes are the columns of ``axes`` [m]."""
    return trimesh.creation.icosphere(_HALVED).apply_transform(_affine(axes, centre))


def box(centre: Array, axes: Array) -> Trimesh:
    """A box whose half edges are the columns of ``axes`` [m]."""
    return trimesh.creation.box((2.0, 2.0, 2.0), _affine(axes, centre))


def plane(normal: Sequence[float], offset: float, half: float) -> Trimesh:
    """A square of a floor or a wall, thin, below the point of the surface that is nearest to the base [m]."""
    R, thin = _along(normal), 1e-3 * half
    return box((offset - thin) * R[:, 2], R * [half, half, thin])


def inertia_axes(mass: float, inertia: Array) -> Array:
    """Half axes of the homogeneous ellipsoid of a mass [kg] and an inertia about its centre [kg m^2], 3 x 3 [m].

    Second moments of an ellipsoid are m a^2 / 5; those of a body tr(I)/2 - I. Negative ones, which no body has,
    count as zero.
    """
    moments, directions = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    return np.asarray(directions * np.sqrt(5.0 * np.maximum(moments, 0.0) / mass))


def _along(z: Array | Sequence[float]) -> Array:
    return np.asarray(trimesh.geometry.align_vectors([0.0, 0.0, 1.0], z)[:3, :3])


def _affine(axes: Array, origin: Array) -> Array:
    return np.vstack([np.column_stack([axes, origin]), [0.0, 0.0, 0.0, 1.0]])


def looks_of(robot: Robot, colour: Colour) -> tuple[list[Shape], set[int], list[str]]:
    """Meshes of a robot's links, the numbers of the links that have them, and what could not be drawn."""
    links = robot.links.meshes if robot.links is not None else ()
    most = _FACES // max(sum(map(len, links)), 1)
    shapes, failures = list[Shape](), dict[str, str]()
    for number, meshes in enumerate(links):
        own: list[Shape] = []
        try:
            for mesh in meshes:
                name = f"link {number}/mesh {len(own) + 1}"
                own.append(Shape(name, number, coarse(_placed(mesh), most), colour))
            shapes += own
        except InputError as failure:
            failures.setdefault(str(failure), mesh.file)
    notes = [f"links are capsules where a mesh {reason} (such as {file})" for reason, file in failures.items()]
    return shapes, {shape.frame for shape in shapes}, notes


def _placed(mesh: Mesh) -> Trimesh:
    path = Path(mesh.file)
    if not path.is_file():
        raise InputError("is not there: put the description's package beside it, or name it by ROS_PACKAGE_PATH")
    if path.stat().st_size > _LARGEST:
        raise InputError(f"is larger than {_LARGEST // 1_000_000} MB")
    try:
        scene = trimesh.load_scene(path, process=False)
        # A file of Collada says its unit, others are in metres.
        unit = re.fullmatch(r"([\d.eE+-]+) \* meters", str(scene.units or ""))
        axes = (float(unit[1]) if unit else 1.0) * mesh.pose.R * mesh.scale
        solid = scene.to_mesh().apply_transform(_affine(axes, mesh.pose.p))
    except Exception as fault:  # readers of many formats, each with errors of its own
        raise InputError(f"cannot be read ({type(fault).__name__})") from None
    if not len(solid.faces) or not np.isfinite(solid.vertices).all():
        raise InputError("has no triangles")
    return solid


def coarse(mesh: Trimesh, most: int) -> Trimesh:
    """At most so many triangles: corners that share a cell of a grid become one (Rossignac 1993).

    The coarsest grid may leave more.
    """
    fewer = mesh
    for cells in _CELLS:
        if len(fewer.faces) <= most:
            break
        scale = cells / max(float(mesh.extents.max()), 1e-12)
        fewer = mesh.copy()
        fewer.vertices *= scale
        fewer.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=0)
        fewer.update_faces(fewer.unique_faces() & fewer.nondegenerate_faces())
        fewer.vertices /= scale
    fewer.remove_unreferenced_vertices()
    return fewer
