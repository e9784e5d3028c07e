"""Mistakes that users type, and the one line that each ends in: what is wrong, where, and what to do.

The table stands in ``docs/mistakes.md`` too: ``python -m dynident.tests.commands.mistakes`` writes the page.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from dynident.tests.commands.typed import typed
from dynident.tests.frozen.inputs import EXAMPLES, folder_of_inputs

PAGE = Path(__file__).parents[2] / "docs/mistakes.md"
_TABLE = Path(__file__).with_suffix(".toml")
_ARM = "rx_arm_unloaded.csv"
_HEAD = """# Mistakes and their messages

Input that cannot be used ends in exit status 2 and one line that says what is wrong, where, and what to do.
Nothing is written. These are the lines for {count} mistakes; the tests type each of them.

| a user | typed `dynident ...` | and reads `dynident: error: ...` |
|---|---|---|
"""

Lines = list[str]


class Mistake(NamedTuple):
    """The user's mistake, the command line, and parts of the answer: where it is wrong, and what to do."""

    did: str
    line: str
    where: str
    do: str


MISTAKES = tuple(Mistake(**entry) for entry in tomllib.loads(_TABLE.read_text(encoding="utf-8"))["mistake"])


def row(mistake: Mistake, errors: str) -> str:
    """The mistake's row of the page."""
    message = errors.splitlines()[-1].partition("error: ")[2]
    cells = (mistake.did, f"`{mistake.line}`", f"`{message}`")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def write_page() -> None:
    """Type every mistake, and write the page."""
    with folder_of_inputs():
        write_inputs()
        rows = [row(mistake, typed(mistake.line).err) for mistake in MISTAKES]
    PAGE.write_text(_HEAD.format(count=len(rows)) + "\n".join(rows) + "\n", encoding="utf-8")


def _edited(change: Callable[[Lines], Lines]) -> str:
    """The RX90's recording without payload after a change of its lines."""
    return "\n".join(change(Path(_ARM).read_text(encoding="utf-8").splitlines())) + "\n"


def _cells(change: Callable[[int, str], str], rows: slice = slice(1, None)) -> Callable[[Lines], Lines]:
    """Change cells, told their column, of some rows."""

    def changed(lines: Lines) -> Lines:
        for k in range(*rows.indices(len(lines))):
            lines[k] = ",".join(change(column, cell) for column, cell in enumerate(lines[k].split(",")))
        return lines

    return changed


def _scaled(columns: range, factor: float) -> Callable[[Lines], Lines]:
    return _cells(lambda column, cell: f"{factor * float(cell):.6g}" if column in columns else cell)


def _held(columns: range) -> Callable[[Lines], Lines]:
    """The first row's value in all rows."""

    def changed(lines: Lines) -> Lines:
        first = lines[1].split(",")
        return _cells(lambda column, cell: first[column] if column in columns else cell)(lines)

    return changed


def _later(time: str) -> str:
    """20 s are lost after each second and a half."""
    return f"{float(time) + 20.0 * (float(time) // 1.5)}"


def write_inputs() -> None:
    """Wrong files beside the good ones, in the working folder."""
    joint = "[[joints]]\nalpha_deg = 0\n"
    texts = {
        "misspelt.toml": f'name = "arm"\nmas_kg = 20\n{joint}',
        "radians.toml": 'name = "arm"\n[[joints]]\nalpha = 1.57\n',
        "jointless.toml": 'name = "arm"\n',
        "arm.xacro": '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:macro name="m"/><xacro:m/><link name="$(arg side)"/></robot>\n',
        "empty.csv": "",
        "header.csv": _edited(lambda lines: lines[:1]),
        "nocolumn.csv": _edited(_cells(lambda column, cell: "" if column == 9 else cell, slice(0, None))).replace(
            ",,", ","
        ),
        "word.csv": _edited(_cells(lambda column, cell: "high" if column == 3 else cell, slice(7, 8))),
        "nan.csv": _edited(_cells(lambda column, cell: "nan" if column == 3 else cell, slice(7, 8))),
        "cell.csv": _edited(lambda lines: [*lines[:7], lines[7] + ",1.0", *lines[8:]]),
        "back.csv": _edited(lambda lines: [lines[0], *lines[:0:-1]]),
        "short.csv": _edited(lambda lines: lines[:12]),
        "degrees.csv": _edited(_scaled(range(1, 7), 57.29578)),
        "milli.csv": _edited(_scaled(range(7, 13), 1e3)),
        "still.csv": _edited(_held(range(6, 7))),
        "dead.csv": _edited(_scaled(range(10, 11), 0.0)),
        "gap.csv": _edited(_cells(lambda column, cell: _later(cell) if column == 0 else cell)),
        "rest.csv": _edited(_held(range(1, 7))),
        "map.toml": '[positions]\nunit = "deg"\n',
        "part.csv": _edited(lambda lines: [f"{lines[0]},qref1", *(f"{line},0" for line in lines[1:])]),
        "misspelt_run.toml": 'command = "payload"\nmethd = 3\n',
        "other_run.toml": 'command = "identify"\n',
        "rate_run.toml": "rate = 0\n",
        "signs_run.toml": "signs = [1, -1]\n",
        "plots_run.toml": 'plots = "rx_arm_unloaded.csv"\n',
        "misspelt_load.toml": "mas = 2\n",
        "impossible.toml": "mass = 2\ncom = [0, 0, 0.1]\ninertia_com = [0.1, 0, 0, 0.01, 0, 0.01]\n",
        "millimetres.toml": "mass = 2500\ncom = [0, 0, 120]\ninertia_com = [8000, 0, 0, 8000, 0, 12000]\n",
        "grams.toml": "mass = 2500\ncom = [0, 0, 0.12]\ninertia_com = [0.008, 0, 0, 0.008, 0, 0.012]\n",
        "square.toml": "mass = 2.5\ncom = [0, 0, 0.12]\ninertia_com = [8000, 0, 0, 8000, 0, 12000]\n",
        "second.csv": _edited(lambda lines: lines[:126]),
        "longline.csv": _edited(lambda lines: [*lines[:7], f"{lines[7]}{1_000_000 * '0'}", *lines[8:]]),
        "longname.csv": _edited(
            lambda lines: [f"{lines[0]},{100_000 * '1'}", *(f"{line},0" for line in lines[1:])]
        ),
        "unseen.urdf": (EXAMPLES / "robots/six_axis.urdf")
        .read_text(encoding="utf-8")
        .replace('"six', '"\ufeffsix'),
    }
    for name, text in texts.items():
        Path(name).write_text(text, encoding="utf-8")
    Path("latin.csv").write_bytes("t,q1,Drehmoment_Größe\n0,0,0\n".encode("latin-1"))
    Path("log.xlsx").write_bytes(b"PK\x03\x04" + bytes(60))
    Path("picture.csv").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))


if __name__ == "__main__":
    write_page()
