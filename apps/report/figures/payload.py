"""Figures of a payload: by each joint, by each method, by each recording, and where it hangs at the flange."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....estimation.fit.covariance import NORMAL95
from ....estimation.payload.by_joints import JointsMass
from ....estimation.payload.repeats import Repeats
from ....estimation.results.payload import FreeEstimate, PayloadResult, PossibleEstimate, array, bounds
from ..blocks import Drawing
from .canvas import BLUE, ORANGE, Axes, Figure, legend, matplotlib, panels, plain

_FREE = 0.22  # the free estimate stands this much below the constrained one
_NAME = 24  # letters of a recording's name
_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_VIEWS = ((0, 2), (1, 2), (0, 1))


def _interval_rows(
    axis: Axes, names: Sequence[str], values: Array, ends: Array, agreed: Array, missing: str = "", marks: str = ""
) -> None:
    """A row a name: its value and interval (N, 2), or a word; ``agreed``: value, low and high of all together."""
    middle, low, high = agreed.tolist()
    if np.isfinite([low, high]).all():
        axis.axvspan(low, high, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    if np.isfinite(middle):
        axis.axvline(middle, color="black", linestyle="--", linewidth=1.0)
    for row, (value, interval) in enumerate(zip(values, ends, strict=True)):
        if np.isfinite(value):
            axis.plot(interval, [row, row], color=BLUE, linewidth=2.0)
            axis.plot(value, row, marks[row : row + 1] or "o", color=BLUE, markersize=6)
        elif missing:
            look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 9, "style": "italic"}
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            axis.text(middle, row, missing, bbox=box, **look)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)
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
        size, edges = (9.0, 0.32 * len(masses) + 1.2), (0.85, 0.1, 0.3, 0.3)
        figure, ((left, right),) = panels(size, 1, 2, edges, (0.85, 0.0), width_ratios=(3, 2))
        ends = np.array([array(group.interval95, 2) for group in masses])
        marks = "".join("s" if len(group.joints) > 1 else "o" for group in masses)
        names = [group.name for group in masses]
        _interval_rows(left, names, values, ends, np.array([mass, *interval]), "not visible", marks)
        reaches = np.abs(ends - mass).max(axis=1)
        reaches = reaches[np.isfinite(reaches)]
        # One joint that hardly sees the mass must not squeeze the others to a line.
        reach = 1.1 * min(float(reaches.max()), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
        left.set_xlim(mass - reach, mass + reach)
        joints = [group for group in masses if len(group.joints) == 1]
        pairs = [[array(group.share), array(group.share_sigma)] for group in joints]
        shares, sigmas = np.array(pairs, dtype=float).reshape(-1, 2).T
        both = np.stack([shares - 2.0 * sigmas, shares + 2.0 * sigmas], axis=1)
        alike = np.array([1.0, np.nan, np.nan])
        _interval_rows(right, [group.name for group in joints], shares, both, alike, "not determined")
        right.set_ylim(left.get_ylim())
        for axis, title in ((left, "mass [kg]"), (right, "ratio to the others' payload")):
            axis.set_title(title, fontsize=10)
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
        size, edges = (9.0, 0.42 * len(filled) + 1.35), (0.85, 0.1, 0.3, 0.6)
        figure, (axes,) = panels(size, 1, 4, edges, (0.25, 0.0), sharey=True)
        names = [f"method {each.method}" for each in result.possible]
        titles = ("mass [kg]", *(f"centre of mass {axis} [mm]" for axis in "xyz"))
        for k, (axis, title) in enumerate(zip(axes, titles, strict=True)):
            agreed = np.full(3, np.nan) if best is None else np.array([filled[best, k], *ends[best, k]])
            _interval_rows(axis, names, filled[:, k], ends[:, k], agreed)
            look: dict[str, Any] = {"color": "black", "fillstyle": "none", "markersize": 5, "linestyle": "none"}
            axis.plot(opened[:, k], np.arange(len(opened)) + _FREE, "D", label="least squares alone", **look)
            axis.set_title(title, fontsize=10)
            axis.locator_params(axis="x", nbins=4)
        axes[0].plot([], [], "o-", color=BLUE, label="with constraints, 95 %")
        axes[0].set_ylim(len(filled) - 0.4, -0.6)
        legend(figure, [axes[0]], "lower center")
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
        edges = (0.25 + 0.085 * max(map(len, names)), 0.1, 0.1, 0.5)
        figure, ((axis,),) = panels((7.0, 0.32 * len(names) + 1.0), edges=edges)
        values, half = (np.array(x, dtype=float) for x in (repeats.masses, repeats.sigmas))
        half *= NORMAL95
        ends = np.stack([values - half, values + half], axis=1)
        _interval_rows(axis, names, values, ends, np.array([mass, *interval]))
        axis.set_xlabel("mass [kg]")
        return figure

    return [Drawing("repeats", caption, draw, f"{caption} {each}.")]


def flange_figure(payload: PossibleEstimate, inertia: bool, flange: bool) -> Drawing:
    """Three views, x-z, y-z and x-y, equal in scale; below them enlargements of the uncertainty.

    A body of the payload's ``inertia`` is drawn where that may be used, a plate of 63 mm where its frame is the
    ``flange``.
    """
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
        size, edges = (6.6, 4.7 if known else 2.6), (0.65, 0.1, 0.1, 0.75)
        figure, axes = panels(size, 1 + known, 3, edges, (0.72, 0.55))
        for column, (i, k) in enumerate(_VIEWS):
            above = axes[0, column]
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
            for axis in axes[:, column]:
                if known:
                    centre, width = ends.mean(axis=1), np.ptp(ends, axis=1)
                    look = {"facecolor": "none", "edgecolor": BLUE, "linewidth": 1.2, "hatch": "xxx"}
                    axis.add_patch(patches.Ellipse((centre[i], centre[k]), width[i], width[k], **look))
                    axis.plot(ends[i], [com[k]] * 2, color=BLUE, linewidth=1.6, label="95 % intervals")
                    axis.plot([com[i]] * 2, ends[k], color=BLUE, linewidth=1.6)
                mark: dict[str, Any] = {"color": ORANGE, "markeredgecolor": "black", "markersize": 5}
                axis.plot(com[i], com[k], "o", label="centre of mass", **mark)
                axis.set_aspect("equal", adjustable="box" if axis is above else "datalim")
                axis.set_xlabel(f"{'xyz'[i]} [mm]", labelpad=1.0)
                axis.set_ylabel(f"{'xyz'[k]} [mm]", labelpad=1.0)
                axis.tick_params(labelsize=8)
                axis.locator_params(nbins=5)
                plain(axis)
            above.set(xlim=(middle[i] - half, middle[i] + half), ylim=(middle[k] - half, middle[k] + half))
            if known:
                axes[1, column].margins(0.12)
        legend(figure, [axes[0, 0]], "lower center", fontsize=9)
        return figure

    where = ", ".join(f"{axis} {x:.1f} mm" for axis, x in zip("xyz", com, strict=True))
    return Drawing("flange", caption, draw, f"{caption} Centre of mass at {where}.")
