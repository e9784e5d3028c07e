"""Whole runs give what is frozen. What changed on purpose is frozen anew: see :mod:`freeze`."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.frozen.compare import differences, told
from dynident.tests.frozen.freeze import FOLDER, outputs, read
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.tests.frozen.runs import RUNS, Run

NAMES = [run.name for run in RUNS]


@pytest.fixture(scope="module")
def inputs() -> Iterator[Path]:
    """All inputs in a folder of their own, which is the working folder."""
    with folder_of_inputs() as folder:
        yield folder


@pytest.mark.parametrize("run", RUNS, ids=NAMES)
def test_a_run_gives_what_is_frozen(run: Run, inputs: Path) -> None:
    if run.real and not os.environ.get("DYNIDENT_DATA"):
        pytest.skip("real recordings: set DYNIDENT_DATA to their folder")
    rows = differences(run, read(run), outputs(run))
    assert not rows, told(run, rows)


@pytest.mark.long
def test_runs_without_a_compiler_give_what_is_frozen(tmp_path: Path) -> None:
    """In a process of its own, for what was compiled stays.

    Not the runs on real recordings: the interval of a principal moment is a local search, and on the real pair it
    ends one per cent elsewhere when the regressor's last digits change.
    """
    environment = {**os.environ, "DYNIDENT_NO_COMPILER": "1"}
    environment.pop("DYNIDENT_DATA", None)
    program = [sys.executable, "-m", "dynident.tests.frozen.freeze", "--into", str(tmp_path)]
    subprocess.run(program, check=True, env=environment, capture_output=True)
    frozen_runs = [run for run in RUNS if (tmp_path / f"{run.name}.json").exists()]
    texts = [told(run, rows) for run in frozen_runs if (rows := differences(run, read(run), read(run, tmp_path)))]
    assert frozen_runs
    assert not texts, "\n\n".join(texts)


def test_every_run_is_frozen_and_no_other() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.json")) == sorted(NAMES)
    assert len(set(NAMES)) == len(NAMES)
