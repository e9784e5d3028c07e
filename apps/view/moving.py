"""An arm in motion as a view: what is where at each time, without any viewer."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation import PayloadResult
from ...model import InertialParameters, Motion, Pose, Recording, Robot
from ...model.frames import frames_at, point_at
from ...model.stand_in import cylinder_radius
from ...trajectories import DesignProblem, Scene
from ...trajectories.design.scene import tubes
from ...trajectories.design.score import room_over_time, taught_over_time
from .shapes import Colour, Shape, box, capsule, ellipsoid, inertia_axes, looks_of, plane

_RATE, _MOST = 20.0, 450  # times a second, and in all
_FINER = 5  # points of the path, than times: at a pose every .05 s a fast path has corners
_THICK = 0.35  # radius of a drawn link, of the stand-in's cylinder
_LINK, _AXIS, _NEAR, _BODY, _FLOOR = (90, 110, 140), (30, 60, 200), (220, 40, 30), (200, 140, 40), (200, 205, 210)
_BALL, _CENTRE, _INERTIA, _PATH = (240, 180, 60), (220, 40, 30), (60, 160, 90), (70, 70, 70)
_LITTLE, _MUCH, _FOOT = (200, 210, 230), (200, 30, 60), (150, 150, 150)
_LEVEL = 1e-6  # of a unit normal: what a floor may lie off the base's plane
_TOUCHED = 0.02  # of a limit: a joint nearer to one is marked
ShownPayload = tuple[Array, InertialParameters | None]
"""Of a payload in its frame the 95 % interval of its centre of mass [m], 3 x 2, and it itself where it is known."""


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
    meshes, drawn_links, notes = looks_of(robot, _LINK)
    touched = np.zeros((len(picked), robot.n), dtype=bool)  # joints at a limit between the shown times
    if problem is not None:
        touched = np.logical_or.reduceat(room_over_time(problem, motion) < _TOUCHED, picked, axis=0)
    stand_ins = [
        Shape(tube.name, tube.link, capsule(np.array(tube.start), np.array(tube.end), tube.radius), _LINK)
        for tube in tubes(robot, _THICK * cylinder_radius(robot))
        if tube.link not in drawn_links
    ]
    height, foot = ground_of(robot, frames, problem.scene if problem is not None else None)
    shapes = [*stand_ins, *meshes, *_axes(robot, touched), *(_surroundings(problem, robot) if problem else ())]
    interval, body = payload if payload is not None else (np.full((3, 2), np.nan), None)
    if np.isfinite(interval).all():
        ball = ellipsoid(interval.mean(axis=1), np.diag(0.5 * np.ptp(interval, axis=1)))
        shapes.append(Shape("centre of mass, 95 %", robot.n + 1, ball, _CENTRE))
    if body is not None:
        solid = ellipsoid(body.com, inertia_axes(body.mass, body.inertia_com))
        shapes.append(Shape("ellipsoid of inertia", robot.n + 1, solid, _INERTIA, 0.3))
    shapes += foot
    drawn = _picked(motion, _FINER)
    position = point_at(robot, robot.flange.p, motion.q[drawn])[0].T
    path = (position - robot.base.p) @ robot.base.R
    moves = len(path) > 1
    colours = np.tile(np.array(_PATH, dtype=np.uint8), (len(path) - 1, 1))
    if problem is not None and moves:  # pale where a second teaches little, red where it teaches most
        taught = np.add.reduceat(taught_over_time(problem, motion), drawn[:-1])
        rate = taught / np.maximum(np.diff(motion.t[drawn]), 1e-9)
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


def ground_of(robot: Robot, frames: Sequence[tuple[Pose, ...]], scene: Scene | None) -> tuple[float, list[Shape]]:
    """Height of the scene's floor, and what the arm stands on there, in frame 0.

    Without a floor it is the base's own plane, or the lowest place of the arm that is below it; no description says
    what an arm is bolted to.
    """
    first, radius = frames[0][0], cylinder_radius(robot)
    lowest = min(float(pose.p[2]) for poses in frames for pose in poses)
    levels = []
    for surface in scene.surfaces if scene is not None else ():
        up = first.R @ surface.normal / np.linalg.norm(surface.normal)
        levels += [surface.offset + float(up @ first.p)] if up[2] > 1.0 - _LEVEL else []
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


def _axes(robot: Robot, touched: NDArray[np.bool_]) -> list[Shape]:
    """Joint axes; a red one over it while the joint is at a limit."""
    radius, shapes = cylinder_radius(robot), []
    ends = np.array([0.0, 0.0, 1.2 * radius])
    for j in range(robot.n):
        shapes.append(Shape(f"axis {j + 1}", j + 1, capsule(-ends, ends, 0.12 * radius), _AXIS))
        if touched[:, j].any():
            marked = capsule(-ends, ends, 0.5 * radius)
            shapes.append(Shape(f"at limit {j + 1}", j + 1, marked, _NEAR, 0.6, touched[:, j]))
    return shapes


def _surroundings(problem: DesignProblem, robot: Robot) -> list[Shape]:
    half, payloads, shapes, scene = 12.0 * cylinder_radius(robot), problem.payloads, list[Shape](), problem.scene
    for surface in scene.surfaces if scene is not None else ():
        shapes.append(Shape(surface.name, 0, plane(surface.normal, surface.offset, half), _FLOOR, 0.6))
    for body in scene.bodies if scene is not None else ():
        ends = np.array(body.start), np.array(body.start if body.end is None else body.end)
        shapes.append(Shape(body.name, body.link, capsule(*ends, body.radius), _BODY, 0.4))
    if payloads is not None:
        mesh = (box if payloads.region == "cube" else ellipsoid)(payloads.centre, payloads.axes)
        shapes.append(Shape("payloads within bounds", robot.n, mesh, _BALL, 0.25))
    return shapes
