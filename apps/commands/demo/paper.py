"""The numbers the paper prints."""

import tomllib
from importlib import resources
from typing import NamedTuple

import numpy as np

from ....model import INERTIAL, InertialParameters


class Printed(NamedTuple):
    """One row of a table: value, two sigma (SI units), relative sigma in percent."""

    value: float
    two_sigma: float
    relative_sigma_percent: float


class PaperTables(NamedTuple):
    """Tables 1 and 2, and the reference payload."""

    payload: InertialParameters
    table1: dict[str, Printed]
    table2: dict[str, Printed]
    table2_robot: dict[str, Printed]


def paper_tables() -> PaperTables:
    """Read the published tables."""
    text = (resources.files(__package__) / "paper_tables.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    rows = {
        name: {key: Printed(*row) for key, row in data[name].items()}
        for name in ("table1", "table2", "table2_robot")
    }
    payload = InertialParameters(np.array([data["a_priori"][kind] for kind in INERTIAL], dtype=float))
    return PaperTables(payload, **rows)
