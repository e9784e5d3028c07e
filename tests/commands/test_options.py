"""Every option of every command changes something or is refused, and takes no word that nobody means."""

import contextlib
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cyclopts import Token
from dynident.estimation.diagnosis import causes
from dynident.tests.commands.lines import BRIEF, LINES, NEAR, NOISE, REST, SCORE, WHOLE
from dynident.tests.commands.typed import options, refused, typed
from dynident.tests.frozen.inputs import NAMES, arguments

ROBOT = {"--robot": "--robot tx40", "chain": "chain=link_1:link_2", "--mount": "--mount wall"}
STAND_IN = {"--arm-mass": "--arm-mass 20"}
LOGS = {
    "--log-map": "--log-map turned.toml",
    "--joints": "--joints a,b,c,d,e,f",
    "--units": "--units q=deg",
    "signs": "signs=1,-1,1,1,1,1",
    "topic": "topic=/joint_states",
}
PROCESSING = {
    "rate": "rate=90",
    "--cutoff": "--cutoff 4",
    "equation-rate": "equation-rate=15",
    "offsets": "offsets=false | offsets=true",
    "coulomb": "coulomb=paper",
}
FILTER = {option: entry for option, entry in PROCESSING.items() if option != "equation-rate"}
KNOWN = {
    "--mass": "--mass 6.2+-0.05 | --mass 6.2+-0.5",
    "--mass-bounds": "--mass-bounds 6.5,",
    "--com-within": "--com-within=0.02,0.03,0,0.01,0.1,0.2",
    "--ellipsoid": "--ellipsoid=0,0,0.1,0.1,0.1,0.1",
}
LINKS = {name: ROBOT[name] for name in ("--robot", "chain")}
GAINS = {"--gain-sigma": "--gain-sigma 2% | --gain-sigma 2%,common=1%"}
STOPS = {"essential": "essential=1.2"}
EQUATIONS = {"--json": "--json a.json", "--npz": "--npz a.npz"}
PAGE = {"--report": "--report a.html", "plots": "plots=figures"}
VIEW = {"--view": "--view a.html"}
LIMITS = {
    "--speed-override": "--speed-override 0.5",
    "acceleration": "acceleration=2x",
    "--torque-limits": "--torque-limits 300,300,120,50,40,20",
    "--robot-parameters": "--robot-parameters tx_robot.json",
    "scene": "scene=scene.toml",
    "--no-floor": "=rx_arm.csv --robot ur10e --json b.json | --no-floor",
    "--heaviest-payload": "--heaviest-payload 7@0,0,0.2",
    "--within": "--heaviest-payload 2@0,0,0.1 | --within 0.1",
    "torque-margin": "torque-margin=5%",
}
MOTIONS = {
    "--json": "--json a.json",
    "--samples": "--samples a.csv",
    "--ros2": "--ros2 a.yaml",
    "joint-names": "--ros2 a.yaml | joint-names=a,b,c,d,e,f",
    "--urscript": "--urscript a.script",
    "controller-rate": "--urscript a.script | controller-rate=125",
    "sample-rate": "--samples a.csv | sample-rate=125",
}
CURRENTS = {"--drive-gains": "--drive-gains 1,2,3,4,5,6"}
HOST = {"--host": "--host 127.0.0.1.1", "--port": "--port 1"}

