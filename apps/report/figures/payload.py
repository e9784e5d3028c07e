"""Figures of a payload: by each joint, by each method, by each recording, and where it hangs at the flange."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.fit.covariance import NORMAL95
from ....estimation.payload.repeats import Repeats
from ....estimation.results.payload import (
    FreeEstimate,
    JointsMassDocument,
    PayloadResult,
    PossibleEstimate,
    array,
    bounds,
)
from ..blocks import Drawing
from .canvas import BLUE, ORANGE, Axes, Figure, legend, mark_interval, matplotlib, panels, plain

_FREE = 0.22  # the free estimate stands this much below the constrained one
_NAME = 24  # letters of a recording's name
_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_ZOOM = 1.7  # inches: height of an enlargement


def joints_figure(
    masses: Sequence[JointsMassDocument], mass: float, interval: tuple[float, float], name: str = "by_joints"
) -> Drawing | None:
    """Mass by groups of joints, and the share of the payload that each joint shows; None where no joint sees it.

    Args:
        masses: by some joints.
        mass: recommended [kg].
        interval: its 95 % interval [kg]; nan where there is none.
        name: of the drawing.
    """
    if all(group.mass is None for group in masses):
        return None
    text = "; ".join(
        f"{group.name} {group.mass:.4g} kg" if group.mass is not None else f"{group.name} does not see it"
        for group in masses
    )
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there, with two standard deviations; 1 where drive gain and friction are right."
    )
    return Drawing(name, caption, f"{caption} {text}.", lambda: _draw_joints(masses, mass, interval))


def _draw_joints(masses: Sequence[JointsMassDocument], mass: float, interval: tuple[float, float]) -> Figure:
    size, edges = (9.0, 0.32 * len(masses) + 1.2), (0.85, 0.1, 0.3, 0.3)
    figure, ((left, right),) = panels(size, 1, 2, edges, (0.85, 0.0), width_ratios=(3, 2))
    mark_interval(left, *interval)
    _masses(left, masses, mass)
    _shares(right, [group for group in masses if len(group.joints) == 1])
    for axis in (left, right):
        axis.set_ylim(len(masses) - 0.5, -0.5)
        plain(axis)
    return figure


def _masses(axis: Axes, masses: Sequence[JointsMassDocument], mass: float) -> None:
    axis.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    reaches = []
    for row, group in enumerate(masses):
        if group.mass is None or group.interval95 is None:
            _label(axis, "not visible", mass, row)
            continue
        interval = array(group.interval95, 2)
        axis.plot(interval, [row, row], color=BLUE, linewidth=2.0)
        axis.plot(group.mass, row, "s" if len(group.joints) > 1 else "o", color=BLUE, markersize=6)
        reaches.append(float(np.abs(interval - mass).max()))
    # One joint that hardly sees the mass must not squeeze the others to a line.
    reach = min(max(reaches), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
    axis.set_xlim(mass - 1.1 * reach, mass + 1.1 * reach)
    axis.set_yticks(range(len(masses)), [group.name for group in masses])
    axis.set_title("mass [kg]", fontsize=10)


def _shares(axis: Axes, joints: Sequence[JointsMassDocument]) -> None:
    axis.axvline(1.0, color="black", linestyle="--", linewidth=1.0)
    for row, entry in enumerate(joints):
        share = present(entry.share)
        if share is None:
            _label(axis, "not determined", 1.0, row)
            continue
        half = 2.0 * float(array(entry.share_sigma))
        axis.plot([share - half, share + half], [row, row], color=BLUE, linewidth=2.0)
        axis.plot(share, row, "o", color=BLUE, markersize=6)
    axis.set_yticks(range(len(joints)), [entry.name for entry in joints])
    axis.set_title("share of the others' payload", fontsize=10)


def _label(axis: Axes, text: str, x: float, y: float) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axis.text(x, y, text, ha="center", va="center", fontsize=9, style="italic", bbox=box)


def methods_figure(result: PayloadResult) -> Drawing:
    """Mass and centre of mass by every method, with 95 % intervals, and the free estimates."""
    masses = ", ".join(f"method {each.method} {_places(each)[0]:.4g} kg" for each in result.possible)
    caption = (
        "Filled: payload that can exist, with its 95 % interval. Open: least squares alone, which may be a body "
        f"that cannot exist. The band is the recommended interval (method {result.method})."
    )
    return Drawing("methods", caption, f"{caption} Masses: {masses}.", lambda: _draw_methods(result))


def _draw_methods(result: PayloadResult) -> Figure:
    count = len(result.possible)
    size, edges = (9.0, 0.42 * count + 1.35), (0.85, 0.1, 0.3, 0.6)
    figure, (axes,) = panels(size, 1, 4, edges, (0.25, 0.0), sharey=True)
    scales = (1.0, 1e3, 1e3, 1e3)
    titles = ("mass [kg]", "centre of mass x [mm]", "centre of mass y [mm]", "centre of mass z [mm]")
    for k, (axis, title, scale) in enumerate(zip(axes, titles, scales, strict=True)):
        _panel(axis, result, k, scale)
        axis.set_title(title, fontsize=10)
    axes[0].set_yticks(range(count), [f"method {each.method}" for each in result.possible])
    axes[0].set_ylim(count - 0.4, -0.6)
    legend(figure, [axes[0]], "lower center")
    return figure


def _panel(axis: Axes, result: PayloadResult, k: int, scale: float) -> None:
    if result.best is not None:
        mark_interval(axis, *(scale * _intervals(result.best)[k]))
    for row, estimate in enumerate(result.possible):
        low, high = scale * _intervals(estimate)[k]
        filled, open_ = ("with constraints, 95 %", "least squares alone") if row == 0 else (None, None)
        if np.isfinite([low, high]).all():
            axis.plot([low, high], [row, row], color=BLUE, linewidth=2.0)
        axis.plot(scale * _places(estimate)[k], row, "o", color=BLUE, markersize=6, label=filled)
        free = next(each for each in result.free if each.method == estimate.method)
        axis.plot(
            scale * _places(free)[k], row + _FREE, "D", color="black", fillstyle="none", markersize=5, label=open_
        )
    plain(axis)
    axis.locator_params(axis="x", nbins=4)


def _places(estimate: FreeEstimate | PossibleEstimate) -> Array:
    """Mass and centre of mass, shape (4,)."""
    return np.append(estimate.ten[9], array(estimate.com, 3))


def _intervals(estimate: PossibleEstimate) -> Array:
    return np.vstack([bounds(estimate.interval95)[9:], array(estimate.com_interval95, 3, 2)])


def seen(repeats: Repeats) -> tuple[list[int], Array, Array]:
    """Numbers (from 0), masses and standard deviations of the recordings that show the mass."""
    masses, sigmas = np.array(repeats.masses, dtype=float), np.array(repeats.sigmas, dtype=float)
    k = np.flatnonzero(np.isfinite(masses)).tolist()
    return k, masses[k], sigmas[k]


def repeats_figure(repeats: Repeats, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by each recording in the order they were given; None where fewer than two show it.

    Args:
        repeats: the recordings.
        mass: by all of them [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    places, masses, _ = seen(repeats)
    if len(places) < 2:
        return None
    caption = (
        "The mass by each recording alone, in order, with two standard deviations; the dashed line and the band "
        "are the answer by all of them."
    )
    each = "; ".join(f"recording {k + 1} {m:.4g} kg" for k, m in zip(places, masses, strict=True))
    return Drawing("repeats", caption, f"{caption} {each}.", lambda: _draw_repeats(repeats, mass, interval))


def _draw_repeats(repeats: Repeats, mass: float, interval: tuple[float, float]) -> Figure:
    places, masses, sigmas = seen(repeats)
    names = [f"{k}: {source[-_NAME:]}" for k, source in enumerate(repeats.sources, 1)]
    edges = (0.25 + 0.085 * max(map(len, names)), 0.1, 0.1, 0.5)
    figure, ((axis,),) = panels((7.0, 0.32 * len(names) + 1.0), edges=edges)
    mark_interval(axis, *interval)
    axis.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    half = NORMAL95 * sigmas
    axis.errorbar(masses, places, xerr=half, fmt="o", color=BLUE, linewidth=2.0, markersize=6)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)
    axis.set_xlabel("mass [kg]")
    plain(axis)
    return figure


def flange_figure(payload: PossibleEstimate, inertia: bool, flange: bool) -> Drawing:
    """Three views, x-z, y-z and x-y, equal in scale; beside and below them enlargements of the uncertainty.

    Args:
        payload: the recommended one.
        inertia: whether its inertia may be used: then a body of that inertia is drawn.
        flange: whether its frame is the flange: then a plate of 63 mm is drawn.
    """
    com, ends = 1e3 * array(payload.com, 3), 1e3 * array(payload.com_interval95, 3, 2)
    body = _second_moments(payload) if inertia else None
    words = _words(com, inertia, flange, bool(np.isfinite(ends).all()))
    return Drawing("flange", *words, lambda: _draw_flange(com, ends, body, flange))


def _draw_flange(com: Array, bounds: Array, body: Array | None, flange: bool) -> Figure:
    """From the side and the front, below them from above; at the right of that and below, the enlargements."""
    known = bool(np.isfinite(bounds).all())
    low, high = _extent(com, bounds, body)
    width, height, depth = high - low
    per_mm = min(4.6 / (width + height), 3.0 / depth)
    rows = [depth * per_mm, height * per_mm, *([_ZOOM] if known else [])]
    size = max((width + height) * per_mm + 1.4, 4.6), sum(rows) + 0.9 + 0.6 * (len(rows) - 1)
    figure, axes = panels(
        size, len(rows), 2, (0.75, 0.15, 0.1, 0.8), (0.65, 0.6), width_ratios=(width, height), height_ratios=rows
    )
    views = {(0, 2): (axes[0][0], axes[-1][0]), (1, 2): (axes[0][1], axes[-1][1]), (0, 1): (axes[1][0], axes[1][1])}
    for (i, k), (view, enlarged) in views.items():
        _overview(view, com, bounds, body, (i, k), flange)
        view.set_xlim(low[i], high[i])
        view.set_ylim(low[k], high[k])
        if known:
            _enlarged(enlarged, com, bounds, (i, k))
        for axis in (view, enlarged) if known else (view,):
            axis.set_xlabel(f"{'xyz'[i]} [mm]", labelpad=1.0)
            axis.set_ylabel(f"{'xyz'[k]} [mm]", labelpad=1.0)
    if not known:
        axes[1][1].set_visible(False)
    legend(figure, [axes[0][0]], "lower center", fontsize=9)
    return figure


def _words(com: Array, inertia: bool, flange: bool, known: bool) -> tuple[str, str]:
    where = ", ".join(f"{'xyz'[k]} {com[k]:.1f} mm" for k in range(3))
    origin = "the flange, drawn as a plate of 63 mm (ISO 9409-1-50)" if flange else "the frame's origin"
    caption = f"Centre of mass seen along y (left), along x (right) and along z (below), from {origin}, to scale."
    if known:
        caption += " Bars and ellipse: its 95 % intervals, also as enlargements."
    if inertia:
        caption += " Dashed: equivalent ellipsoid, homogeneous and of the identified mass and inertia."
    return caption, f"{caption} Centre of mass at {where}."


def _overview(
    axis: Axes, com: Array, bounds: Array, body: Array | None, axes: tuple[int, int], flange: bool
) -> None:
    i, k = axes
    if flange:
        look = {"facecolor": "0.85", "edgecolor": "black", "hatch": "///"}
        patches = matplotlib().patches
        side = k == 2
        plate = (
            patches.Rectangle((-_PLATE, -8.0), 2 * _PLATE, 8.0, **look)
            if side
            else patches.Circle((0.0, 0.0), _PLATE, **look)
        )
        axis.add_patch(plate)
    for direction, name in (((1.0, 0.0), "xyz"[i]), ((0.0, 1.0), "xyz"[k])):
        tip = (0.9 * _PLATE * direction[0], 0.9 * _PLATE * direction[1])
        axis.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2})
        axis.annotate(name, tip, xytext=(3, 3), textcoords="offset points", fontsize=9)
    if body is not None:
        axis.plot(*_outline(com[[i, k]], body[np.ix_([i, k], [i, k])]), "--", color="0.35", linewidth=1.2,
                  label="equivalent ellipsoid")  # fmt: skip
    _uncertain(axis, com, bounds, axes)
    axis.set_aspect("equal")
    axis.locator_params(nbins=6)
    plain(axis)


def _enlarged(axis: Axes, com: Array, bounds: Array, axes: tuple[int, int]) -> None:
    """The uncertainty alone."""
    _uncertain(axis, com, bounds, axes)
    axis.margins(0.12)
    axis.set_aspect("equal", adjustable="datalim")
    axis.locator_params(nbins=5)
    axis.set_title("enlargement", fontsize=9)
    plain(axis)


def _uncertain(axis: Axes, com: Array, bounds: Array, axes: tuple[int, int]) -> None:
    """Centre of mass, its intervals as bars and an ellipse."""
    i, k = axes
    if np.isfinite(bounds).all():
        centre, width = bounds.mean(axis=1), np.ptp(bounds, axis=1)
        ellipse = matplotlib().patches.Ellipse(
            (centre[i], centre[k]), width[i], width[k], facecolor="none", edgecolor=BLUE, linewidth=1.2
        )
        ellipse.set_hatch("xxx")
        axis.add_patch(ellipse)
        axis.plot(bounds[i], [com[k]] * 2, color=BLUE, linewidth=1.6, label="95 % intervals")
        axis.plot([com[i]] * 2, bounds[k], color=BLUE, linewidth=1.6)
    axis.plot(com[i], com[k], "o", color=ORANGE, markeredgecolor="black", markersize=5, label="centre of mass")


def _second_moments(payload: PossibleEstimate) -> Array:
    """Squared semi-axes of the homogeneous ellipsoid of the same inertia, as a matrix [mm^2]."""
    J, mass = array(payload.inertia_com, 3, 3), payload.body.mass
    return np.asarray(5.0 / mass * (0.5 * np.trace(J) * np.eye(3) - J) * 1e6)


def _outline(centre: Array, Q: Array) -> Array:
    """Points of the ellipse x' Q^-1 x = 1, 2 x N."""
    values, vectors = np.linalg.eigh(Q)
    angle = np.linspace(0.0, 2.0 * np.pi, 91)
    circle = np.vstack([np.cos(angle), np.sin(angle)])
    return np.asarray(centre[:, None] + vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * circle))


def _extent(com: Array, bounds: Array, body: Array | None) -> tuple[Array, Array]:
    """Corners of what must be seen [mm], shapes (3,)."""
    points = [np.full(3, -1.25 * _PLATE), np.full(3, 1.25 * _PLATE), com - 12.0, com + 12.0]
    points += list(bounds.T) if np.isfinite(bounds).all() else []
    if body is not None:
        reach = np.sqrt(np.maximum(np.diag(body), 0.0))
        points += [com - 1.05 * reach, com + 1.05 * reach]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    longest = float((high - low).max())
    # No view much narrower than the longest side.
    lack = np.maximum(0.0, 0.7 * longest - (high - low))
    return low - lack / 2, high + lack / 2
