"""Makes the inputs of the frozen runs: motions, recordings, and what earlier commands left.

The inputs are kept in the repository, so that a run is judged on what it reads and not on the simulator as well;
this script is run again only if they are to change, and all runs are frozen anew after it:
``python -m dynident.tests.frozen.inputs``. It uses the command line alone. The robots ``ur10e.toml``
and ``tx40.toml`` are the shipped ones with the invented parameters of the benchmarks: no figures of those arms.
"""

import contextlib
import csv
import functools
import gzip
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from cyclopts.argument import Argument
from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import application, shown_name
from dynident.benchmarks.shared import UR10E_GAINS
from dynident.cli import main

FOLDER = Path(__file__).parent / "given"
EXAMPLES = Path(__file__).parents[2] / "examples"
BODIES = {
    "disc.toml": "mass = 1.6\ncom = [0.01, -0.02, 0.09]\ninertia_com = [0.008, 0.001, 0, 0.008, 0, 0.012]\n",
    "box.toml": "mass = 6.2\ncom = [0.01, -0.02, 0.15]\ninertia_com = [0.05, 0.004, 0, 0.06, 0, 0.03]\n",
}
_EXCITING = "--torque-limits none --via-points 6 --starts 1 --criterion cond-scaled --max-duration"
MOTIONS = {
    "rx_arm": f"design --robot rx90 {_EXCITING} 5",
    "rx_short": "design --robot rx90 --columns payload --via-points 4 --starts 1",
    "ur_arm": f"design --robot ur10e.toml {_EXCITING} 5 --torque-noise 10,10,8,3,3,3",
    "tx_arm": f"design --robot tx40.toml {_EXCITING} 4 --torque-noise 3,3,2,1,1,0.5",
    "six_arm": f"design --robot six_axis.toml {_EXCITING} 5 --torque-noise 10,10,8,3,3,3",
    "rx_near": "near --robot rx90 --pose=0,-45,90,0,45,0 --joints 2,3,5,6 --duration 8 --speed-override 0.6",
    "ur_near": "near --robot ur10e.toml --pose=0,-90,90,-90,-90,0 --joints 2,3,4,5,6 --duration 8 "
    "--speed-override 0.5 --torque-noise 10,10,8,3,3,3",
    "rx_wrist": "near --robot rx90 --pose=0,-45,90,0,45,0 --joints 4,5,6 --mass 6+-0.1 --duration 4 starts=1",
    "six_rest": "near --static --robot six_axis.toml --pose=0,-30,45,0,45,0 --joints 2,3,5 --mass 2.5 starts=1",
}
REPEATS = "rx_one", "rx_two", "rx_three"
"""Names under which rx_short runs again and again."""
RECORDINGS = (
    "--robot rx90 --trajectory rx_arm.csv --trajectory rx_near.csv --payload box.toml --rate 125 --seed 1",
    "--robot ur10e.toml --trajectory ur_arm.csv --trajectory ur_near.csv --payload box.toml --noise 0.05 "
    "--rate 125 --seed 2",
    "--robot tx40.toml --trajectory tx_arm.csv --payload disc.toml --noise 0.05 --rate 200 --seed 3",
    "--robot six_axis.toml --trajectory six_arm.csv --payload gripper.toml --rate 125 --seed 4",
    "--robot rx90 --trajectory rx_wrist.csv --payload box.toml --rate 125 --seed 5",
    "--robot six_axis.toml --trajectory six_rest.csv --payload gripper.toml --rate 40 --seed 6",
    "--robot rx90 --trajectory rx_one.csv --trajectory rx_two.csv --trajectory rx_three.csv --payload box.toml "
    "--rate 125 --seed 7",
)
DOCUMENTS = {
    "tx_robot.json": "identify --robot tx40 --data tx_arm_unloaded.csv equation-rate=25",
    "rx_payload.json": "payload --robot rx90 --unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv",
}
"""Written by an earlier command."""


PLACE = Path(tempfile.gettempdir()) / f"dynident-settings-{os.getpid()}.toml"


NAMES = [name for name, (where, _) in COMMANDS.items() if where]
"""Every command that runs."""


@functools.cache
def arguments(name: str) -> list[Argument]:
    """Options and settings of a command."""
    app = application()
    for word in name.split():
        app = app[word]
    found = app.assemble_argument_collection(parse_docstring=True)
    return [argument for argument in found if argument.parse and not argument.children]


