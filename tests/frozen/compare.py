"""Compares a run with the frozen one, and says where they differ."""

import math
import re
from typing import NamedTuple

from dynident.tests.frozen.documents import SCORE, Leaves, changes
from dynident.tests.frozen.freeze import Frozen
from dynident.tests.frozen.runs import Run
from dynident.tests.frozen.texts import MARK, Text, same_printed

WORSE = 0.03
"""The motion a search finds may be worse than the frozen one by this."""
_ROWS = 20
_PARAMETER = re.compile(r"\b[A-Z]{1,3}[0-9]+R?\b")
_SEARCH_SETTINGS = (
    "robot",
    "criterion",
    "limits/met",
    "limits/max_violation",
    "seed",
    "interrupted",
    "visibility/rank",
)
"""Of a design: the same whatever motion is found."""
_LOGARITHM = "criterion_value"
_SIGMAS = ("predicted_sigma/mass", "predicted_sigma/com/", "predicted_sigma/inertia_com/")


class Row(NamedTuple):
    """One difference."""

    file: str
    place: str
    """JSON path or line."""
    old: object
    new: object
    allowed: str


def differences(run: Run, old: Frozen, new: Frozen) -> list[Row]:
    """All that differs by more than it may."""
    rows = [Row("", "exit status", old.status, new.status, "exact")] if old.status != new.status else []
    for name in [*old.texts, *(name for name in new.texts if name not in old.texts)]:
        was, now = (frozen.texts.get(name, Text(["(no such text)"], [])) for frozen in (old, new))
        rows += _searched_words(name, was, now) if run.search else _text(name, was, now)
    for name in [*old.documents, *(name for name in new.documents if name not in old.documents)]:
        before, after = old.documents.get(name, {}), new.documents.get(name, {})
        if run.search:
            rows += _searched(name, before, after)
        else:
            run_changes = changes(before, after, SCORE) if run.score else changes(before, after)
            rows += [Row(name, *change) for change in run_changes]
    return rows


def told(run: Run, rows: list[Row]) -> str:
    """The first differences, for who has just moved something."""
    lines = [f"{run.name}: {len(rows)} differences from what is frozen: dynident {run.line}"]
    lines += [
        f"  {row.file or 'run'} {row.place}: {row.old!r} -> {row.new!r} ({row.allowed})" for row in rows[:_ROWS]
    ]
    lines += [f"  and {len(rows) - _ROWS} more"] if len(rows) > _ROWS else []
    return "\n".join([*lines, f"If meant: python -m dynident.tests.frozen.freeze {run.name}"])


def _text(name: str, old: Text, new: Text) -> list[Row]:
    if old.words != new.words:
        return _words(name, old.words, new.words)
    rows = []
    lines = [i for i, line in enumerate(old.words, 1) for _ in range(line.count(MARK))]
    for i, (was, now) in enumerate(zip(old.numbers, new.numbers, strict=False)):
        if not same_printed(was, now):
            line = lines[i] if len(lines) == len(old.numbers) else 0
            words = f": {old.words[line - 1][:60]}" if line else ""
            rows.append(Row(name, f"number {i + 1}, line {line}{words}", was, now, "last digit"))
    if len(old.numbers) != len(new.numbers):
        rows.append(Row(name, "count of numbers", len(old.numbers), len(new.numbers), "exact"))
    return rows


def _words(name: str, old: list[str], new: list[str]) -> list[Row]:
    import difflib

    rows = []
    for tag, a, b, c, d in difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag != "equal":
            rows.append(Row(name, f"line {a + 1}", "\n".join(old[a:b]), "\n".join(new[c:d]), "exact words"))
    return rows


def _searched_words(name: str, old: Text, new: Text) -> list[Row]:
    """Words alone: numbers and the parameters least known go with the motion found."""
    was, now = ([_PARAMETER.sub("(parameter)", line) for line in text.words] for text in (old, new))
    return _words(name, was, now) if " ".join(was).split() != " ".join(now).split() else []


def _searched(name: str, old: Leaves, new: Leaves) -> list[Row]:
    """Compare a design: the same keys, settings that hold, and a score that is hardly worse."""
    rows = [Row(name, path, "(there)", "(gone)", "exact") for path in old if path not in new]
    rows += [Row(name, path, "(not there)", new[path], "exact") for path in new if path not in old]
    for path in _SEARCH_SETTINGS:
        if old.get(path) != new.get(path):
            rows.append(Row(name, path, old.get(path), new.get(path), "exact"))
    if not rows and worse(old, new) > WORSE:
        rows.append(Row(name, "score", "1", f"{1 + worse(old, new):.4f}", f"at most {1 + WORSE}"))
    return rows


def worse(old: Leaves, new: Leaves) -> float:
    """Share by which a design is worse: its criterion, or the mean sigma near a pose."""
    if _LOGARITHM in old:
        return math.expm1(float(new[_LOGARITHM] or 0.0) - float(old[_LOGARITHM] or 0.0))
    paths = [path for path in old if path.startswith(_SIGMAS)]
    if not paths:
        raise ValueError("a design without a score")
    return sum(float(new[path] or 0.0) / float(old[path] or 1.0) for path in paths) / len(paths) - 1.0
