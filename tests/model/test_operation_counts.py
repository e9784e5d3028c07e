"""The page of operation counts says what the code does."""

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "benchmarks" / "regressor.py"))


def test_page_shows_the_computed_tables() -> None:
    page = (ROOT / "docs" / "operation_counts.md").read_text(encoding="utf-8")
    first, second = SCRIPT["tables"]()
    assert first in page
    assert second in page


def test_fewer_operations_than_symoro() -> None:
    for row, (multiplications, additions) in zip(SCRIPT["rigid_bodies"](), SCRIPT["SYMORO"].values(), strict=True):
        ours = [int(cell) for cell in row.split("|")[2:6]]
        assert ours[0] < multiplications
        assert ours[1] + ours[2] < additions
