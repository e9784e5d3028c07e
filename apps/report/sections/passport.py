"""What a passport holds, and recordings of one thing side by side."""

from pathlib import PurePath

import numpy as np

from ....estimation import Identification, PayloadAnswer
from ...fleet import Passport
from ...fleet.answers import numbers_of
from ...fleet.comparing import CHANCE, Compared
from ..blocks import Banner, Block, Notes, Remarks, Screen, Table, columns

_SHOWN = 10
"""Parameters on the first screen."""
_LINES = 12
"""Recordings that have a column of their own."""


def passport_screen(passport: Passport, answer: Identification | PayloadAnswer) -> Screen:
    """The answer by the passport alone; then all parameters, logs and versions."""
    numbers, verdict = numbers_of(answer), answer.verdict
    rows = [(number.name, f"{number.value:.5g}", f"{number.low:.5g}", f"{number.high:.5g}") for number in numbers]
    headings = columns(("parameter",), ("value", "95 % from", "to"))
    width = [(number.high - number.low) / max(abs(number.value), 1e-300) for number in numbers]
    order = np.argsort(width, kind="stable")[:_SHOWN]
    title = f"The {len(order)} surest of {len(rows)} parameters (SI units)"
    about = [f"{key}: {value}" for key, value in passport.about.items()]
    whose = f"{passport.robot.title or passport.robot.name}, robot {passport.robot_fingerprint}"
    lines = [
        f"{answer.headline}.",
        f"{whose}; made by '{passport.recipe.kind}', recipe {passport.recipe.fingerprint}.",
        *about,
    ]
    first: list[Block] = [
        Notes(lines),
        Table(title, headings, [rows[k] for k in sorted(order.tolist())], style="tight"),
        Banner(verdict.level, "; ".join(verdict.reasons)),
    ]
    logs = [(log.role, PurePath(log.name).name, log.sha256) for log in passport.logs]
    details: list[Block] = [
        Table("All parameters", headings, rows, style="tight"),
        Table("Logs", columns(("read as", "file", "SHA-256")), logs, style="tight"),
        Notes([f"{name} {version}" for name, version in passport.versions.items()]),
    ]
    return Screen(first, details, "all parameters, logs with checksums, versions")


def compared_screen(compared: Compared) -> Screen:
    """The parameters in which recordings differ most; then all of them."""
    order = np.argsort(-compared.scatter, kind="stable")
    details: list[Block] = [_table(compared, "All parameters", range(len(compared.names)))]
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
        f"{PurePath(source).name} is the odd one in {name}: {sigmas:+.1f} sigma from the others."
        for source, name, sigmas in odd
    ]


def _table(compared: Compared, title: str, chosen: "range | list[int]") -> Table:
    shown = compared.sources if len(compared.sources) <= _LINES else ()
    labels = [_short(source) for source in shown]
    rows = []
    for k in chosen:
        low, high = compared.interval95[k]
        own = float(np.sqrt(np.mean(compared.sigma[:, k] ** 2)))
        spread = float(np.std(compared.values[:, k], ddof=1))
        values = [f"{compared.values[i, k]:.4g}" for i in range(len(shown))]
        rows.append(
            (compared.names[k], *values, f"{spread:.2g}", f"{own:.2g}", f"{compared.pooled[k]:.4g}", f"{low:.4g}",
             f"{high:.4g}")
        )  # fmt: skip
    headings = [*labels, "spread", "own sigma", "pooled", "95 % from", "to"]
    return Table(title, columns(("parameter",), headings), rows, style="tight")


def _short(source: str) -> str:
    return PurePath(source.split(", ")[0]).name.split(".")[0][-12:]
