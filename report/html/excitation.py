"""How well the motion excited each parameter."""

from collections.abc import Mapping

from ...estimation.payload import Excitation
from ..figures import excitation_figure
from ..numbers import percent
from .markup import paragraph, table, tag
from .page import Section


def excitation_section(found: Excitation | None, labels: Mapping[str, str]) -> Section:
    """A figure, and the numbers to be opened."""
    title = "Excitation of each parameter"
    if found is None:
        words = (
            "The robot's parameters were read from a file, without the equations they come from: what its motion "
            "excited stands in the report of that identification."
        )
        return Section("excitation", title, paragraph(words))
    rows = [
        (
            labels.get(name, name),
            f"{signal:.3g}",
            f"{own:.3g}",
            percent(float(share)),
            percent(1.0 / float(own) if own else float("inf")),
        )
        for name, signal, own, share in zip(found.names, found.signal, found.independent, found.share, strict=True)
    ]
    names = ("", "torque over noise", "its own part", "share", "relative sigma")
    words = (
        "A parameter is well known where its torque is large against the noise and no combination of others "
        "imitates it. Sigmas here are the formula's, for white noise; a small value of a parameter makes them "
        "large too."
    )
    numbers = tag("details", tag("summary", "Numbers"), table("Excitation", names, rows))
    return Section("excitation", title, paragraph(words), (excitation_figure(found, labels),), numbers)
