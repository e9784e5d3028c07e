"""Each of users' mistakes ends in one line: what is wrong, where, and what to do; the documentation shows it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.commands.mistakes import MISTAKES, PAGE, Mistake, answer_to, row, write_inputs
from dynident.tests.frozen.inputs import folder_of_inputs


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """Good and wrong files, in the working folder."""
    with folder_of_inputs() as here:
        write_inputs()
        yield here


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.did)
def test_a_mistake_is_one_line_that_says_where_and_what_to_do(mistake: Mistake, folder: Path) -> None:
    before = set(folder.rglob("*"))
    status, out, err = answer_to(mistake.line)
    assert (status, out) == (2, "")
    *notes, line = err.splitlines()
    assert all(note.startswith("dynident: note: ") for note in notes)
    assert line.startswith("dynident")
    assert mistake.where in line
    assert mistake.do in line
    assert set(folder.rglob("*")) == before, "nothing is written"
    assert row(mistake, err) in PAGE.read_text(encoding="utf-8").splitlines(), "write the page anew"


def test_the_page_shows_no_more_than_the_table() -> None:
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if "| `" in line]
    assert len(rows) == len(MISTAKES) >= 60
    assert len({mistake.line for mistake in MISTAKES}) == len(MISTAKES)