@functools.cache
def keys() -> frozenset[str]:
    """Settings of all commands."""
    return frozenset(shown_name(one) for name in NAMES for one in arguments(name) if not one.show)


def filed(words: Sequence[str]) -> list[str]:
    """Words of a line as they are typed: settings, ``key=value`` or ``key`` and its value, go into a file."""
    typed, settings, left = list[str](), dict[str, str](), iter(words)
    for word in left:
        key, mark, value = word.partition("=")
        if key in keys():
            settings[key] = value if mark else next(left, "")  # the last one counts, as of options
        else:
            typed.append(word)
    if not settings:
        return typed
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in settings.items())
    if "--config" in typed:
        k = typed.index("--config")
        text += Path(typed[k + 1]).read_text(encoding="utf-8")
        del typed[k : k + 2]
    PLACE.write_text(text, encoding="utf-8")
    return [*typed, "--config", str(PLACE)]


@contextlib.contextmanager
def folder_of_inputs() -> Iterator[Path]:
    """An empty folder with all inputs in it, unpacked, which is the working folder meanwhile."""
    with tempfile.TemporaryDirectory() as name:
        unpack(Path(name))
        with contextlib.chdir(name):
            yield Path(name)


def unpack(folder: Path) -> None:
    """Put all inputs into a folder."""
    for path in FOLDER.iterdir():
        if path.suffix == ".gz":
            (folder / path.stem).write_bytes(gzip.decompress(path.read_bytes()))
        else:
            (folder / path.name).write_bytes(path.read_bytes())
    for path in (EXAMPLES / "gripper.toml", EXAMPLES / "robots/six_axis.toml"):
        (folder / path.name).write_bytes(path.read_bytes())


def keep(path: Path) -> None:
    """Pack a file into the folder of inputs; the same text gives the same bytes."""
    (FOLDER / f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes(), mtime=0))


def dynident(line: str, *more: str) -> None:
    """Run one command that has to answer."""
    status = main(filed([*line.split(), *more]))
    if status > 1:
        raise SystemExit(f"status {status}: {line}")


def round_recording(path: Path) -> None:
    """Round as a controller writes: positions to a microradian, torques to a tenth of a millinewton metre."""
    rows = [row for row in csv.reader(path.read_text(encoding="utf-8").splitlines()) if not row[0].startswith("#")]
    digits = [4 if name.startswith("tau") else 6 for name in rows[0]]
    lines = [rows[0], *([f"{float(x):.{d}f}" for x, d in zip(row, digits, strict=True)] for row in rows[1:])]
    path.write_text("".join(",".join(line) + "\n" for line in lines), encoding="utf-8")


def as_currents(path: Path, target: Path) -> None:
    """Copy of a recording with motor currents [A] for torques."""
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    gain = {f"tau{j}": gain for j, gain in enumerate(UR10E_GAINS, 1)}
    names = [name.replace("tau", "i") for name in rows[0]]
    scales = [gain.get(name) for name in rows[0]]
    lines = [
        [x if scale is None else f"{float(x) / scale:.5f}" for x, scale in zip(row, scales, strict=True)]
        for row in rows[1:]
    ]
    target.write_text("".join(",".join(line) + "\n" for line in (names, *lines)), encoding="utf-8")


def make() -> None:
    """Make all of them."""
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    for name, text in BODIES.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    with folder_of_inputs() as folder:
        for name, line in MOTIONS.items():
            dynident(f"{line} sample-rate=125 --samples {name}.csv")
        for name in ("rx_arm", "rx_short"):
            keep(folder / f"{name}.csv")
        for name in REPEATS:
            shutil.copy(folder / "rx_short.csv", folder / f"{name}.csv")
        for line in RECORDINGS:
            dynident(f"simulate {line} --out .")
        recordings = sorted(path for path in folder.glob("*loaded.csv") if "currents" not in path.name)
        for path in recordings:
            round_recording(path)
            keep(path)
            if path.name.startswith("ur_arm"):
                currents = path.with_name(path.name.replace("arm", "currents"))
                as_currents(path, currents)
                keep(currents)
        for name, line in DOCUMENTS.items():
            dynident(line, "--json", name)
            document = json.loads((folder / name).read_text(encoding="utf-8"))
            (folder / name).write_text(json.dumps(document, separators=(",", ":")), encoding="utf-8")
            keep(folder / name)


if __name__ == "__main__":
    make()
