"""The arm as a stick figure: moving, as an SVG that needs nothing else, and as a strip of still poses.

The animation is SMIL, which browsers play without a script. Seen from the side (x, z) and from above (x, y).
"""

from xml.sax.saxutils import escape, quoteattr

import numpy as np

from ....common.arrays import Array
from ....model import Robot
from ....model.frames import frames_at
from ....trajectories.motions import Plan
from ..blocks import Drawing
from .canvas import Figure, panels
from .stick import outline

_FRAMES = 12.0  # per second
_FINER = 3  # the path of the tool, than that
_SIZE, _GAP = 260, 20  # px: of a view, and between views
_STILL = 0.1  # px: a joint that moves less, or lies so near to the one before, is not drawn
_TOOL, _FOOT = 0.12, 0.3  # of the reach: line along the last joint's z, and down to the floor
_POSES = "The arm at eight times of the motion, from the first to the last."
_VIEWS = (("side view (x, z)", (0, 2)), ("from above (x, y)", (0, 1)))


def arm_points(robot: Robot, q: Array) -> Array:
    """Points of the stick figure in the base's axes [m], (N, 2 n + 5, 3): foot, ``outline``, the end of a tool.

    Foot and tool are drawn, not measured: a description holds neither.
    """
    reach, lines = _reach(robot), []
    for pose in np.atleast_2d(q):
        arm = outline(robot, pose.tolist())
        foot = arm[0] - [0.0, 0.0, _FOOT * reach]
        tool = arm[-1] + _TOOL * reach * frames_at(robot, pose.tolist())[-1].R[:, 2]
        lines.append(np.vstack([foot, arm, tool]))
    return np.array(lines)


def arm_animation(robot: Robot, plan: Plan, identifier: str = "arm") -> str:
    """The motion in real time, over and over, as one ``<svg>`` element for a page of HTML.

    Args:
        identifier: of the element, different for each on a page.
    """
    frames = max(int(plan.duration * _FRAMES), 2) + 1
    points = arm_points(robot, plan.at(np.linspace(0.0, plan.duration, frames))[0])
    path = arm_points(robot, plan.at(np.linspace(0.0, plan.duration, _FINER * frames))[0])[:, -1]
    title = f"{robot.title or robot.name}: {plan.duration:.1f} s of motion as a stick figure"
    size = (len(_VIEWS) * (_SIZE + _GAP) + _GAP, _SIZE + 2 * _GAP)
    half = 1.05 * float(max(np.abs(points).max(), np.abs(path).max()))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" id={quoteattr(identifier)} viewBox="0 0 {size[0]} {size[1]}" '
        f'width="{size[0]}" role="img" aria-label={quoteattr(title)} style="max-width:100%;height:auto">',
        f"<title>{escape(title)}</title>",
    ]
    for k, (name, axes) in enumerate(_VIEWS):
        left = _GAP + k * (_SIZE + _GAP)
        lines += _view(points[:, :, axes], path[:, axes], half, left, name, plan.duration)
    return "\n".join([*lines, "</svg>"]) + "\n"


def arm_strip(robot: Robot, plan: Plan, poses: int = 8) -> Drawing:
    """Still poses at even times, side view above, from above below."""
    return Drawing("poses", _POSES, _POSES, lambda: _strip(robot, plan, poses))


def _strip(robot: Robot, plan: Plan, poses: int) -> Figure:
    times = np.linspace(0.0, plan.duration, poses)
    still = arm_points(robot, plan.at(times)[0])
    path = arm_points(robot, plan.at(np.linspace(0.0, plan.duration, 400))[0])[:, -1]
    half = 1.1 * float(max(np.abs(still).max(), np.abs(path).max()))
    figure, rows = panels(
        (1.45 * poses, 3.4), 2, poses, (0.3, 0.05, 0.5, 0.05), (0.08, 0.1), sharex=True, sharey=True
    )
    for axis, t in zip(rows[0], times, strict=True):
        axis.set_title(f"{t:.1f} s", fontsize=9)
    for row, (name, axes) in zip(rows, _VIEWS, strict=True):
        for axis, pose in zip(row, still, strict=True):
            axis.plot(*path[:, axes].T, color="0.75", linewidth=0.6)
            axis.plot(*pose[:, axes].T, "-o", color="black", linewidth=1.8, markersize=3)
            axis.plot(*pose[-1:, axes].T, "s", color="black", markersize=5, fillstyle="none")
            axis.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xticks=[], yticks=[])
        row[0].set_ylabel(name, fontsize=8)
    figure.suptitle(f"{robot.title or robot.name}: poses of the motion, path of the tool in grey", fontsize=10)
    return figure


def _view(points: Array, path: Array, half: float, left: float, name: str, duration: float) -> list[str]:
    """One view: frame, path of the tool, the moving arm with its joints."""
    scale = 0.5 * _SIZE / half * np.array([1.0, -1.0])
    middle = np.array([left, _GAP]) + 0.5 * _SIZE
    xy, track_of_tool = middle + scale * points, middle + scale * path
    poses = [_points(pose) for pose in xy]
    moves = f'dur="{duration:.3f}s" repeatCount="indefinite"'
    lines = [
        f'<rect x="{left}" y="{_GAP}" width="{_SIZE}" height="{_SIZE}" fill="none" stroke="currentColor" '
        'stroke-width="0.5"/>',
        f'<text x="{left + 6}" y="{_GAP + 14}" font-size="11" fill="currentColor">{escape(name)}</text>',
        f'<polyline points="{_points(track_of_tool)}" fill="none" stroke="currentColor" stroke-opacity="0.3" '
        'stroke-width="0.7"/>',
        f'<polyline points="{poses[0]}" fill="none" stroke="currentColor" stroke-width="4" '
        'stroke-linejoin="round" stroke-linecap="round">',
        f'<animate attributeName="points" {moves} values="{";".join(poses)}"/></polyline>',
    ]
    tracks = xy.transpose(1, 0, 2)
    for k, track in enumerate(tracks):
        if np.ptp(track, axis=0).max() > _STILL and (k == 0 or np.abs(track - tracks[k - 1]).max() > _STILL):
            x, y = (";".join(f"{value:.1f}" for value in track[:, axis]) for axis in (0, 1))
            lines += [
                f'<circle cx="{track[0, 0]:.1f}" cy="{track[0, 1]:.1f}" r="{3 if k < len(tracks) - 1 else 5}" '
                'fill="white" stroke="currentColor" stroke-width="1.5">',
                f'<animate attributeName="cx" {moves} values="{x}"/>',
                f'<animate attributeName="cy" {moves} values="{y}"/></circle>',
            ]
    return lines


def _points(line: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in line)


def _reach(robot: Robot) -> float:
    """Length of the stretched arm [m]; 1 for an arm of lengths zero."""
    slide = [max(map(abs, joint.limits.position)) for joint in robot.joints if not joint.revolute]
    finite = [value for value in slide if np.isfinite(value)]
    return sum(float(np.hypot(joint.d, joint.r)) for joint in robot.joints) + sum(finite) or 1.0
