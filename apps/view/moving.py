"""An arm in motion as a view: what is where at each time, as triangles fixed to frames; and its HTML file.

Links look as the meshes that a URDF names, coarse enough for one page. The file is self-contained, by viser's
serialised scene. Both need the extra ``view``.
"""

from __future__ import annotations

import contextlib
import io
import re
import webbrowser
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_text
from ...estimation import PayloadResult
from ...model import InertialParameters, Motion, Pose, Recording, Robot
from ...model.frames import frames_at, point_at
from ...model.robot import Mesh
from ...model.stand_in import cylinder_radius
from ...trajectories import DesignProblem, Scene
from ...trajectories.design.scene import tubes
from ...trajectories.design.score import over_time
from ..extras import extra
from ..numbers import quaternion

if TYPE_CHECKING:
    from trimesh import Trimesh

_FACES = 24_000  # triangles of all links together: some 0.5 MB of the page
_LARGEST = 100_000_000  # bytes of a file
_CELLS = (256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8)  # along the longest side of a mesh, finest first
_CORNERS = (20, 16)  # of a capsule around its axis, and from pole to pole
_HALVED = 2  # times that an icosahedron's edges are halved for a sphere
_RATE, _MOST = 20.0, 450  # times a second, and in all
_FINER = 5  # points of the path, than times: at a pose every .05 s a fast path has corners
_THICK = 0.35  # radius of a drawn link, of the stand-in's cylinder
_LINK, _AXIS, _NEAR, _BODY, _FLOOR = (90, 110, 140), (30, 60, 200), (220, 40, 30), (200, 140, 40), (200, 205, 210)
_BALL, _CENTRE, _INERTIA, _PATH = (240, 180, 60), (220, 40, 30), (60, 160, 90), (70, 70, 70)
_LITTLE, _MUCH, _FOOT = (200, 210, 230), (200, 30, 60), (150, 150, 150)
_LEVEL = 1e-6  # of a unit normal: what a floor may lie off the base's plane
_TOUCHED = 0.02  # of a limit: a joint nearer to one is marked
_LAST = 1.0  # s: how long the last pose stays
_STILL = 1e-9  # m and of a turn: what moves less is not written again
_NEEDED = "--view needs the extra view: pip install 'dynident[view]'"
trimesh = extra("trimesh", _NEEDED)
Colour = tuple[int, int, int]
ShownPayload = tuple[Array, InertialParameters | None]
"""Of a payload in its frame the 95 % interval of its centre of mass [m], 3 x 2, and it itself where it is known."""


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


@dataclass(frozen=True, eq=False)
class View:
    """An arm in motion as a viewer shows it.

    Attributes:
        times: [s], shape (N,).
        frames: poses of frames 0 to n and the payload's, in the base, at each time.
        path: points of the flange in the base [m], shape (k, 3); one where it does not move.
        path_colours: of each piece between them, shape (k - 1, 3).
        legend: colours and their words, of what is not the arm itself.
        notes: what could not be shown as it looks.
        ground: height of the plane that the arm stands on, in the base [m].
    """

    title: str
    times: Array
    frames: tuple[tuple[Pose, ...], ...]
    shapes: tuple[Shape, ...]
    path: Array
    path_colours: NDArray[np.uint8]
    legend: tuple[tuple[Colour, str], ...] = ()
    notes: tuple[str, ...] = ()
    ground: float = 0.0


