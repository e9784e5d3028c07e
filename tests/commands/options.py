"""A line for each command, and for each of its options what is to be added for it to count.

In front of ``|`` stand words that the option needs, which are given without it too; after ``=`` they stand in place
of the command's line. An option without an entry fails the law of ``test_options.py``: a new one is added here,
with a value that must change something.
"""

import json
import os
from pathlib import Path

import numpy as np
from dynident import fleet
from dynident.common.files import checksum
from dynident.estimation import identify, read_recording
from dynident.estimation.fit import weighted
from dynident.model import load_robot

ROBOT = {
    "--robot": "--robot tx40",
    "--base": "--base link_1",
    "--tip": "--tip link_2",
    "--mount": "--mount wall",
    "--gravity": "--gravity=1,0,-9.7",
}
STAND_IN = {"--arm-mass": "--arm-mass 20"}
LOGS = {
    "--log-map": "--log-map turned.toml",
    "--joints": "--joints a,b,c,d,e,f",
    "--units": "--units q=deg",
    "--signs": "--signs=1,-1,1,1,1,1",
    "--topic": "--topic /joint_states",
}
PROCESSING = {
    "--rate": "--rate 90",
    "--cutoff": "--cutoff 4",
    "--equation-rate": "--equation-rate 15",
    "--decimate": "--decimate 7",
    "--offsets": "--no-offsets | --offsets",
    "--no-offsets": "--offsets | --no-offsets",
    "--coulomb": "--coulomb paper",
}
_FILTER = {option: entry for option, entry in PROCESSING.items() if option not in ("--decimate", "--equation-rate")}
KNOWN = {
    "--mass": "--mass-sigma 0.05 --mass 6.2 | --mass 6.4",
    "--mass-sigma": "--mass 6.2 --mass-sigma 0.05 | --mass-sigma 0.5",
    "--mass-min": "--mass-min 6.5",
    "--mass-max": "--mass-max 6",
    "--com-within": "--com-within=0.02,0.03,0,0.01,0.1,0.2",
    "--ellipsoid": "--ellipsoid=0,0,0.1,0.1,0.1,0.1",
}
LINKS = {name: ROBOT[name] for name in ("--robot", "--base", "--tip")}
GAINS = {"--gain-sigma": "--gain-sigma 2%", "--gain-sigma-common": "--gain-sigma-common 1%"}
STOPS = {"--essential-ratio": "--essential-ratio 1.2", "--essential-sigma": "--essential-sigma 10%"}
TABLES = {"--json": "--json a.json", "--csv": "--csv a.csv", "--latex": "--latex a.tex", "--npz": "--npz a.npz"}
PASSPORT = {"--passport": "--passport a.npz"}
PAGE = {"--report": "--report a.html", "--plots": "--plots figures"}
VIEW = {"--view": "--view a.html", "--show": "--show"}
LIMITS = {
    "--speed-override": "--speed-override 0.5",
    "--acceleration": "--acceleration 2x",
    "--torque-limits": "--torque-limits 300,300,120,50,40,20",
    "--robot-parameters": "--robot-parameters tx_robot.json",
    "--scene": "--scene scene.toml",
    "--heaviest-payload": "--heaviest-payload 7@0,0,0.2",
    "--within": "--heaviest-payload 2@0,0,0.1 | --within 0.1",
    "--torque-margin": "--torque-margin 5%",
}
MOTIONS = {
    "--json": "--json a.json",
    "--samples": "--samples a.csv",
    "--ros2": "--ros2 a.yaml",
    "--joint-names": "--ros2 a.yaml | --joint-names a,b,c,d,e,f",
    "--urscript": "--urscript a.script",
    "--controller-rate": "--urscript a.script | --controller-rate 125",
    "--sample-rate": "--samples a.csv | --sample-rate 125",
}
_CURRENTS = {"--drive-gains": "--drive-gains 1,2,3,4,5,6"}
_AMPERES = "--unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv"
_PAIR = "--unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv"

_NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3 --json b.json"
_BRIEF = f"--robot rx90 --payload-only --starts 1 --seed 2 {_NOISE}"
_WHOLE = f"--robot rx90 --via-points 4 --starts 1 {_NOISE}"
_SCALE = "--mass 6 --mass-sigma 0.1"
_NEAR = f"--robot rx90 --pose=0,-45,90,0,45,0 --joints 4,5,6 {_SCALE} --duration 4 {_NOISE}"
_SCORE = f"rx_arm.csv --robot rx90 {_NOISE}"

