"""Recordings of next to nothing: every command that reads one answers or says in a line what is wrong."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.commands.lines import LINES
from dynident.tests.commands.test_faults import folder, run, words
from dynident.tests.selection import cases

__all__ = ["folder"]
ROWS = (0, 1, 2, 3, 10)


def logs(name: str) -> Iterator[str]:
    """The recordings that a command's line names."""
    return (word for word in words(name) if word.endswith(".csv") and "--out" not in word)


READERS = [name for name in LINES if any(logs(name)) and name != "record"]


@pytest.mark.parametrize("name", cases(READERS, lambda name: name not in ("score", "rollout")))
def test_a_recording_of_a_few_rows_is_one_line(name: str, folder: Path, tmp_path: Path) -> None:
    """Each recording of the line in turn, cut short; of a look at logs, and of a motion, a few rows may do."""
    statuses = set[int]()
    for log in logs(name):
        lines = (folder / log).read_text().splitlines(keepends=True)
        head = next(k for k, line in enumerate(lines) if not line.startswith("#")) + 1
        for rows in ROWS:
            short = tmp_path / f"{rows}.csv"
            short.write_text("".join(lines[: head + rows]))
            line = [str(short) if word == log else word for word in words(name)]
            status, _, err = run(
                [word if word not in ("b.json", "out", "store") else str(tmp_path / word) for word in line]
            )
            statuses.add(status)
            assert status in (0, 1, 2), (rows, err)
            errors = [text for text in err.splitlines() if not text.startswith("dynident: note:")]
            assert len(errors) == (status == 2), (rows, err)
    assert statuses & {1, 2}