def view_of(
    robot: Robot, motion: Motion, *, problem: DesignProblem | None = None, payload: ShownPayload | None = None
) -> View:
    """The arm along a motion, or at its single sample, with a payload.

    Of a ``problem`` scene, limits and payloads are shown too, and what each second teaches.
    """
    if not np.isfinite(motion.q).all():
        raise InputError("a view needs finite positions at every time")
    picked = _picked(motion)
    frames = tuple(frames_at(robot, q.tolist()) for q in motion.q[picked])
    meshes, drawn_links, notes = looks_of(robot)
    touched, taught = np.zeros((len(picked), robot.n), dtype=bool), np.zeros(len(motion.t))
    if problem is not None:
        room, taught = over_time(problem, motion)
        touched = np.logical_or.reduceat(room < _TOUCHED, picked, axis=0)  # at a limit between the shown times
    radius = cylinder_radius(robot)
    bare = (tube for tube in tubes(robot, _THICK * radius) if tube.link not in drawn_links)
    shapes = [Shape(tube.name, tube.link, capsule(tube.start, tube.end, tube.radius), _LINK) for tube in bare]
    shapes += meshes
    ends = np.array([0.0, 0.0, 1.2 * radius])
    for j in range(robot.n):  # joint axes; a red one over it while the joint is at a limit
        shapes.append(Shape(f"axis {j + 1}", j + 1, capsule(-ends, ends, 0.12 * radius), _AXIS))
        if touched[:, j].any():
            marked = capsule(-ends, ends, 0.5 * radius)
            shapes.append(Shape(f"at limit {j + 1}", j + 1, marked, _NEAR, 0.6, touched[:, j]))
    scene = (problem.scene if problem is not None else None) or Scene()
    for surface in scene.surfaces:
        shapes.append(Shape(surface.name, 0, plane(surface.normal, surface.offset, 12.0 * radius), _FLOOR, 0.6))
    for obstacle in scene.bodies:
        solid = capsule(obstacle.start, obstacle.end, obstacle.radius)
        shapes.append(Shape(obstacle.name, obstacle.link, solid, _BODY, 0.4))
    if problem is not None and (payloads := problem.payloads) is not None:
        mesh = (box if payloads.region == "cube" else ellipsoid)(payloads.centre, payloads.axes)
        shapes.append(Shape("payloads within bounds", robot.n, mesh, _BALL, 0.25))
    interval, body = payload if payload is not None else (np.full((3, 2), np.nan), None)
    if np.isfinite(interval).all():
        ball = ellipsoid(interval.mean(axis=1), np.diag(0.5 * np.ptp(interval, axis=1)))
        shapes.append(Shape("centre of mass, 95 %", robot.n + 1, ball, _CENTRE))
    if body is not None:
        solid = ellipsoid(body.com, inertia_axes(body.mass, body.inertia_com))
        shapes.append(Shape("ellipsoid of inertia", robot.n + 1, solid, _INERTIA, 0.3))
    height, foot = ground_of(robot, frames, scene)
    shapes += foot
    drawn = _picked(motion, _FINER)
    path = (point_at(robot, robot.flange.p, motion.q[drawn])[0].T - robot.base.p) @ robot.base.R
    moves = len(path) > 1
    colours = np.tile(np.array(_PATH, dtype=np.uint8), (len(path) - 1, 1))
    if problem is not None and moves:  # pale where a second teaches little, red where it teaches most
        rate = np.add.reduceat(taught, drawn[:-1]) / np.maximum(np.diff(motion.t[drawn]), 1e-9)
        ratio = np.sqrt(rate / max(float(rate.max()), 1e-300))[:, None]
        colours = np.asarray((1.0 - ratio) * np.array(_LITTLE) + ratio * np.array(_MUCH)).astype(np.uint8)
    title = (robot.title or robot.name) + (f", {motion.t[-1] - motion.t[0]:.3g} s" if moves else "")
    named = {(shape.colour, shape.name.rstrip(" 0123456789")) for shape in shapes}  # without numbers of joints
    legend = sorted((colour, text) for colour, text in named if not text.startswith(("link", "axis")))
    taught_by = [(_LITTLE, "path of the flange where a second teaches little"), (_MUCH, "where it teaches most")]
    if moves:
        legend += taught_by if problem is not None else [(_PATH, "path of the flange")]
    times = motion.t[picked] - motion.t[0]
    return View(title, times, frames, tuple(shapes), path, colours, tuple(legend), tuple(notes), height)


