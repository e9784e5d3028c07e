"""Freezes the numbers of whole runs, one JSON file a run.

``python -m dynident.tests.frozen.freeze`` freezes all, with names of runs those alone. What changed on purpose is
frozen anew, looked at in the difference that version control shows, and committed with the change.
"""

import argparse
import contextlib
import io
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from dynident.cli import main
from dynident.tests.frozen.inputs import filed, folder_of_inputs
from dynident.tests.frozen.numbers import Leaves, leaves
from dynident.tests.frozen.runs import RUNS, Run

FOLDER = Path(__file__).parent / "data"
_SETTINGS = {"SOURCE_DATE_EPOCH": "0", "COLUMNS": "80", "NO_COLOR": "1"}


class Frozen(NamedTuple):
    """Numbers of one run."""

    status: int
    numbers: Leaves
    """Leaves of its JSON document."""


def outputs(run: Run) -> Frozen:
    """Run one command line in the working folder, which holds the inputs."""
    line = run.line.replace("DYNIDENT_DATA", os.environ.get("DYNIDENT_DATA", ""))
    silent = io.StringIO()
    with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent), settings():
        try:
            status = main(filed([*line.split(), "--json", "a.json"]))
        except SystemExit as stop:
            status = int(stop.code or 0)
    path = Path("a.json")
    numbers = leaves(json.loads(path.read_text(encoding="utf-8"))) if path.exists() else {}
    path.unlink(missing_ok=True)
    return Frozen(status, numbers)


@contextlib.contextmanager
def settings() -> Iterator[None]:
    """Environment that decides nothing but how outputs look, the same everywhere."""
    before = {name: os.environ.get(name) for name in _SETTINGS}
    os.environ.update(_SETTINGS)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def write(folder: Path, run: Run, frozen: Frozen) -> None:
    """One file a run, one line a number."""
    text = json.dumps({"line": run.line, **frozen._asdict()}, ensure_ascii=False, indent=0)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{run.name}.json").write_text(text + "\n", encoding="utf-8")


def read(run: Run, folder: Path = FOLDER) -> Frozen:
    """Read back the files of :func:`write`."""
    content = json.loads((folder / f"{run.name}.json").read_text(encoding="utf-8"))
    return Frozen(content["status"], content["numbers"])


def freeze(names: list[str], into: Path) -> None:
    """Freeze runs by name, or all that can be run here."""
    with folder_of_inputs():
        for run in RUNS:
            if run.name not in names and names:
                continue
            if run.real and not os.environ.get("DYNIDENT_DATA"):
                print(f"{run.name}: kept as it was, for DYNIDENT_DATA is not set")
                continue
            write(into, run, outputs(run))
            print(f"{run.name}: frozen")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Freeze the numbers of whole runs.")
    known = [run.name for run in RUNS]
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"all by default; of {', '.join(known)}")
    parser.add_argument("--into", type=Path, default=FOLDER, help="folder of the frozen files")
    chosen = parser.parse_args()
    if unknown := set(chosen.runs) - set(known):
        parser.error(f"no run is called {', '.join(sorted(unknown))}")
    freeze(chosen.runs, chosen.into.absolute())
