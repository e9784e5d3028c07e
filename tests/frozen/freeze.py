"""Freezes the outputs of whole runs, one JSON file a run.

``python -m dynident.tests.frozen.freeze`` freezes all, with names of runs those alone. What changed on purpose is
frozen anew, looked at in the difference that version control shows, and committed with the change.
"""

import argparse
import contextlib
import io
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from dynident.cli import main
from dynident.tests.frozen.documents import Leaves, leaves
from dynident.tests.frozen.inputs import folder_of_inputs
from dynident.tests.frozen.runs import RUNS, Run
from dynident.tests.frozen.texts import Text, take_apart, text_of_html

FOLDER = Path(__file__).parent / "data"
TERMINAL = "terminal"
_ROWS = 10
"""Of a time series every tenth row is kept."""
_SETTINGS = {"SOURCE_DATE_EPOCH": "0", "COLUMNS": "80", "NO_COLOR": "1"}


class Frozen(NamedTuple):
    """What one run gave."""

    status: int
    texts: dict[str, Text]
    """Terminal, pages, tables and exported files, by name."""
    documents: dict[str, Leaves]
    """JSON documents by name."""


def outputs(run: Run) -> Frozen:
    """Run one command line in the working folder, which holds the inputs."""
    out, err = io.StringIO(), io.StringIO()
    line = run.line.replace("DYNIDENT_DATA", os.environ.get("DYNIDENT_DATA", ""))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), settings():
        try:
            status = main(line.split())
        except SystemExit as stop:
            status = int(stop.code or 0)
    texts = {TERMINAL: take_apart(_anonymous(out.getvalue() + "\n" + err.getvalue()))}
    documents = {}
    for name in run.files:
        path = Path(name)
        text = _anonymous(path.read_text(encoding="utf-8")) if path.exists() else "(no such file)"
        path.unlink(missing_ok=True)
        if path.suffix == ".json" and text.startswith("{"):
            documents[name] = leaves(json.loads(text))
        else:
            texts[name] = take_apart(_readable(path.suffix, text))
    return Frozen(status, texts, documents)


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


def _anonymous(text: str) -> str:
    """Without the folder of real recordings."""
    data = os.environ.get("DYNIDENT_DATA")
    return text.replace(data, "DYNIDENT_DATA") if data else text


def _readable(suffix: str, text: str) -> str:
    if suffix == ".html":
        return text_of_html(text)
    lines = text.splitlines()
    start = next((i for i, line in enumerate(lines) if line.startswith("t,")), None)
    if suffix == ".csv" and start is not None:
        return "\n".join(lines[: start + 1] + lines[start + 1 :: _ROWS])
    return text


def write(folder: Path, run: Run, frozen: Frozen) -> None:
    """One file a run, one line a word line or number."""
    texts = {name: text._asdict() for name, text in frozen.texts.items()}
    content: dict[str, Any] = {
        "line": run.line,
        "status": frozen.status,
        "texts": texts,
        "documents": frozen.documents,
    }
    text = json.dumps(content, ensure_ascii=False, indent=0)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{run.name}.json").write_text(text + "\n", encoding="utf-8")


def read(run: Run, folder: Path = FOLDER) -> Frozen:
    """What :func:`write` wrote."""
    content = json.loads((folder / f"{run.name}.json").read_text(encoding="utf-8"))
    texts = {name: Text(**text) for name, text in content["texts"].items()}
    return Frozen(content["status"], texts, content["documents"])


def freeze(names: list[str], into: Path) -> None:
    """Freeze runs by name, or all that can be run here."""
    unknown = set(names) - {run.name for run in RUNS}
    if unknown:
        sys.exit(f"no run is called {', '.join(sorted(unknown))}; there are {', '.join(run.name for run in RUNS)}")
    can = [run for run in RUNS if not run.real or os.environ.get("DYNIDENT_DATA")]
    with folder_of_inputs():
        for run in can:
            if not names or run.name in names:
                write(into, run, outputs(run))
                print(f"{run.name}: frozen")
    for run in () if names else [run for run in RUNS if run not in can]:
        print(f"{run.name}: kept as it was, for DYNIDENT_DATA is not set")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Freeze the outputs of whole runs.")
    parser.add_argument("runs", nargs="*", metavar="RUN", help="names of runs; all by default")
    parser.add_argument("--into", type=Path, default=FOLDER, help="folder of the frozen files")
    chosen = parser.parse_args()
    freeze(chosen.runs, chosen.into.absolute())