OPTIONS: dict[str, dict[str, str]] = {
    "weigh": ROBOT | LOGS | CURRENTS | PROCESSING | KNOWN | GAINS | PAGE | VIEW | {
        "--json": "--json a.json",
        "--loaded": "--loaded rx_arm_loaded.csv",
        "--unloaded": "--unloaded rx_arm_unloaded.csv",
        "--robot-parameters": "--robot-parameters tx_robot.json",
        "--moving": "--moving 2,3,5",
        "--friction-change": "--friction-change 5%",
        "--inertia": "--inertia box:200x200x100",
        "--static": "--static",
        "max-mismatch": "max-mismatch=1e-9",
    },
    "verify": LINKS | LOGS | CURRENTS | PAGE | {
        "--robot": "--robot panda",
        "--log-map": "--log-map degrees.toml",
        "signs": "signs=1,-1",
        "--before": "--before after.csv",
        "--after": "--after before.csv",
        "--json": "--json a.json",
    },
    "payload": ROBOT | LOGS | CURRENTS | PROCESSING | KNOWN | GAINS | STOPS | EQUATIONS | PAGE | VIEW | {
        "--tool-frame": "--tool-frame 0,0,0.05,0,0,30",
        "--unloaded": "--unloaded rx_near_unloaded.csv",
        "--loaded": "--loaded rx_near_loaded.csv",
        "--robot-parameters": "--robot-parameters tx_robot.json",
        "--method": "--method 3",
        "--friction": "--friction FS,FV,FR",
        "free-friction": "--method 1 | free-friction=true",
        "--scale-sigma": "--method 4 | --scale-sigma 2%",
        "--friction-change": "--method 4 | --friction-change 30%",
        "max-mismatch": "max-mismatch=1e-9",
        "--validate": "--validate rx_near_unloaded.csv",
    },
    "identify": ROBOT | LOGS | CURRENTS | PROCESSING | GAINS | STOPS | EQUATIONS | PAGE | {
        "--data": "--data rx_near_unloaded.csv",
        "--validate": "--validate rx_near_unloaded.csv",
        "--constrained": "--constrained none",
        "--prior-mass": "--constrained prior | --prior-mass 40",
        "prior-budget": "--constrained prior | prior-budget=4",
        "--total-mass": "--total-mass 20 60",
        "--friction": "--friction FS,FV,FR",
        "--rollout": "--validate rx_near_unloaded.csv | --rollout",
    },
    "rollout": ROBOT | LOGS | CURRENTS | FILTER | PAGE | {
        "--robot-parameters": "--robot-parameters other.json",
        "--data": "--data rx_near_unloaded.csv",
        "--against": "--against six_axis.urdf",
        "--horizons": "--horizons 0.2,0.4",
        "--json": "--json a.json",
    },
    "gains": ROBOT | LOGS | PROCESSING | PAGE | {
        "--unloaded": "--unloaded ur_near_unloaded.csv",
        "--loaded": "--loaded ur_near_loaded.csv",
        "--mass": "--mass 6",
        "--payload": "--payload box.toml",
        "friction": "friction=FS,FV,FR",
        "--mounting": "--unloaded ur_again_unloaded.csv --loaded ur_again_loaded.csv | --mounting 1,2",
        "--json": "--json a.json",
    },
    "apply": HOST | {
        "--payload": "tx_robot.json",
        "--to": "--to ur10",
        "--yes": "=flange.json --to ur --host 127.0.0.1 | --yes",
        "--despite-verdict": "=refused.json --to ur --host 127.0.0.1 | --despite-verdict",
        "script-port": "script-port=1",
    },
    "record": HOST | {
        "--maker": "ur",
        "--seconds": "--seconds 0.2",
        "--rate": "--rate 25",
        "--out": "--out a.csv",
    },
    "fleet reduce": ROBOT | LOGS | CURRENTS | PROCESSING | GAINS | {
        "--data": "second.csv",
        "--store": "--store other",
        "--pattern": "--pattern {arm}.csv",
        "--workers": "--workers 0",
        "--cluster": "--cluster tcp://127.0.0.1:1",
        "--json": "--json a.json",
    },
    "fleet report": PAGE | {
        "--store": "=--json b.json | nightly",
        "--json": "--json a.json",
    },
    "compare": ROBOT | LOGS | CURRENTS | PROCESSING | {"--data": "third.csv", "--json": "--json a.json"},
    "check": ROBOT | LOGS | CURRENTS | PROCESSING | PAGE | {
        "--data": "rx_near_unloaded.csv",
        "--json": "--json a.json",
    },
    "export": {
        "--payload": "tx_robot.json",
        "--to": "--to kuka",
        "--out": "--out a.txt",
        "--method": "--method 3",
        "--flange-frame": "--flange-frame 0 0 0.1 0 0 30",
        "--tool-frame": "--to abb | --tool-frame 0 0 0.1 0 0 30",
        "meters-per-unit": "--to usd | meters-per-unit=0.01",
        "--despite-verdict": "--despite-verdict",
    },
    "robot list": {},
    "robot show": ROBOT | VIEW | {
        "--base": "--base",
        "chain": "--robot six_axis.urdf | chain=link_2:",
        "--tool-frame": "--tool-frame 0,0,0.05,0,0,30",
        "--at": "--drawing a.svg | --at 10,20,30,40,50,60",
        "--drawing": "--drawing a.svg",
    },
    "robot new": {
        "--template": "--template",
        "--name": "--name other",
        "--joint": "--joint=x,0,0,0.4",
        "--flange": "--flange 0,0,0.7,z,x",
        "drawn-at": "drawn-at=0,90",
        "--limits": "--limits=-90:90,-80:80",
        "--mass": "--mass 20",
        "--rated-payload": "--rated-payload 3",
        "--out": "--out other.toml",
        "--drawing": "--drawing other.svg",
        "--overwrite": "--out six_axis.toml | --overwrite",
    },
    "robot check": ROBOT | LOGS | CURRENTS | FILTER | {
        "--data": "--data rx_near_unloaded.csv",
        "--report": "--report a.html",
        "--json": "--json a.json",
    },
    "robot export": ROBOT | {
        "--to": "--to sdf",
        "--robot": "--robot rx90",
        "--robot-parameters": "--robot rx90 | --robot-parameters earlier.json",
        "--into": "--into six_axis.urdf",
        "--despite-verdict": "--robot heavy.toml | --despite-verdict",
        "--out": "--out b.xml",
    },
    "codegen": ROBOT | {
        "--function": "--function regressor",
        "--language": "=--robot rx90 --out code | --language numpy",
        "--out": "--out other",
    },
    "design": ROBOT | STAND_IN | PAGE | LIMITS | MOTIONS | VIEW | {
        "--no-floor": f"={BRIEF.replace('rx90', 'tx40')} --via-points 4 | --no-floor",
        "--like": f"={BRIEF.split(' --torque')[0]} --via-points 4 --json b.json | --like earlier.json",
        "--via-points": "--via-points 5",
        "--fourier": f"={BRIEF} --fourier 2 --duration 3 | --fourier 3",
        "--segments": "--segments trapezoid",
        "ramp": "--segments trapezoid | ramp=0.4",
        "segment-durations": "segment-durations=2",
        "--rest": "--rest",
        "--duration": f"={BRIEF} --fourier 2 | --duration 3",
        "--max-duration": "--max-duration 2",
        "--start": "--start=0,-40,90,0,40,0",
        "--criterion": "--criterion cond",
        "--columns": "=--robot rx90 --via-points 4 --starts 1 | --columns ZZ1,XX2,MX2",
        "parameters": "parameters=M6,MZ6",
        "--data-from": f"={WHOLE} data-length=5 | --data-from earlier.json",
        "data-length": f"={WHOLE} --data-from earlier.json data-length=5 | data-length=50",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "--seed": "--seed 3",
        "--starts": "--starts 2",
        "bound": "bound=true",
        "--val3": "--segments trapezoid | --val3 val3",
    },
    "near": ROBOT | STAND_IN | PAGE | LIMITS | MOTIONS | VIEW | {
        "--no-floor": f"={NEAR.replace('rx90', 'tx40')} | --no-floor",
        "--like": f"={NEAR.split(' --torque')[0]} --json b.json | --like earlier.json",
        "--pose": "--pose=0,-45,90,0,60,0",
        "--second-pose": "--second-pose=0,-45,90,90,45,90",
        "--joints": "--joints 3,4,5,6",
        "--range": "--range 20",
        "--duration": "--duration 5",
        "--mass": "--mass 3+-0.1",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "--seed": "--seed 3",
        "starts": "starts=2",
        "rehearsal": "--samples a.csv | rehearsal=slow.csv",
        "--ladder": "--heaviest-payload 7@0,0,0.1 --within 0.1 | --ladder",
        "--static": f"={REST} | --static",
        "--poses": f"={REST} --static | --poses 7",
        "hold": f"={REST} --static | hold=2",
        "approach": f"={REST} --static | approach=2",
        "--val3": f"={REST} --static | --val3 val3",
    },
    "score": ROBOT | STAND_IN | PAGE | LIMITS | VIEW | {
        "--like": f"={SCORE.split(' --torque')[0]} --json b.json | --like earlier.json",
        "--data": f"=--robot rx90 {NOISE} | rx_arm.csv",
        "--log-map": f"={SCORE.replace('rx_arm', 'rx_arm_loaded')} | --log-map turned.toml",
        "--cutoff": f"={SCORE.replace('rx_arm', 'rx_arm_loaded')} | --cutoff 5",
        "--max-duration": "--max-duration 2",
        "--criterion": "--criterion cond",
        "--columns": "--columns ZZ1,XX2,MX2",
        "parameters": "parameters=M6,MZ6",
        "--data-from": "data-length=5 | --data-from earlier.json",
        "data-length": "data-length=5",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "bound": "bound=true",
        "seed": "bound=true seed=3",
        "--json": "--json a.json",
    },
    "simulate": ROBOT | STAND_IN | VIEW | {
        "--arm-mass": "=--robot ur10e --rate 50 --out out | --arm-mass 20",
        "--trajectory": "--trajectory rx_arm.csv",
        "--payload": "--payload box.toml",
        "--noise": "--noise none",
        "--friction": "--friction FL2=0.06,FR1=9",
        "gain-error": "gain-error=0.1",
        "--rate": "--rate 100",
        "--controller": "--controller gravity",
        "--sag": "--payload box.toml --controller proportional | --sag 4",
        "--seed": "--seed 7",
        "--out": "--out other",
    },
    "demo": PAGE | {
        "--json": "--json a.json",
        "--out": "--out other",
        "--seed": "--seed 1",
        "--trajectories": "--trajectories 4",
        "--noise": "--noise none",
        "gain-error": "gain-error=0.1",
    },
}  # fmt: skip
for _name, _entries in OPTIONS.items():
    if _name != "robot list":
        _entries |= {"--config": "--config loud.toml", "--quiet": "--quiet", "verbose": "verbose=true"}
    if _name == "demo" or "--json" in _entries:
        _entries["--details"] = "--details"

