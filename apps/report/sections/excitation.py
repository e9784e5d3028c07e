"""How well the motion excited each parameter."""

from collections.abc import Mapping

from ....estimation.fit.least_squares import Excitation
from ...numbers import percent
from ..blocks import Details, Section, Table, Text, columns
from ..figures.excitation import excitation_figure


def excitation_section(excitation: Excitation | None, labels: Mapping[str, str]) -> Section:
    """A figure, and the numbers to be opened."""
    title = "Excitation of each parameter"
    if excitation is None:
        words = (
            "The robot's parameters were read from a file, without the equations they come from: what its motion "
            "excited stands in the report of that identification."
        )
        return Section("excitation", title, [Text(words)])
    numbers = zip(excitation.names, excitation.signal, excitation.independent, excitation.share, strict=True)
    rows = [
        (
            labels.get(name, name),
            f"{signal:.3g}",
            f"{independent:.3g}",
            percent(float(share)),
            percent(1.0 / float(independent) if independent else float("inf")),
        )
        for name, signal, independent, share in numbers
    ]
    headings = columns(("",), ("torque over noise", "its own part", "share", "relative sigma"))
    words = (
        "A parameter is well known where its torque is large against the noise and no combination of others "
        "imitates it. Sigmas here are the formula's, for white noise; a small value of a parameter makes them "
        "large too."
    )
    table = Details("Numbers", [Table("Excitation", headings, rows)])
    return Section("excitation", title, [Text(words), excitation_figure(excitation, labels), table])