PORTS = {"port": 20000 + os.getpid() % 10000, "script_port": 30010 + os.getpid() % 10000}
"""Of the controller that is played while lines run: others for each process that tests."""
_PLAYED = f"--host 127.0.0.1 --port {PORTS['port']}"
HOST = {"--host": "--host 127.0.0.1.1", "--port": "--port 1"}


def put_payloads(folder: Path) -> None:
    """Two payloads in the flange's frame: one to use, and one that its verdict refuses."""
    document = json.loads((folder / "rx_payload.json").read_text())
    document["frame"] = "tool0: the bare flange"
    for name, level in (("flange", "use"), ("refused", "do_not_use")):
        document["verdict"]["level"] = level
        (folder / f"{name}.json").write_text(json.dumps(document))


LINES = {
    "weigh": "--robot rx90 --unloaded rx_near_unloaded.csv --loaded rx_near_loaded.csv --json b.json",
    "verify": "--robot rx90 --before before.csv --after after.csv",
    "payload": f"--robot rx90 {_PAIR} --method 3 --json b.json",
    "identify": "--robot rx90 --data rx_arm_unloaded.csv --json b.json",
    "rollout": "--robot rx90 --robot-parameters earlier.json --data rx_arm_loaded.csv --json b.json",
    "gains": f"--robot ur10e {_AMPERES} --mass 6.2 --decimate 4 --json b.json",
    "apply": f"flange.json --to ur --yes {_PLAYED} --script-port {PORTS['script_port']}",
    "record": f"ur {_PLAYED} --seconds 0.1 --out b.csv",
    "fleet reduce": "first.csv --robot rx90 --store store --json b.json",
    "fleet report": "nightly --json b.json",
    "fleet simulate": "six_axis.toml --arms 2 --days 2 --rate 50 --points 4 --out out",
    "compare": "first.csv second.csv --robot rx90 --json b.json",
    "passport show": "first.npz --json b.json",
    "passport merge": "first.npz second.npz --out merged.npz",
    "passport compare": "first.npz second.npz --json b.json",
    "check": "--robot rx90 --json b.json rx_arm_unloaded.csv",
    "export": "rx_payload.json --to ur --flange-frame 0 0 0 0 0 0",
    "robot list": "",
    "robot show": "--robot rx90",
    "robot new": "--name arm --joint=z,0,0,0 --joint=y,0,0,0.3 --flange 0,0,0.6,z,x",
    "robot check": "--robot rx90 --data rx_arm_unloaded.csv --json b.json",
    **{f"robot {name}": f"--robot six_axis.toml --out a.{name}" for name in ("mjcf", "usd", "urdf", "sdf")},
    "codegen": "--robot rx90 --function base_regressor --out code",
    "design": f"{_BRIEF} --via-points 4",
    "near": _NEAR,
    "score": _SCORE,
    "simulate": "--robot rx90 --trajectory rx_short.csv --rate 50 --out out",
    "demo": "--trajectories 3 --out out",
}