OF_ALL = ("--config", "verbose")
"""Options that are read and obeyed before any command: one command is asked."""
TEXTS_ASKED_FOR = ("export", "robot show")
"""Commands whose printed text is the answer itself, which ``--quiet`` leaves as it is."""
VARYING = re.compile(rb'"cpu_s": [0-9.e-]+')
"""Parts that differ from one run to the next."""


def outcome(inputs: Path, line: str) -> dict[str, bytes]:
    """All that a line prints and writes, in a folder of its own that holds all inputs."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        shutil.copytree(inputs, name, dirs_exist_ok=True)
        ended = typed(line)
        files = {str(path.relative_to(name)): path.read_bytes() for path in Path(name).rglob("*") if path.is_file()}
    return {name: VARYING.sub(b"", content) for name, content in (files | {"": repr(ended).encode()}).items()}


def test_no_option_is_without_an_entry() -> None:
    assert {name: sorted(options(name)) for name in NAMES} == {
        name: sorted(entries) for name, entries in OPTIONS.items()
    }
    assert all({"--quiet", "verbose", "--config"} <= entries.keys() for entries in OPTIONS.values() if entries)


def test_a_setting_is_refused_where_it_is_typed() -> None:
    keys = {key: command for command in NAMES for key in options(command) if not key.startswith("--")}
    for key, command in keys.items():
        assert f"{key} is a setting, not an option" in refused(command, f"--{key}=1")


def differing(folder: Path, name: str, entry: str, bases: dict[str, dict[str, bytes]]) -> bool:
    """True where a line with an option gives anything else than the line without it."""
    needs, _, more = entry.rpartition("|")
    line = needs.strip().removeprefix("=") if needs.startswith("=") else f"{LINES[name]} {needs}"
    if line not in bases:
        bases[line] = outcome(folder, f"{name} {line}")
    return outcome(folder, f"{name} {line} {more}") != bases[line]


@pytest.mark.long
@pytest.mark.usefixtures("hasty", "drawn_empty")
@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_changes_something_or_is_refused(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Figures are empty: each shows what stands in numbers beside it; causes are searched in a few states."""
    for constant, few in {"_LONGEST": 5, "_ENOUGH": 300}.items():
        monkeypatch.setattr(causes, constant, few)
    monkeypatch.setattr(causes, "robot_names", lambda: ("rx90", "tx40"))
    line = f"{name} {LINES[name]}"
    bases = {LINES[name]: outcome(folder, line)}
    assert outcome(folder, line) == bases[LINES[name]], "a line gives the same twice"
    asked = {option: entry for option, entry in OPTIONS[name].items() if name == "check" or option not in OF_ALL}
    ignored = [option for option, entry in asked.items() if not differing(folder, name, entry, bases)]
    assert ignored == (["--quiet"] if name in TEXTS_ASKED_FOR else [])


