"""Recordings that contradict every robot: what is said, and that a bound of the mass leads to a file.

Whether the solver ends cleanly on them hangs on rounding, so its failure is put in where it is asked about.
"""

import os
from pathlib import Path
from typing import NoReturn

import pytest
from dynident import estimation
from dynident.estimation import SolverError

from .runs import Run, document

pytestmark = pytest.mark.long
HIGH = 14.0
"""kg: bound of the moving links, twice the prior."""


@pytest.fixture
def gen3() -> tuple[str, ...]:
    """A Gen3's 4.7 s, whose sensors do not obey any robot."""
    folder = os.environ.get("DYNIDENT_DATA")
    if not folder:
        pytest.skip("real recordings: set DYNIDENT_DATA to their folder")
    where = Path(folder) / "gen3"
    return ("--robot", str(where / "gen3.urdf"), "--data", str(where / "gen3_opti1.csv.gz"))


def fails(*_: object) -> NoReturn:
    """Ends as the solver does where no finite robot is nearest."""
    raise SolverError("AlmostSolved")


def test_without_a_bound_the_note_says_what_to_do(
    run: Run, gen3: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimation, "solve_constrained_prior", fails)
    _, _, errors = run("identify", *gen3, "--prior-mass", "7")
    (line,) = [text for text in errors.split("dynident: note: ") if "no robot that can exist is given" in text]
    assert "--total-mass 0 KG" in " ".join(line.split())


def test_a_bound_of_the_mass_leads_to_a_file(run: Run, gen3: tuple[str, ...], tmp_path: Path) -> None:
    stored, out = tmp_path / "robot.json", tmp_path / "arm.xml"
    run("identify", *gen3, "--prior-mass", "7", "--total-mass", "0", f"{HIGH:g}", "--json", str(stored))
    values = {entry["name"]: entry["value"] for entry in document(stored)["constrained"]["parameters"]}
    assert sum(values[f"M{link}"] for link in range(1, 8)) <= HIGH * (1.0 + 1e-6)
    written = ("robot", "export", "--to", "mjcf", *gen3[:2], "--robot-parameters", str(stored), "--out", str(out))
    status, _, errors = run(*written)
    assert status == 1, errors
    assert not out.exists()
    status, _, errors = run(*written, "--despite-verdict")
    assert status == 0, errors
    assert out.exists()
