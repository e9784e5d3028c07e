"""Several recordings of one payload, each alone."""

from ....estimation.fit.robust import NORMAL95
from ....estimation.payload.repeats import Repeats
from ..blocks import Drawing
from .canvas import BLUE, Figure, mark_interval, panels, plain

_NAME = 24  # letters of a recording's name


def repeats_figure(repeats: Repeats, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by each recording in the order they were given; None where fewer than two show it.

    Args:
        repeats: the recordings.
        mass: by all of them [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    places, masses, _ = repeats.seen
    if len(places) < 2:
        return None
    caption = (
        "The mass by each recording alone, in order, with two standard deviations; the dashed line and the band "
        "are the answer by all of them."
    )
    each = "; ".join(f"recording {k + 1} {m:.4g} kg" for k, m in zip(places, masses, strict=True))
    return Drawing("repeats", caption, f"{caption} {each}.", lambda: _drawn(repeats, mass, interval))


def _drawn(repeats: Repeats, mass: float, interval: tuple[float, float]) -> Figure:
    places, masses, sigmas = repeats.seen
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
