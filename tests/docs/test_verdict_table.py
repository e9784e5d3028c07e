"""The page on verdicts holds the table of checks as the code prints it."""

import os

from dynident.estimation.diagnosis.verdict import table
from dynident.tests.docs.pages import ROOT

PAGE = ROOT / "docs/verdict.md"
BEGIN, END = "<!-- table -->\n", "<!-- /table -->\n"


def test_the_table_is_that_of_the_code() -> None:
    """Run with WRITE_DOCS=1 to write it anew."""
    rows = [f"| {what.rstrip('.')} | {limits} |\n" for what, limits in table()]
    printed = "".join(["| check | from where on, and what it spoils |\n", "|---|---|\n", *rows])
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    shown, _, after = rest.partition(END)
    if os.environ.get("WRITE_DOCS"):
        PAGE.write_text(f"{before}{BEGIN}{printed}{END}{after}", encoding="utf-8")
        return
    assert shown == printed