def view_of_answer(robot: Robot, recording: Recording, result: PayloadResult) -> View:
    """The arm along a recording, with the payload that was identified; its inertia where that may be used."""
    still = np.zeros_like(recording.q)
    body = result.best.body if result.best is not None and result.verdict.level == "use" else None
    return view_of(robot, Motion(recording.t, recording.q, still, still), payload=(result.com.interval95, body))


def ground_of(robot: Robot, frames: Sequence[tuple[Pose, ...]], scene: Scene) -> tuple[float, list[Shape]]:
    """Height of the scene's floor, or of the base's plane or the arm's lowest place; what the arm stands on."""
    first, radius = frames[0][0], cylinder_radius(robot)
    lowest = min(float(pose.p[2]) for poses in frames for pose in poses)
    ups = [first.R @ surface.normal / np.linalg.norm(surface.normal) for surface in scene.surfaces]
    sides = zip(scene.surfaces, ups, strict=True)
    levels = [surface.offset + float(up @ first.p) for surface, up in sides if up[2] > 1.0 - _LEVEL]
    floor = max((level for level in levels if level <= 0.0), default=None)  # under the base's origin
    height = floor if floor is not None else lowest - radius if lowest < -radius else 0.0
    if height > -radius:
        return height, []
    top, end = (first.R.T @ (np.array([0.0, 0.0, z]) - first.p) for z in (0.0, height))
    unknown = "neither its height nor its shape is known" if floor is None else "its shape is not known"
    return height, [Shape(f"foot, {unknown}", 0, capsule(top, end, 0.5 * radius), _FOOT, 0.3)]


def _picked(motion: Motion, finer: int = 1) -> NDArray[np.intp]:
    """Samples that are shown, the first and the last among them; so many times as many where ``finer``."""
    duration = float(motion.t[-1] - motion.t[0])
    count = min(len(motion.t), finer * _MOST, max(int(duration * finer * _RATE) + 1, 2))
    return np.unique(np.linspace(0, len(motion.t) - 1, count).round().astype(np.intp))


def capsule(start: ArrayLike, end: ArrayLike | None, radius: float) -> Trimesh:
    """Points within ``radius`` of a line [m], or of its start alone."""
    first, last = (np.asarray(x, dtype=float) for x in (start, start if end is None else end))
    axis = last - first
    pose = _affine(_along(axis if axis.any() else [0.0, 0.0, 1.0]), first + 0.5 * axis)
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
    """Half axes of the homogeneous ellipsoid of a mass [kg] and an inertia about its centre [kg m^2], 3 x 3 [m]."""
    # Second moments of an ellipsoid are m a^2 / 5; those of a body tr(I)/2 - I, negative ones being no body's.
    moments, directions = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    return np.asarray(directions * np.sqrt(5.0 * np.maximum(moments, 0.0) / mass))


def _along(z: Array | Sequence[float]) -> Array:
    return np.asarray(trimesh.geometry.align_vectors([0.0, 0.0, 1.0], z)[:3, :3])


def _affine(axes: Array, origin: Array) -> Array:
    return np.vstack([np.column_stack([axes, origin]), [0.0, 0.0, 0.0, 1.0]])


def looks_of(robot: Robot) -> tuple[list[Shape], set[int], list[str]]:
    """Meshes of a robot's links, the numbers of the links that have them, and what could not be drawn."""
    links = robot.links.meshes if robot.links is not None else ()
    most = _FACES // max(sum(map(len, links)), 1)
    shapes, failures = list[Shape](), dict[str, str]()
    for number, meshes in enumerate(links):
        own: list[Shape] = []
        try:
            for mesh in meshes:
                name = f"link {number}/mesh {len(own) + 1}"
                own.append(Shape(name, number, coarse(_placed(mesh), most), _LINK))
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
    """So many triangles or fewer, if a grid allows: corners that share a cell become one (Rossignac 1993)."""
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