OPTIONS: dict[str, dict[str, str]] = {
    "weigh": ROBOT | LOGS | _CURRENTS | PROCESSING | KNOWN | GAINS | PAGE | VIEW | PASSPORT | {
        "--json": "--json a.json",
        "--loaded": "--loaded rx_arm_loaded.csv",
        "--unloaded": "--unloaded rx_arm_unloaded.csv",
        "--robot-parameters": "--robot-parameters tx_robot.json",
        "--moving": "--moving 2,3,5",
        "--friction-change": "--friction-change 5%",
        "--inertia": "--inertia box:200x200x100",
        "--max-mismatch": "--max-mismatch 1e-9",
        "--live": "--live ur",
        "--replay": "--replay rx_near_loaded.csv",
        "--until": "=--robot rx90 --robot-parameters earlier.json --replay rx_arm_loaded.csv | --until 9kg",
        "--watch": "--watch a.jsonl",
        **HOST,
    },
    "verify": LINKS | LOGS | _CURRENTS | PAGE | {
        "--robot": "--robot panda",
        "--log-map": "--log-map degrees.toml",
        "--signs": "--signs=1,-1",
        "--before": "--before after.csv",
        "--after": "--after before.csv",
        "--json": "--json a.json",
    },
    "payload": ROBOT | LOGS | _CURRENTS | PROCESSING | KNOWN | GAINS | STOPS | TABLES | PAGE | VIEW | PASSPORT | {
        "--tool-frame": "--tool-frame 0,0,0.05,0,0,30",
        "--unloaded": "--unloaded rx_near_unloaded.csv",
        "--loaded": "--loaded rx_near_loaded.csv",
        "--robot-parameters": "--robot-parameters tx_robot.json",
        "--method": "--method 4",
        "--free-friction": "--method 1 | --free-friction",
        "--scale-sigma": "--method 4 | --scale-sigma 2%",
        "--friction-change": "--method 4 | --friction-change 30%",
        "--max-mismatch": "--max-mismatch 1e-9",
        "--validate": "--validate rx_near_unloaded.csv",
    },
    "identify": ROBOT | LOGS | _CURRENTS | PROCESSING | GAINS | STOPS | TABLES | PAGE | PASSPORT | {
        "--data": "--data rx_near_unloaded.csv",
        "--validate": "--validate rx_near_unloaded.csv",
        "--constrained": "--constrained none",
        "--prior-mass": "--constrained prior | --prior-mass 40",
        "--prior-budget": "--constrained prior | --prior-budget 4",
        "--total-mass": "--total-mass 20 60",
        "--rollout": "--validate rx_near_unloaded.csv | --rollout",
    },
    "rollout": ROBOT | LOGS | _CURRENTS | _FILTER | PAGE | {
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
        "--mass-sigma": "--mass-sigma 0.1",
        "--mounting": "--unloaded ur_again_unloaded.csv --loaded ur_again_loaded.csv | --mounting 1,2",
        "--json": "--json a.json",
    },
    "apply": HOST | {
        "payload": "tx_robot.json",
        "--to": "--to ur10",
        "--yes": "=flange.json --to ur --host 127.0.0.1 | --yes",
        "--despite-verdict": "=refused.json --to ur --host 127.0.0.1 | --despite-verdict",
        "--script-port": "--script-port 1",
    },
    "record": HOST | {
        "maker": "ur",
        "--seconds": "--seconds 0.2",
        "--rate": "--rate 25",
        "--out": "--out a.csv",
    },
    "fleet reduce": ROBOT | LOGS | _CURRENTS | PROCESSING | GAINS | {
        "logs": "second.csv",
        "--store": "--store other",
        "--table": "--table robots.csv",
        "--pattern": "--pattern {arm}.csv",
        "--workers": "--workers 0",
        "--scheduler": "--scheduler tcp://127.0.0.1:1",
        "--batch": "--batch 2",
        "--json": "--json a.json",
    },
    "fleet report": PAGE | {
        "store": "=--json b.json | nightly",
        "--false-alarms": "--false-alarms 0.1",
        "--parquet": "--parquet tables",
        "--json": "--json a.json",
    },
    "fleet simulate": {
        "robots": "rx90",
        "--out": "--out other",
        "--equations": "--equations",
        "--arms": "--arms 3",
        "--days": "--days 3",
        "--first": "--first 2026-02-01",
        "--coulomb": "--coulomb 5%",
        "--viscous": "--viscous 5%",
        "--memory": "--memory 0.2",
        "--per-kelvin": "--per-kelvin 2%",
        "--apart": "--apart 10%",
        "--worn": "--worn 0",
        "--wear": "--wear 20%",
        "--laden": "--laden 0",
        "--load": "--load 2",
        "--replaced": "--laden 0 | --replaced 1",
        "--missing": "--missing 60%",
        "--damaged": "--damaged 60%",
        "--noise": "--noise 0.1",
        "--points": "--points 5",
        "--rate": "--rate 60",
        "--seed": "--seed 1",
    },
    "compare": ROBOT | LOGS | _CURRENTS | PROCESSING | {"logs": "third.csv", "--json": "--json a.json"},
    "passport show": {"file": "=--json b.json | second.npz", "--json": "--json a.json"},
    "passport merge": {
        "files": "third.npz",
        "--out": "--out other.npz",
        "--json": "--json a.json",
    },
    "passport compare": {"files": "third.npz", "--json": "--json a.json"},
    "check": ROBOT | LOGS | _CURRENTS | PROCESSING | PAGE | {
        "logs": "rx_near_unloaded.csv",
        "--data": "--data rx_near_unloaded.csv",
        "--json": "--json a.json",
    },
    "export": {
        "payload": "tx_robot.json",
        "--to": "--to kuka",
        "--out": "--out a.txt",
        "--method": "--method 3",
        "--flange-frame": "--flange-frame 0 0 0.1 0 0 30",
        "--tool-frame": "--to abb | --tool-frame 0 0 0.1 0 0 30",
        "--meters-per-unit": "--to usd | --meters-per-unit 0.01",
        "--despite-verdict": "--despite-verdict",
    },
    "robot list": {},
    "robot show": ROBOT | VIEW | {
        "--tip": "--robot six_axis.urdf | --tip link_3",
        "--base": "--robot six_axis.urdf | --base link_2",
        "--tool-frame": "--tool-frame 0,0,0.05,0,0,30",
        "--at": "--drawing a.svg | --at 10,20,30,40,50,60",
        "--drawing": "--drawing a.svg",
    },
    "robot new": {
        "--name": "--name other",
        "--title": "--title Other",
        "--joint": "--joint=x,0,0,0.4",
        "--flange": "--flange 0,0,0.7,z,x",
        "--drawn-at": "--drawn-at 0,90",
        "--limits": "--limits=-90:90,-80:80",
        "--speeds": "--speeds 100,90",
        "--torques": "--torques 30,20",
        "--accelerations": "--accelerations 300,200",
        "--mass": "--mass 20",
        "--joint-names": "--joint-names a,b",
        "--rated-payload": "--rated-payload 3",
        "--side": "--side link",
        "--source": "--source drawing",
        "--out": "--out other.toml",
        "--drawing": "--drawing other.svg",
        "--overwrite": "--out six_axis.toml | --overwrite",
    },
    "robot check": ROBOT | LOGS | _CURRENTS | _FILTER | {
        "--data": "--data rx_near_unloaded.csv",
        "--report": "--report a.html",
        "--json": "--json a.json",
    },
    **dict.fromkeys(("robot mjcf", "robot usd", "robot urdf", "robot sdf"), ROBOT | {
        "--robot": "--robot rx90",
        "--robot-parameters": "--robot rx90 | --robot-parameters earlier.json",
        "--passport": "--robot rx90 | --passport first.npz",
        "--prior-mass": "--robot rx90 --passport first.npz | --prior-mass 40",
        "--into": "--into six_axis.urdf",
                "--gauge": "--gauge prior",
        "--despite-verdict": "--robot heavy.toml | --despite-verdict",
        "--out": "--out b.xml",
    }),
    "codegen": ROBOT | {"--function": "--function regressor", "--out": "--out other"},
    "design": ROBOT | STAND_IN | PAGE | LIMITS | MOTIONS | VIEW | {
        "--via-points": "--via-points 5",
        "--fourier": f"={_BRIEF} --fourier 2 --duration 3 | --fourier 3",
        "--segments": "--segments trapezoid",
        "--ramp": "--segments trapezoid | --ramp 0.4",
        "--segment-durations": "--segment-durations 2",
        "--rest": "--rest",
        "--duration": f"={_BRIEF} --fourier 2 | --duration 3",
        "--max-duration": "--max-duration 2",
        "--start": "--start=0,-40,90,0,40,0",
        "--criterion": "--criterion cond",
        "--columns": "=--robot rx90 --via-points 4 --starts 1 | --columns ZZ1,XX2,MX2",
        "--parameters": "--parameters M6,MZ6",
        "--payload-only": f"={_WHOLE} | --payload-only",
        "--data-from": f"={_WHOLE} --data-length 5 | --data-from earlier.json",
        "--data-length": f"={_WHOLE} --data-from earlier.json --data-length 5 | --data-length 50",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "--independent-rate": "--independent-rate 50",
        "--seed": "--seed 3",
        "--starts": "--starts 2",
        "--bound": "--bound",
        "--val3": "--segments trapezoid | --val3 val3",
    },
    "near": ROBOT | STAND_IN | PAGE | LIMITS | MOTIONS | VIEW | {
        "--pose": "--pose=0,-45,90,0,60,0",
        "--second-pose": "--second-pose=0,-45,90,90,45,90",
        "--joints": "--joints 3,4,5,6",
        "--range": "--range 20",
        "--duration": "--duration 5",
        "--mass": "--mass 3",
        "--mass-sigma": "--mass-sigma 1",
        "--expected-mass": f"={_NEAR.replace(_SCALE, '--joints 2,3,5,6')} | --expected-mass 5",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "--independent-rate": "--independent-rate 50",
        "--seed": "--seed 3",
        "--starts": "--starts 2",
        "--rehearsal": "--samples a.csv | --rehearsal slow.csv",
        "--ladder": "--heaviest-payload 7@0,0,0.1 --within 0.1 | --ladder",
    },
    "score": ROBOT | STAND_IN | PAGE | LIMITS | VIEW | {
        "log": f"=--robot rx90 {_NOISE} | rx_arm.csv",
        "--log-map": f"={_SCORE.replace('rx_arm', 'rx_arm_loaded')} | --log-map turned.toml",
        "--cutoff": f"={_SCORE.replace('rx_arm', 'rx_arm_loaded')} | --cutoff 5",
        "--max-duration": "--max-duration 2",
        "--criterion": "--criterion cond",
        "--columns": "--columns ZZ1,XX2,MX2",
        "--parameters": "--parameters M6,MZ6",
        "--payload-only": "--payload-only",
        "--data-from": "--data-length 5 | --data-from earlier.json",
        "--data-length": "--data-length 5",
        "--torque-noise": "--torque-noise 1,2,3,4,5,6",
        "--independent-rate": "--independent-rate 50",
        "--bound": "--bound",
        "--seed": "--bound | --seed 3",
        "--json": "--json a.json",
    },
    "simulate": ROBOT | STAND_IN | VIEW | {
        "--arm-mass": "=--robot ur10e --rate 50 --out out | --arm-mass 20",
        "--trajectory": "--trajectory rx_arm.csv",
        "--payload": "--payload box.toml",
        "--noise": "--noise none",
        "--gain-error": "--gain-error 0.1",
        "--rate": "--rate 100",
        "--controller": "--controller gravity",
        "--sag": "--payload box.toml --controller proportional | --sag 4",
        "--seed": "--seed 7",
        "--out": "--out other",
    },
    "demo": PAGE | {
        "--out": "--out other",
        "--seed": "--seed 1",
        "--trajectories": "--trajectories 4",
        "--noise": "--noise none",
        "--gain-error": "--gain-error 0.1",
    },
}  # fmt: skip
for _name, _entries in OPTIONS.items():
    _entries |= {"--config": "--config loud.toml", "--quiet": "--quiet", "--verbose": "--verbose"}
    if _name == "demo" or ("--json" in _entries and _name != "passport merge"):
        _entries["--details"] = "--details"


