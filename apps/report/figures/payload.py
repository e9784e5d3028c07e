"""Figures of a payload: by each joint, method and recording, and where it hangs at the flange; and of an arm."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....estimation.fit.covariance import NORMAL95
from ....estimation.payload.by_joints import JointsMass, Repeats
from ....estimation.results.payload import FreeEstimate, PayloadResult, PossibleEstimate, array, bounds
from ....model import Robot
from ....model.frames import frames_at, step
from ..blocks import Drawing
from .canvas import BLUE, ORANGE, Axes, Figure, legend, matplotlib, panels, plain, save_figure

_FREE = 0.22  # the free estimate stands this much below the constrained one
_NAME = 24  # letters of a recording's name
_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_VIEWS = {"from the side": (0, 2), "from the front": (1, 2), "from above": (0, 1)}
"""Axes to the right and upwards."""


def _interval_rows(
    axis: Axes, names: Sequence[str], values: Array, ends: Array, agreed: Sequence[float], missing: str = ""
) -> None:
    """A row a name: its value and interval (N, 2), or a word; ``agreed``: value, low and high of all together."""
    middle, *band = agreed
    if np.isfinite(band).all():
        axis.axvspan(*band, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    if np.isfinite(middle):
        axis.axvline(middle, color="black", linestyle="--", linewidth=1.0)
    rows, box = np.arange(len(names)), {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axis.hlines(rows, *ends.T, color=BLUE, linewidth=2.0)
    axis.plot(values, rows, "o", color=BLUE, markersize=6)
    for row in np.flatnonzero(np.isnan(values)).tolist():
        axis.text(middle, row, missing, bbox=box, ha="center", va="center", fontsize=9, style="italic")
    axis.set_yticks(rows, names)
    axis.set_ylim(len(names) - 0.4, -0.6)
    plain(axis)


def joints_figure(
    masses: Sequence[JointsMass], mass: float, interval: tuple[float, float], name: str = "by_joints"
) -> list[Drawing]:
    """Mass [kg] by groups of joints, and each joint's share of the payload; none where no group sees it."""
    values = np.array([group.mass if group.interval95 is not None else None for group in masses], dtype=float)
    if all(group.mass is None for group in masses):
        return []
    text = "; ".join(
        f"{group.name} {group.mass:.4g} kg" if group.mass is not None else f"{group.name} does not see it"
        for group in masses
    )
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there, with two standard deviations; 1 where drive gain and friction are right."
    )

    def draw() -> Figure:
        figure, ((left, right),) = panels((9.0, 0.32 * len(masses) + 1.2), 1, 2, width_ratios=(3, 2))
        ends = np.array([array(group.interval95, 2) for group in masses])
        _interval_rows(left, [group.name for group in masses], values, ends, (mass, *interval), "not visible")
        reaches = np.abs(ends - mass).max(axis=1)
        reaches = reaches[np.isfinite(reaches)]
        # One joint that hardly sees the mass must not squeeze the others to a line.
        reach = 1.1 * min(float(reaches.max()), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
        left.set_xlim(mass - reach, mass + reach)
        joints = [group for group in masses if len(group.joints) == 1]
        pairs = [[array(group.share), array(group.share_sigma)] for group in joints]
        shares, sigmas = np.array(pairs, dtype=float).reshape(-1, 2).T
        both, alike = np.stack([shares - 2.0 * sigmas, shares + 2.0 * sigmas], axis=1), (1.0, np.nan, np.nan)
        _interval_rows(right, [group.name for group in joints], shares, both, alike, "not determined")
        right.set_ylim(left.get_ylim())
        left.set_title("mass [kg]", fontsize=10)
        right.set_title("ratio to the others' payload", fontsize=10)
        return figure

    return [Drawing(name, caption, draw, f"{caption} {text}.")]


def methods_figure(result: PayloadResult) -> Drawing:
    """Mass and centre of mass by every method, with 95 % intervals, and the free estimates."""
    masses = ", ".join(f"method {each.method} {each.ten[9]:.4g} kg" for each in result.possible)
    caption = (
        "Filled: payload that can exist, with its 95 % interval. Open: least squares alone, which may be a body "
        f"that cannot exist. The dashed line and the band are the recommended payload (method {result.method})."
    )
    free = {each.method: each for each in result.free}

    def values(estimates: Iterable[FreeEstimate | PossibleEstimate]) -> Array:
        return np.array([[each.ten[9], *1e3 * array(each.com, 3)] for each in estimates])

    def draw() -> Figure:
        filled, opened = values(result.possible), values(free[each.method] for each in result.possible)
        intervals = (
            [bounds(each.interval95)[9], *1e3 * array(each.com_interval95, 3, 2)] for each in result.possible
        )
        ends = np.array(list(intervals))
        best = result.possible.index(result.best) if result.best is not None else None
        figure, (axes,) = panels((9.0, 0.42 * len(filled) + 1.35), 1, 4, sharey=True)
        names = [f"method {each.method}" for each in result.possible]
        titles = ("mass [kg]", *(f"centre of mass {axis} [mm]" for axis in "xyz"))
        for k, (axis, title) in enumerate(zip(axes, titles, strict=True)):
            agreed = [np.nan] * 3 if best is None else [filled[best, k], *ends[best, k]]
            _interval_rows(axis, names, filled[:, k], ends[:, k], agreed)
            look: dict[str, Any] = {"color": "black", "fillstyle": "none", "markersize": 5, "linestyle": "none"}
            axis.plot(opened[:, k], np.arange(len(opened)) + _FREE, "D", label="least squares alone", **look)
            axis.set_title(title, fontsize=10)
            axis.locator_params(axis="x", nbins=4)
        axes[0].plot([], [], "o-", color=BLUE, label="with constraints, 95 %")
        legend(figure, [axes[0]])
        return figure

    return Drawing("methods", caption, draw, f"{caption} Masses: {masses}.")


def seen(repeats: Repeats) -> tuple[list[int], Array, Array]:
    """Numbers (from 0), masses and standard deviations of the recordings that show the mass."""
    masses, sigmas = np.array(repeats.masses, dtype=float), np.array(repeats.sigmas, dtype=float)
    k = np.flatnonzero(np.isfinite(masses)).tolist()
    return k, masses[k], sigmas[k]


def repeats_figure(repeats: Repeats, mass: float, interval: tuple[float, float]) -> list[Drawing]:
    """Mass [kg] by each recording in the order they were given; none where fewer than two show it."""
    shown, masses, _ = seen(repeats)
    if len(shown) < 2:
        return []
    caption = (
        "The mass by each recording alone, in order, with two standard deviations; the dashed line and the band "
        "are the answer by all of them."
    )
    each = "; ".join(f"recording {k + 1} {m:.4g} kg" for k, m in zip(shown, masses, strict=True))

    def draw() -> Figure:
        names = [f"{k}: {source[-_NAME:]}" for k, source in enumerate(repeats.sources, 1)]
        figure, ((axis,),) = panels((7.0, 0.32 * len(names) + 1.0))
        values, sigmas = (np.array(x, dtype=float) for x in (repeats.masses, repeats.sigmas))
        ends = values[:, None] + NORMAL95 * sigmas[:, None] * [-1.0, 1.0]
        _interval_rows(axis, names, values, ends, (mass, *interval))
        axis.set_xlabel("mass [kg]")
        return figure

    return [Drawing("repeats", caption, draw, f"{caption} {each}.")]


def flange_figure(payload: PossibleEstimate, inertia: bool, flange: bool) -> Drawing:
    """Three views to one scale, the uncertainty enlarged; a body of its ``inertia``, a plate at the ``flange``."""
    com, ends = 1e3 * array(payload.com, 3), 1e3 * array(payload.com_interval95, 3, 2)
    origin = "the flange, drawn as a plate of 63 mm (ISO 9409-1-50)" if flange else "the frame's origin"
    caption = f"Centre of mass seen along y, along x and along z, from {origin}, to scale."
    body, known = None, bool(np.isfinite(ends).all())
    if known:
        caption += " Bars and ellipse: its 95 % intervals, enlarged below."
    if inertia:
        # Squared semi-axes of the homogeneous ellipsoid of the same inertia, as a matrix [mm^2].
        J = array(payload.inertia_com, 3, 3)
        body = 5e6 / payload.body.mass * (0.5 * np.trace(J) * np.eye(3) - J)
        caption += " Dashed: equivalent ellipsoid, homogeneous and of the identified mass and inertia."

    def draw() -> Figure:
        patches = matplotlib().patches
        points = [np.full(3, -1.25 * _PLATE), np.full(3, 1.25 * _PLATE), com - 12.0, com + 12.0]
        points += list(ends.T) if known else []
        if body is not None:
            reach = np.sqrt(np.maximum(np.diag(body), 0.0))
            points += [com - reach, com + reach]
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        middle, half = 0.5 * (low + high), 0.53 * float((high - low).max())
        figure, axes = panels((6.6, 4.7 if known else 2.6), 1 + known, 3)
        for column, (i, k) in zip(axes.T, _VIEWS.values(), strict=True):
            above = column[0]
            if flange:
                look: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "black", "hatch": "///"}
                side = patches.Rectangle((-_PLATE, -8.0), 2 * _PLATE, 8.0, **look)
                above.add_patch(side if k == 2 else patches.Circle((0.0, 0.0), _PLATE, **look))
            for tip, name in (((0.9 * _PLATE, 0.0), "xyz"[i]), ((0.0, 0.9 * _PLATE), "xyz"[k])):
                above.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2})
                above.annotate(name, tip, xytext=(3, 3), textcoords="offset points", fontsize=9)
            if body is not None:
                squares, directions = np.linalg.eigh(body[np.ix_((i, k), (i, k))])
                angle = np.linspace(0.0, 2.0 * np.pi, 91)
                circle = np.sqrt(np.maximum(squares, 0.0))[:, None] * np.vstack([np.cos(angle), np.sin(angle)])
                outline = com[[i, k], None] + directions @ circle
                above.plot(*outline, "--", color="0.35", linewidth=1.2, label="equivalent ellipsoid")
            for axis in column:
                if known:
                    centre, width = ends.mean(axis=1), np.ptp(ends, axis=1)
                    look = {"facecolor": "none", "edgecolor": BLUE, "linewidth": 1.2, "hatch": "xxx"}
                    axis.add_patch(patches.Ellipse((centre[i], centre[k]), width[i], width[k], **look))
                    axis.plot(ends[i], [com[k]] * 2, color=BLUE, linewidth=1.6, label="95 % intervals")
                    axis.plot([com[i]] * 2, ends[k], color=BLUE, linewidth=1.6)
                mark: dict[str, Any] = {"color": ORANGE, "markeredgecolor": "black", "markersize": 5}
                axis.plot(com[i], com[k], "o", label="centre of mass", **mark)
                axis.set_aspect("equal", adjustable="box" if axis is above else "datalim")
                axis.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[k]} [mm]")
                axis.tick_params(labelsize=8)
                axis.locator_params(nbins=5)
                axis.margins(0.12)
                plain(axis)
            above.set(xlim=(middle[i] - half, middle[i] + half), ylim=(middle[k] - half, middle[k] + half))
        legend(figure, [axes[0, 0]])
        return figure

    where = ", ".join(f"{axis} {x:.1f} mm" for axis, x in zip("xyz", com, strict=True))
    return Drawing("flange", caption, draw, f"{caption} Centre of mass at {where}.")


