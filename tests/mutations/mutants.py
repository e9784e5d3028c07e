"""Inputs with one mistake each: recordings, robot files, options and documents, drawn by a seed.

A mistake is made in a copy of a good input, and one command is run on it. What kinds there are stands in the tables
below; their names say what is wrong.
"""

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from dynident.common.arrays import Array

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


COMMANDS = (
    "payload --robot tx40.toml --unloaded tx_arm_unloaded.csv --loaded tx_arm_loaded.csv --json out.json",
    "payload --robot six_axis.toml --unloaded six_arm_unloaded.csv --loaded six_arm_loaded.csv --json out.json",
    "payload --robot tx40 --robot-parameters tx_robot.json --loaded tx_arm_loaded.csv equation-rate=25 "
    "--json out.json",
    "weigh --robot ur10e.toml --unloaded ur_near_unloaded.csv --loaded ur_near_loaded.csv --json out.json",
    "identify --robot six_axis.toml --data six_arm_unloaded.csv --json out.json",
    "check --robot six_axis.toml six_arm_unloaded.csv --json out.json",
    "gains --robot ur10e.toml --unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv --mass 6.2 "
    "--json out.json",
    "export rx_payload.json --to ur --flange-frame 0 0 0.1 0 0 30 --out out.script",
    "robot show --robot six_axis.toml",
    "robot export --to urdf --robot six_axis.toml --out out.urdf",
    "codegen --robot six_axis.toml --function gravity --out code",
    "simulate --robot six_axis.toml --payload box.toml --trajectory six_short.csv --rate 50 --out sim",
    "score --robot tx40.toml tx_arm_loaded.csv --torque-limits none --json out.json",
    "verify --robot tx40.toml --before tx_arm_unloaded.csv --after tx_arm_loaded.csv --json out.json",
    "fleet reduce six_arm_unloaded.csv --robot six_axis.toml equation-rate=31.25 --store store --json out.json",
    "compare six_arm_unloaded.csv six_arm_loaded.csv --robot six_axis.toml --json out.json",
)
MASSES = {"tx_arm_loaded.csv": 1.6, "six_arm_loaded.csv": 2.5, "ur_near_loaded.csv": 6.2}
"""What hangs on the flange in these recordings [kg]."""


class Mutant(NamedTuple):
    """One command with one mistake: its kind, what to type, and the files that differ from the good ones."""

    kind: str
    words: tuple[str, ...]
    files: dict[str, bytes]


def _cell(text: str) -> Callable[[bytes, Draw], bytes]:
    def change(content: bytes, draw: Draw) -> bytes:
        lines = content.split(b"\n")
        k = int(draw.integers(1, len(lines) - 1))
        cells = lines[k].split(b",")
        cells[int(draw.integers(len(cells)))] = text.encode()
        lines[k] = b",".join(cells)
        return b"\n".join(lines)

    return change


def _flipped(content: bytes, draw: Draw) -> bytes:
    damaged = bytearray(content)
    damaged[int(draw.integers(len(damaged)))] ^= 1 << int(draw.integers(8))
    return bytes(damaged)


def _cut(content: bytes, draw: Draw) -> bytes:
    return content[: int(draw.integers(len(content)))]


def _inserted(*pieces: bytes) -> Callable[[bytes, Draw], bytes]:
    def change(content: bytes, draw: Draw) -> bytes:
        k = int(draw.integers(len(content)))
        return content[:k] + pieces[int(draw.integers(len(pieces)))] + content[k:]

    return change


BYTES: dict[str, Callable[[bytes, Draw], bytes]] = {
    "a byte flipped": _flipped,
    "cut": _cut,
    "empty": lambda content, draw: b"",
    "blanks": lambda content, draw: b" \n\t\n",
    "UTF-16": lambda content, draw: content.decode().encode("utf-16"),
    "NULs": _inserted(bytes(10)),
    "bytes that are no UTF-8": _inserted(b"\xff\xfe\xe4"),
    "brackets": _inserted(b"[[", b"]", b"{", b'"', b"[/x]"),
    "twice": lambda content, draw: content + content,
}
TABLES: dict[str, Callable[[bytes, Draw], bytes]] = {
    "a cell of text": _cell("text"),
    "a cell that is nan": _cell("nan"),
    "a cell that is inf": _cell("inf"),
    "a huge cell": _cell("1e308"),
    "a cell missing": _cell(""),
    "a cell too many": _cell("1,2"),
    "a quoted cell": _cell('"1'),
    "semicolons": lambda content, draw: content.replace(b",", b";"),
    "no header": lambda content, draw: content.split(b"\n", 1)[1],
    "the header twice": lambda content, draw: content.split(b"\n", 1)[0] + b"\n" + content,
    "a column renamed": lambda content, draw: re.sub(rb"\b(q|tau|i)3\b", b"other", content, count=1),
    "a column twice": lambda content, draw: re.sub(rb"\b(q|tau|i)3\b", rb"\g<1>2", content, count=1),
}
ODD = (
    "0", "-1", "1e9", "-1e9", "1e300", "nan", "inf", "-inf", '"text"', '""', '"[/x]"', "true", "[]", "[1]", "{}",
    "[[1, 2], [3]]", "9" * 5000, "[" * 3000 + "]" * 3000, "1979-05-27", '"\u0000"',
)  # fmt: skip
"""What may stand in the place of a value in TOML, or in JSON where it has such a thing."""


