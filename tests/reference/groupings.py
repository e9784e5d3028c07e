"""Reads the relations (12) of the RX90 and the list of section II.D from the reference file."""

import re
from pathlib import Path

_LINES = (Path(__file__).parent / "khalil_rx90_groupings.txt").read_text(encoding="utf-8").splitlines()


def rx90_relations() -> tuple[str, ...]:
    """The relations (12), one text each, spaces as in "ZZ2R = IA2 + D3^2*(M3+M4+M5+M6) + ZZ2"."""
    relations = [line for line in _LINES if " = " in line and not line.startswith("#")]
    return tuple(re.sub(r"\s*\*\s*", "*", _close_brackets(line)) for line in relations)


def rx90_eliminated() -> set[str]:
    """Standard inertial parameters that section II.D leaves out of the base parameters."""
    (line,) = (line for line in _LINES if "Not among the base parameters" in line)
    named = line.split(": ")[1].rstrip(".")
    every_link = [f"{kind}{j}" for kind in re.findall(r"([A-Z]+)j", named) for j in range(1, 7)]
    return {*every_link, *re.findall(r"[A-Z]+\d", named)}


def _close_brackets(line: str) -> str:
    return re.sub(r"\([^)]*\)", lambda bracket: bracket.group().replace(" ", ""), line)
