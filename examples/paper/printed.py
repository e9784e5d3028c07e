"""The numbers the paper prints."""

import tomllib
from pathlib import Path
from typing import NamedTuple


class Printed(NamedTuple):
    """One row of a table: value, two sigma (SI units), relative sigma in percent."""

    value: float
    two_sigma: float
    relative_sigma_percent: float


class PaperTables(NamedTuple):
    """Tables 1 and 2."""

    table1: dict[str, Printed]
    table2: dict[str, Printed]
    table2_robot: dict[str, Printed]


def paper_tables() -> PaperTables:
    """Read the published tables."""
    data = tomllib.loads(Path(__file__).with_name("tables.toml").read_text(encoding="utf-8"))
    return PaperTables(**{name: {key: Printed(*row) for key, row in rows.items()} for name, rows in data.items()})
