"""Every option of every command changes something or is refused, and none can be forgotten here."""

import contextlib
import io
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.blocks import Drawing
from dynident.apps.report.figures.canvas import new_figure
from dynident.cli import main
from dynident.model import INERTIAL
from dynident.tests.commands.declared import NAMES, arguments, options
from dynident.tests.commands.lines import LINES, PORTS, make_recordings, put_payloads
from dynident.tests.commands.options import OPTIONS
from dynident.tests.frozen.freeze import settings
from dynident.tests.frozen.inputs import EXAMPLES, folder_of_inputs
from dynident.tests.live.played import playing

pytestmark = pytest.mark.usefixtures("hasty")
TEXTS = {
    "turned.toml": "[position]\nsign = [1, -1, 1, 1, 1, 1]\n",
    "loud.toml": "verbose = true\n",
    "degrees.toml": '[position]\nunit = "deg"\n',
    "scene.toml": '[[surfaces]]\nname = "floor"\noffset = -0.3\n[[bodies]]\nname = "tool"\nlink=6\nradius = .1\n',
}
HEAVY = "\n".join(
    [
        'name = "heavy"\nmass_kg = 5\n[[joints]]\nalpha_deg = 0\n[[joints]]\nalpha_deg = 90\n[parameters]',
        *(f"{kind}{j} = {9 * (kind in ('XX', 'YY', 'ZZ', 'M'))}" for j in (1, 2) for kind in INERTIAL),
    ]
)
"""A robot whose links weigh more than the arm."""
SEARCHES = ("design", "near")
"""Commands of a few evaluations of many models, each of which a compiler would take longer to compile."""
TEXTS_ASKED_FOR = ("export", "robot list", "robot show")
"""Commands whose printed text is the answer itself, which ``--quiet`` leaves as it is."""
VARYING = re.compile(rb'"cpu_s": [0-9.e-]+')
"""What differs from one run to the next."""


@pytest.fixture(autouse=True)
def empty_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures without content: each shows what stands in numbers beside it, and half of the time went into them."""
    monkeypatch.setattr(Drawing, "figure", property(lambda _: new_figure(1.0, 1.0)))


@pytest.fixture(scope="module")
def inputs() -> Iterator[Path]:
    """All inputs in a folder of their own, which is the working folder."""
    with folder_of_inputs() as folder, playing(**PORTS):
        for name, text in TEXTS.items():
            (folder / name).write_text(text)
        put_payloads(folder)
        for name, share in (("before", 0.9), ("after", 0.95)):
            follow(folder / "rx_near_loaded.csv", folder / f"{name}.csv", share)
        for name in ("unloaded", "loaded"):  # the same numbers twice are refused
            rows = (folder / f"ur_currents_{name}.csv").read_text().splitlines(keepends=True)
            (folder / f"ur_again_{name}.csv").write_text("".join(rows[:-3]))
        shutil.copy(EXAMPLES / "robots/six_axis.urdf", folder)
        main(["identify", *LINES["identify"].split(), "--json", "earlier.json"])
        make_recordings(folder)
        (folder / "heavy.toml").write_text(HEAVY)
        yield folder


def follow(source: Path, target: Path, share: float) -> None:
    """A recording with the torque that its controller predicted, a share of what was measured."""
    header = source.read_text().partition("\n")[0]
    values = np.loadtxt(source, delimiter=",", skiprows=1)
    predicted = ",".join(f"tauref{j}" for j in range(1, 7))
    values = np.hstack([values, share * values[:, 7:13]])
    np.savetxt(target, values, delimiter=",", header=f"{header},{predicted}", comments="", fmt="%.9g")


def run(inputs: Path, line: str) -> dict[str, bytes]:
    """What a line prints and writes, in a folder of its own that holds all inputs."""
    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name), settings():
        shutil.copytree(inputs, name, dirs_exist_ok=True)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            try:
                status = main(line.split())
            except SystemExit as stop:
                status = int(stop.code or 0)
        files = {str(path.relative_to(name)): path.read_bytes() for path in Path(name).rglob("*") if path.is_file()}
    outputs = files | {"(status)": str(status).encode(), "(terminal)": printed.getvalue().encode()}
    return {name: VARYING.sub(b"", content) for name, content in outputs.items()}


def test_no_option_is_without_an_entry() -> None:
    assert {name: sorted(options(name)) for name in NAMES} == {
        name: sorted(entries) for name, entries in OPTIONS.items()
    }


def test_payload_shows_no_more_than_thirty() -> None:
    shown = [argument.name for argument in arguments("payload") if argument.show]
    assert len(shown) <= 30, shown


def differing(folder: Path, name: str, entry: str, bases: dict[str, dict[str, bytes]]) -> bool:
    """Whether a line with an option gives anything else than the line without it."""
    needs, _, more = entry.rpartition("|")
    line = needs.strip().removeprefix("=") if needs.startswith("=") else f"{LINES[name]} {needs}"
    if line not in bases:
        bases[line] = run(folder, f"{name} {line}")
    return run(folder, f"{name} {line} {more}") != bases[line]


@pytest.mark.long
@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_changes_something_or_is_refused(
    name: str, inputs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name in SEARCHES:
        monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    line = f"{name} {LINES[name]}"
    bases = {LINES[name]: run(inputs, line)}
    assert run(inputs, line) == bases[LINES[name]], "a line gives the same twice"
    ignored = [option for option, entry in OPTIONS[name].items() if not differing(inputs, name, entry, bases)]
    assert ignored == (["--quiet"] if name in TEXTS_ASKED_FOR else [])