def save_drawing(path: str | Path, robot: Robot, q: Sequence[float], title: str) -> None:
    """Draw the arm at a pose [rad or m] from three sides with its joint axes [mm], as PNG, SVG or PDF."""
    figure, (axes,) = panels((15.0, 5.6), 1, 3)
    frames = frames_at(robot, q)
    bends = [np.zeros(3), frames[0].p]
    for before, frame, joint, position in zip(frames, frames[1:], robot.joints, q, strict=False):
        bends += [(before @ step(joint, position)[0]).p, frame.p]
    corners = 1e3 * np.array([*bends, frames[-1].p])
    size = max(float(np.ptp(corners, axis=0).max()), 1.0)
    for axis, (name, (a, b)) in zip(axes, _VIEWS.items(), strict=True):
        axis.plot(corners[:, a], corners[:, b], color="0.4", linewidth=3.0, solid_capstyle="round", zorder=1)
        for number, frame in enumerate(frames[1:-1], start=1):
            start, end = 1e3 * frame.p, 1e3 * frame.p + 0.12 * size * frame.R[:, 2]
            arrow = {"arrowstyle": "->", "color": "C0"}
            axis.annotate("", xy=(end[a], end[b]), xytext=(start[a], start[b]), arrowprops=arrow)
            axis.plot(start[a], start[b], "o", color="C0", markersize=5)
            beside = 0.03 * size * (1 + number % 3)
            axis.text(start[a] + beside, start[b] + 0.02 * size, str(number), color="C0")
        for direction, colour, letter in zip(frames[-1].R.T, ("C3", "C2", "C1"), "xyz", strict=True):
            start, end = 1e3 * frames[-1].p, 1e3 * frames[-1].p + 0.09 * size * direction
            axis.plot([start[a], end[a]], [start[b], end[b]], color=colour, linewidth=1.6)
            if np.hypot(direction[a], direction[b]) > 0.3:
                axis.text(end[a], end[b], letter, color=colour)
        axis.set_aspect("equal", adjustable="datalim")
        axis.margins(0.15)
        axis.grid(visible=True, alpha=0.3)
        axis.set(title=name, xlabel=f"{'xyz'[a]} of the base [mm]", ylabel=f"{'xyz'[b]} of the base [mm]")
    figure.suptitle(title)
    save_figure(figure, path, dpi=110)
