"""Recordings with one mistake each, as a table by what is wrong."""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Draw = np.random.Generator


class Log(NamedTuple):
    """A recording as text columns."""

    names: list[str]
    rows: Array

    def where(self, *kinds: str) -> list[int]:
        """Columns of some kinds: "q", "tau"."""
        return [k for k, name in enumerate(self.names) if re.fullmatch(f"({'|'.join(kinds)})\\d+", name)]

    def text(self) -> bytes:
        """The recording as CSV."""
        lines = (",".join(f"{x:.9g}" for x in row) for row in self.rows.tolist())
        return ("\n".join([",".join(self.names), *lines]) + "\n").encode()


def read_log(content: bytes) -> Log:
    """A good recording."""
    head, *lines = content.decode().splitlines()
    return Log(head.split(","), np.array([[float(cell) for cell in line.split(",")] for line in lines]))


def _scaled(kind: str, low: float, high: float) -> Callable[[Log, Draw], Log]:
    def change(log: Log, draw: Draw) -> Log:
        log.rows[:, int(draw.choice(log.where(kind)))] *= draw.uniform(low, high)
        return log

    return change


def _times(factor: float, *kinds: str) -> Callable[[Log, Draw], Log]:
    def change(log: Log, draw: Draw) -> Log:
        log.rows[:, log.where(*kinds)] *= factor
        return log

    return change


def _exchanged(log: Log, draw: Draw) -> Log:
    count = len(log.where("q"))
    a, b = draw.choice(count, 2, replace=False)
    for kind in ("q", "tau|i"):
        columns = log.where(kind)
        log.rows[:, [columns[a], columns[b]]] = log.rows[:, [columns[b], columns[a]]]
    return log


def _turned(log: Log, draw: Draw) -> Log:
    j = int(draw.integers(len(log.where("q"))))
    log.rows[:, [log.where("q")[j], log.where("tau", "i")[j]]] *= -1.0
    return log


def _one(kind: str, change: Callable[[Array, Draw], Array]) -> Callable[[Log, Draw], Log]:
    """One column of a kind changed."""

    def apply(log: Log, draw: Draw) -> Log:
        k = 0 if kind == "t" else int(draw.choice(log.where(kind)))
        log.rows[:, k] = change(log.rows[:, k], draw)
        return log

    return apply


def _spikes(x: Array, draw: Draw) -> Array:
    x[draw.integers(len(x), size=5)] += 50.0 * np.abs(x).max()
    return x


def _contact(log: Log, draw: Draw) -> Log:
    """Something holds the arm for half a second."""
    begin = int(draw.integers(len(log.rows) // 2))
    stop = begin + int(np.searchsorted(log.rows[begin:, 0], log.rows[begin, 0] + 0.5))
    columns = log.where("tau", "i")
    log.rows[begin:stop, columns] += 0.5 * np.abs(log.rows[:, columns]).max(axis=0)
    return log


def _rows(change: Callable[[Array, Draw], Array]) -> Callable[[Log, Draw], Log]:
    return lambda log, draw: Log(log.names, change(log.rows, draw))


def _late(log: Log, draw: Draw) -> Log:
    columns, shift = log.where("tau", "i"), int(draw.integers(1, 6)) * int(draw.choice([-1, 1]))
    log.rows[:, columns] = np.roll(log.rows[:, columns], shift, axis=0)
    return log


LOGS: dict[str, Callable[[Log, Draw], Log]] = {
    "time runs backwards": _rows(lambda rows, draw: rows[::-1].copy()),
    "time stands still": _one("t", lambda t, draw: 0.0 * t),
    "time jumps": _one("t", lambda t, draw: t + 5.0 * (t > t.mean())),
    "time in milliseconds": _one("t", lambda t, draw: 1e3 * t),
    "time has double stamps": _one("t", lambda t, draw: np.repeat(t[::2], 2)[: len(t)]),
    "time is huge": _one("t", lambda t, draw: t + 1e15),
    "rows shuffled": _rows(lambda rows, draw: draw.permutation(rows)),
    "a tenth of the rows": _rows(lambda rows, draw: rows[::10]),
    "only the first tenth": _rows(lambda rows, draw: rows[: len(rows) // 10]),
    "one row": _rows(lambda rows, draw: rows[:1]),
    "no rows": _rows(lambda rows, draw: rows[:0]),
    "a gap": _rows(lambda rows, draw: np.delete(rows, slice(len(rows) // 3, len(rows) // 2), axis=0)),
    "rows twice": _rows(lambda rows, draw: np.repeat(rows, 2, axis=0)),
    "a position stands still": _one("q", lambda x, draw: np.full_like(x, x[0])),
    "a torque stands still": _one("tau|i", lambda x, draw: np.full_like(x, x[0])),
    "all torques zero": _times(0.0, "tau", "i"),
    "all positions zero": _times(0.0, "q"),
    "positions in degrees": _times(57.29577951308232, "q"),
    "torques in millinewton metres": _times(1e3, "tau", "i"),
    "torques of the other sign": _times(-1.0, "tau", "i"),
    "huge torques": _times(1e300, "tau", "i"),
    "tiny torques": _times(1e-300, "tau", "i"),
    "noise": _one("tau|i", lambda x, draw: x + np.abs(x).max() * draw.standard_normal(len(x))),
    "spikes": _one("tau|i", _spikes),
    "a torque clipped": _one("tau|i", lambda x, draw: np.clip(x, -0.3 * np.abs(x).max(), 0.3 * np.abs(x).max())),
    "a coarse encoder": _one("q", lambda x, draw: np.round(x, 2)),
    "contact": _contact,
    "torque early or late": _late,
    "a joint counted backwards": _turned,
    "two joints exchanged": _exchanged,
    "a position's zero moved": _one("q", lambda x, draw: x + draw.uniform(0.2, 1.0)),
    "one gain off": _scaled("tau|i", 1.1, 1.3),
    "all gains off": _times(1.08, "tau", "i"),
}