@pytest.mark.parametrize("command", NAMES)
def test_the_default_that_the_help_names_is_the_default(command: str) -> None:
    for argument in arguments(command):
        named = re.search(r"\(default: (-?[\d.]+)[;,)]", " ".join((argument.parameter.help or "").split()))
        default, *_ = [*numbers(argument.field_info.default), None]
        assert named is None or default in (None, float(named[1])), argument.name


ODD_NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e300", "5e-324", "1e-300", "9" * 5000)
SPEAKS_TO_TERMINALS = "\x1b[31m\x9b2J\u202e\udcff"
"""Colours, clears the screen, turns the direction of writing, and a byte that is no letter."""


def numbers(value: Any) -> Iterator[float]:
    """All numbers in what an option's words became."""
    if isinstance(value, tuple | list):
        for part in value:
            yield from numbers(part)
    elif isinstance(value, int | float):
        yield value


@pytest.mark.parametrize("command", NAMES)
def test_no_option_takes_a_number_that_no_arm_has(command: str) -> None:
    """Refused, or read as a text; squares of what is taken are finite, and not lost beside others."""
    texts = [text for odd in ODD_NUMBERS for text in (odd, f"{odd}%", f"1,{odd}", ",".join(6 * [odd]))]
    for argument in arguments(command):
        read: Any = argument.parameter.converter
        for text in texts if read else ():
            with contextlib.suppress(ValueError):
                values = list(numbers(read(None, (Token(value=text),))))
                assert all(x == 0.0 or 1e-14 <= abs(x) <= 1e9 for x in values), (argument.name, text)


@pytest.mark.parametrize("command", NAMES)
def test_a_wrong_word_is_shown_in_one_line(command: str) -> None:
    for odd in (SPEAKS_TO_TERMINALS, "x\ny", "9" * 5000):
        for option in ("--config", "--quiet"):
            line = refused(command, f"{option}={odd}")
            assert line.isprintable()
            assert len(line) < 1200
