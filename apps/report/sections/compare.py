"""Recordings of one robot side by side."""

from pathlib import PurePath

import numpy as np

from ...fleet.comparing import CHANCE, Compared
from ..blocks import Block, Remarks, Screen, Table, columns

_SHOWN = 10
"""Parameters on the first screen."""
_LINES = 12
"""Recordings that have a column of their own."""


def compared_screen(compared: Compared) -> Screen:
    """The parameters in which recordings differ most; then all of them."""
    order = np.argsort(-compared.scatter, kind="stable")
    details: list[Block] = [_table(compared, "All parameters", range(len(compared.parameters)))]
    first: list[Block] = [
        _table(compared, "Where the recordings differ most (SI units)", sorted(order[:_SHOWN].tolist())),
        Remarks(odd_lines(compared)),
    ]
    return Screen(first, details, "all parameters")


def odd_lines(compared: Compared) -> list[str]:
    """Which recording is the odd one, and in what."""
    odd = compared.odd
    if not odd:
        return [f"No recording differs from the others beyond {compared.bound:.1f} sigma (chance {CHANCE:g})."]
    return [
        f"{PurePath(one.recording).name} is the odd one in {one.parameter}: {one.sigmas:+.1f} sigma from the "
        "others."
        for one in odd
    ]


def _table(compared: Compared, title: str, chosen: "range | list[int]") -> Table:
    shown = compared.recordings if len(compared.recordings) <= _LINES else ()
    labels = [_short(source) for source in shown]
    rows = []
    for k in chosen:
        low, high = compared.pooled_interval95[k]
        own = float(np.sqrt(np.mean(compared.sigma[:, k] ** 2)))
        spread = float(np.std(compared.values[:, k], ddof=1))
        values = [f"{compared.values[i, k]:.4g}" for i in range(len(shown))]
        rows.append(
            (compared.parameters[k], *values, f"{spread:.2g}", f"{own:.2g}", f"{compared.pooled[k]:.4g}",
             f"{low:.4g}", f"{high:.4g}")
        )  # fmt: skip
    headings = [*labels, "spread", "own sigma", "pooled", "95 % from", "to"]
    return Table(title, columns(("parameter",), headings), rows, style="tight")


def _short(source: str) -> str:
    return PurePath(source.split(", ")[0]).name.split(".")[0][-12:]