def _odd_value(content: bytes, draw: Draw) -> bytes:
    """One value of a TOML or JSON text becomes another."""
    text = content.decode()
    values = list(re.finditer(r"(?<==)[^\n]+|(?<=: )[^\n,]+", text))
    if not values:
        return content[1:]
    place = values[int(draw.integers(len(values)))]
    odd = ODD[int(draw.integers(len(ODD)))]
    return (text[: place.start()] + f" {odd}" + text[place.end() :]).encode()


def _without_line(content: bytes, draw: Draw) -> bytes:
    lines = content.split(b"\n")
    del lines[int(draw.integers(len(lines)))]
    return b"\n".join(lines)


def _line_twice(content: bytes, draw: Draw) -> bytes:
    lines = content.split(b"\n")
    k = int(draw.integers(len(lines)))
    return b"\n".join([*lines[: k + 1], *lines[k:]])


def _renamed(content: bytes, draw: Draw) -> bytes:
    keys = list(re.finditer(rb'^\s*"?(\w+)"?(?= = |: )', content, flags=re.MULTILINE))
    if not keys:
        return content[1:]
    key = keys[int(draw.integers(len(keys)))]
    return content[: key.start(1)] + b"other" + content[key.end(1) :]


TEXTS: dict[str, Callable[[bytes, Draw], bytes]] = {
    "an odd value": _odd_value,
    "a line missing": _without_line,
    "a line twice": _line_twice,
    "a key renamed": _renamed,
}
VALUES = (
    "", "0", "-1", "1", "2", "7", "0.5", "nan", "inf", "-inf", "1e300", "-1e300", "1e-300", "999999999", "9" * 400,
    "x", "[/x]",
    "1,2,3", "1,2,3,4,5,6", "0,0,0,0,0,0", "nowhere.toml", "nowhere.csv", "out.json", ".", "none", "%s",
    "ä" * 50, "10%", "2,2", "[bold", "six_axis.toml", "tx_robot.json",
)  # fmt: skip
"""What may be typed behind an option."""


def mutant(draw: Draw, content_of: Callable[[str], bytes], options: Callable[[str], list[str]]) -> Mutant:
    """A command with one mistake.

    Args:
        content_of: content of a good input by its name.
        options: names of the options of a command.
    """
    words = COMMANDS[int(draw.integers(len(COMMANDS)))].split()
    files = [word for word in words if re.fullmatch(r"\w+\.(csv|toml|json)", word) and not word.startswith("out")]
    if not files or draw.random() < 0.3:
        return _with_option(words, draw, options)
    file = files[int(draw.integers(len(files)))]
    if file.endswith("loaded.csv") and draw.random() < 0.7:
        kind = list(LOGS)[int(draw.integers(len(LOGS)))]
        # What is wrong with one recording may be wrong with all of the day.
        both = draw.random() < 0.5
        seed = int(draw.integers(1 << 30))
        by_file = {
            name: LOGS[kind](read_log(content_of(name)), np.random.default_rng(seed)).text()
            for name in (files if both else [file])
            if name.endswith(".csv")
        }
        return Mutant(f"{'all recordings' if both else file}: {kind}", tuple(words), by_file)
    table = BYTES | (TABLES if file.endswith(".csv") else TEXTS)
    kind = list(table)[int(draw.integers(len(table)))]
    return Mutant(f"{file}: {kind}", tuple(words), {file: table[kind](content_of(file), draw)})


def _with_option(words: list[str], draw: Draw, options: Callable[[str], list[str]]) -> Mutant:
    """One more option, an option without its value, or another value."""
    known = options(" ".join(words[:2]) if words[0] in ("robot", "fleet") else words[0])
    option = known[int(draw.integers(len(known)))]
    value = VALUES[int(draw.integers(len(VALUES)))]
    more = [option] if draw.random() < 0.15 else [f"{option}={value}"]
    if draw.random() < 0.2:
        k = int(draw.integers(1, len(words)))
        words, more = [*words[:k], value, *words[k + 1 :]], []
    return Mutant(f"typed: {' '.join(more)[:60] or 'another word'}", (*words, *more), {})