def make_passports(folder: Path) -> None:
    """Three passports of one robot: of a recording, of it with other noise, and with still other noise."""
    robot, rows = load_robot("rx90"), np.loadtxt(folder / "rx_arm_unloaded.csv", delimiter=",", skiprows=1)
    header = (folder / "rx_arm_unloaded.csv").read_text().partition("\n")[0]
    (folder / "robots.csv").write_text("file,arm\nfirst.csv,left\n")
    for seed, name in enumerate(("first", "second", "third")):
        noise = np.random.default_rng(seed).normal(scale=0.3, size=(len(rows), 6))
        np.savetxt(
            folder / f"{name}.csv", rows + np.pad(noise, ((0, 0), (rows.shape[1] - 6, 0))), delimiter=",",
            header=header, comments="", fmt="%.9g",
        )  # fmt: skip
        log = fleet.Log("without payload", f"{name}.csv", checksum(folder / f"{name}.csv"))
        result = identify(robot, [read_recording(folder / f"{name}.csv", robot)])
        passport = fleet.robot_passport(result, fleet.Recipe("identify", robot.processing), [log])
        fleet.write_passport(folder / f"{name}.npz", passport)
    make_store(folder, passport)


def make_store(folder: Path, passport: fleet.RobotPassport) -> None:
    """A store of two arms and three nights, drawn on a passport's motion."""
    store, draw = fleet.Store.made(folder / "nightly", passport.robot, passport.recipe), np.random.default_rng(0)
    values, rows = weighted(passport.equations).values, {}
    for arm in ("left", "right"):
        for night in range(1, 4):
            about, name = {"arm": arm, "day": f"2026-01-0{night}"}, f"{arm}{night}.csv"
            night_passport = fleet.drawing.drawn(
                passport, values, fleet.drawing.noise_of(passport), draw, name, about
            )
            rows[name] = fleet.store.Row(name, night_passport.logs[0].sha256, about, f"{arm}{night}")
            store.put(f"{arm}{night}", fleet.passport_bytes(night_passport))
    store.finish(rows, {})