def require_viewer() -> Any:
    """The library of views; where it is not installed, a refusal says what to install."""
    return extra("viser", _NEEDED)


def open_view(view: View) -> str:
    """Open the view in the browser, as a file in a folder for temporary files; its path."""
    page = Path(mkdtemp(prefix="dynident_")) / "view.html"
    write_text(page, html_of(view))
    if not webbrowser.open(page.as_uri()):
        raise InputError(f"--view -: no browser could be opened: open {page} in one")
    return str(page)


def html_of(view: View) -> str:
    """The view as HTML: made by a server on a free port of this machine alone, which says nothing."""
    viser = require_viewer()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.ExitStack() as at_last:
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        at_last.callback(server.stop)
        scene, frames, meshes = server.scene, [], []  # a node for each frame, and below it what is fixed to it
        scene.set_up_direction("+z")
        points = np.array([pose.p for poses in view.frames for pose in poses])
        middle, size = 0.5 * (points.min(axis=0) + points.max(axis=0)), float(np.ptp(points, axis=0).max())
        server.initial_camera.look_at = middle
        server.initial_camera.position = middle + (size + 0.3) * np.array([0.75, -0.85, 0.5])
        ground = (0.0, 0.0, view.ground)
        scene.add_grid(*("/ground", 4.0, 4.0), cell_size=0.1, section_size=1.0, shadow_opacity=0.0, position=ground)
        for number, pose in enumerate(view.frames[0]):
            turn = quaternion(pose.R).tolist()
            frames.append(scene.add_frame(f"/{number}", show_axes=False, wxyz=turn, position=pose.origin))
        for shape in view.shapes:
            name = f"/{shape.frame}/{shape.name.replace('/', ', ')}"
            mesh = scene.add_mesh_simple(
                *(name, shape.mesh.vertices.astype(np.float32), shape.mesh.faces.astype(np.uint32)),
                color=shape.colour,
                opacity=None if shape.opacity >= 1.0 else shape.opacity,
                side="double",
                visible=shape.shown is None or bool(shape.shown[0]),
                cast_shadow=False,
                receive_shadow=False,
            )
            meshes += [(mesh, shape.shown)] if shape.shown is not None else []
        if len(view.path) > 1:
            pieces = np.stack([view.path[:-1], view.path[1:]], axis=1).astype(np.float32)
            colours = np.repeat(view.path_colours[:, None], 2, axis=1)
            scene.add_line_segments("/path of the flange", pieces, colours, thickness=3.0, thickness_units="screen")
        serialiser = server.get_scene_serializer()
        for k in range(1, len(view.times)):
            serialiser.insert_sleep(float(view.times[k] - view.times[k - 1]))
            for frame, before, pose in zip(frames, view.frames[k - 1], view.frames[k], strict=True):
                if np.abs(pose.p - before.p).max() > _STILL:
                    frame.position = pose.origin
                if np.abs(pose.R - before.R).max() > _STILL:
                    frame.wxyz = quaternion(pose.R).tolist()
            for mesh, shown in meshes:
                if shown[k] != shown[k - 1]:
                    mesh.visible = bool(shown[k])
        serialiser.insert_sleep(_LAST)
        page = str(serialiser.as_html())
    mark = '<div><span style="color:rgb{}">&#9632;</span> {}</div>'
    rows = "".join(mark.format(colour, escape(text)) for colour, text in view.legend)
    style = "position:fixed;left:8px;bottom:52px;padding:6px 10px;background:#fffd;color:#222;font:12px sans-serif;"
    summary = f"<summary>{escape(view.title)}</summary>"  # a click closes it on a narrow page
    legend = f'<details open style="{style}border-radius:6px">{summary}{rows}</details>'
    return page.replace("</body>", f"{legend}</body>", 1)
