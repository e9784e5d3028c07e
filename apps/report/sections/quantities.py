"""Mass, centre of mass and inertia, the quantities that a controller asks for."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...numbers import with_interval
from ..blocks import Column, Table

_ENTRIES = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
"""Places of the six entries in the matrix, moments first."""
Numbers = tuple[ArrayLike, ArrayLike]
"""Values, and a 95 % interval of each; nan where there is none."""


def quantities_table(
    frame: str,
    remark: str,
    mass: Numbers,
    com: Numbers,
    inertia: Numbers,
    uses: Sequence[str],
) -> Table:
    """Values with 95 % intervals, and what to do with each.

    Args:
        frame: they are given in.
        remark: behind it.
        mass: [kg].
        com: centre of mass x, y, z [m].
        inertia: at the centre of mass [kg m^2], 3 x 3.
        uses: of mass, centre of mass and inertia.
    """
    millimetres = 1e3 * np.asarray(com[0]), 1e3 * np.asarray(com[1])
    six_entries = tuple(np.asarray(part, dtype=float)[_ENTRIES] for part in inertia)
    groups = (
        (("mass",), mass, "kg"),
        (("centre of mass x", "y", "z"), millimetres, "mm"),
        (("inertia XX", "YY", "ZZ", "XY", "XZ", "YZ"), six_entries, "kg m²"),
    )
    rows = []
    for (names, (values, intervals), unit), use in zip(groups, uses, strict=True):
        for name, value, (low, high) in zip(names, np.atleast_1d(values), np.atleast_2d(intervals), strict=True):
            rows.append(
                (name, *_texts(float(value), float(low), float(high), unit), use if name == names[0] else "")
            )
    headings = (Column(""), Column("value", numeric=True), Column("95 % interval", numeric=True), Column(""))
    title = f"In {frame}; inertia at the centre of mass{remark}"
    return Table(title, headings, rows, ("mass", "z"), "quantities")


def _texts(value: float, low: float, high: float, unit: str) -> tuple[str, str]:
    if not np.isfinite(value):
        return "-", "-"
    text, interval = with_interval(value, low, high)
    return f"{text} {unit}", interval
