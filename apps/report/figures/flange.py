"""A sketch of the flange with the payload's centre of mass, its uncertainty to scale."""

import numpy as np

from ....common.arrays import Array
from ....estimation.payload.constrained import ConstrainedPayload
from ..blocks import Drawing
from .canvas import BLUE, ORANGE, Axes, Figure, legend, matplotlib, panels, plain

_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_ZOOM = 1.7  # inches: height of an enlargement


def flange_figure(payload: ConstrainedPayload, inertia: bool, flange: bool) -> Drawing:
    """Three views, x-z, y-z and x-y, equal in scale; beside and below them enlargements of the uncertainty.

    Args:
        payload: the recommended one.
        inertia: whether its inertia may be used: then a body of that inertia is drawn.
        flange: whether its frame is the flange: then a plate of 63 mm is drawn.
    """
    com, bounds = 1e3 * payload.body.com, 1e3 * payload.intervals.com
    body = _second_moments(payload) if inertia else None
    words = _words(com, inertia, flange, bool(np.isfinite(bounds).all()))
    return Drawing("flange", *words, lambda: _drawn(com, bounds, body, flange))


def _drawn(com: Array, bounds: Array, body: Array | None, flange: bool) -> Figure:
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


def _second_moments(payload: ConstrainedPayload) -> Array:
    """Squared semi-axes of the homogeneous ellipsoid of the same inertia, as a matrix [mm^2]."""
    J = payload.body.inertia_com
    return np.asarray(5.0 / payload.mass * (0.5 * np.trace(J) * np.eye(3) - J) * 1e6)


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
