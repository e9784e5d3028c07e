"""``dynident robot`` and how an arm is mounted, on the command line."""

import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from dynident.apps.report.figures.motion import outline
from dynident.apps.report.recordings import write_recording
from dynident.common.arrays import Array
from dynident.model import (
    InertialParameters,
    Pose,
    Recording,
    load_robot,
    mounted,
    robot_names,
    with_tool,
)
from dynident.tests.commands.runs import Run
from dynident.tests.model.urdf_files import dressed_urdf
from dynident.trajectories import Simulator, random_via_points

NEW = [
    "robot", "new", "--name", "kr", "--joint=-z,0,0,0.4", "--joint", "y,0.025,0,0.4", "--joint", "y,0.025,0,0.855",
    "--joint=-x,0.025,0,0.89", "--joint", "y,0.445,0,0.89", "--joint=-x,0.525,0,0.89",
    "--flange", "0.525,0,0.89,x,-z", "--drawn-at", "0,-90,90,0,0,0",
    "--limits=-170:170:360,-190:45:300,-120:156:360,-185:185:381,-120:120:388,-350:350:615",
    "--rated-payload", "6",
]  # fmt: skip
LOAD = InertialParameters.from_com(5.0, [0.02, 0.01, 0.1], np.diag([0.03, 0.025, 0.02]))


def test_list(run: Run) -> None:
    status, text, _ = run("robot", "list")
    assert status == 0
    assert [line.split()[0] for line in text.splitlines()] == list(robot_names())
    assert "KUKA KR 6 R900 sixx" in text


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_show_and_draw(run: Run, tmp_path: Path, ending: str) -> None:
    """An arm gives the same bytes each time."""
    paths = [tmp_path / f"{k}.{ending}" for k in (1, 2)]
    for path in paths:
        status, text, _ = run(
            "robot", "show", "--robot", "kr6_r900", "--drawing", str(path), "--at", "0,-90,90,0,0,0"
        )
        assert status == 0
    assert "(0.98, 0, 0.435) m in the base" in text
    assert "Rated payload: 6 kg." in text
    assert "the bare flange" in text
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_outline_ends_in_the_flange() -> None:
    """Corners in the known home pose: base, shoulder, elbow, wrist, flange."""
    corners = outline(load_robot("kr6_r900"), np.radians([0, -90, 90, 0, 0, 0]).tolist())
    for corner in ((0, 0, 0), (0, 0, 0.4), (0.025, 0, 0.4), (0.025, 0, 0.855), (0.025, 0, 0.89), (0.445, 0, 0.89)):
        assert np.abs(corners - np.array(corner)).max(axis=1).min() < 1e-12
    np.testing.assert_allclose(corners[-1], [0.525, 0.0, 0.89], atol=1e-12)
    assert len(corners) == 2 * 6 + 3


def test_new_robot_is_the_shipped_one(run: Run, tmp_path: Path) -> None:
    """Described in the home pose of the sheet, it is the arm that was read from a description at zero."""
    out = tmp_path / "kr.toml"
    status, text, _ = run(*NEW, "--out", str(out))
    assert status == 0
    assert "Compare the drawing" in text
    ElementTree.parse(out.with_suffix(".svg"))
    robot, shipped = load_robot(out), load_robot("kr6_r900")
    assert robot.rated_payload == 6.0
    np.testing.assert_allclose(robot.flange.R, shipped.flange.R, atol=1e-12)
    for ours, theirs in zip(robot.joints, shipped.joints, strict=True):
        assert (ours.alpha, ours.theta, ours.d, ours.r) == pytest.approx(
            (theirs.alpha, theirs.theta, theirs.d, theirs.r), abs=1e-12
        )
        assert ours.limits.position == pytest.approx(theirs.limits.position, abs=1e-12)
        assert ours.limits.speed == pytest.approx(theirs.limits.speed)
    status, _, error = run(*NEW, "--out", str(out))
    assert status == 2
    assert "is there already" in error
    assert run(*NEW, "--out", str(out), "--overwrite")[0] == 0


def test_a_scara(run: Run, tmp_path: Path) -> None:
    """A joint that slides; what is not known stays unknown."""
    out = tmp_path / "scara.toml"
    joints = ("--joint=z,0,0,0.3", "--joint=z,0.4,0,0.3", "--joint=-z,0.7,0,0.3,slide", "--joint=z,0.7,0,0.3")
    limits = ("--limits=-130:130,-150:150,0:0.2::3:500,-360:360", "--rated-payload", "3")
    line = ("robot", "new", "--name", "scara", *joints, "--flange", "0.7,0,0.2,-z,x", *limits)
    status, _, error = run(*line, "--out", str(out), "--drawing", str(tmp_path / "s.png"))
    assert status == 0, error
    robot = load_robot(out)
    assert [joint.kind for joint in robot.joints] == ["revolute", "revolute", "prismatic", "revolute"]
    assert robot.joints[2].limits.position == (0.0, 0.2)
    assert (robot.joints[2].limits.acceleration, robot.joints[2].limits.torque) == (3.0, 500.0)
    assert (robot.rated_payload, robot.mass, robot.joint_names) == (3.0, None, ())
    unknown = [joint.limits for joint in robot.joints if joint.revolute]
    assert np.isinf([[limit.speed, limit.acceleration, limit.torque] for limit in unknown]).all()
    assert "mass_kg" in error
    corners: Array = outline(robot, [0.0, 0.0, 0.1, 0.0])
    np.testing.assert_allclose(corners[-1], [0.7, 0.0, 0.1], atol=1e-12)


TEMPLATE = ("robot", "new", "--template")


def test_the_template_loads_as_it_stands(run: Run, tmp_path: Path) -> None:
    """Printed or written, it is a robot, and options beside it are refused."""
    out = tmp_path / "arm.toml"
    status, text, _ = run(*TEMPLATE)
    assert (status, run(*TEMPLATE, "--out", str(out))[0]) == (0, 0)
    assert out.read_text(encoding="utf-8") == text
    robot = load_robot(out)
    assert (robot.name, robot.n, robot.joints[2].kind, robot.rated_payload) == ("my_arm", 3, "prismatic", 5.0)
    assert run("robot", "show", "--robot", str(out))[0] == 0
    assert "is there already" in run(*TEMPLATE, "--out", str(out))[2]
    status, _, error = run(*TEMPLATE, "--name", "kr")
    assert (status, "--name belongs to a robot by options" in error) == (2, True)


def without(option: str) -> list[str]:
    k = NEW.index(option)
    return [*NEW[:k], *NEW[k + 2 :]]


BAD = {
    "no flange": (without("--flange"), "give --flange"),
    "axis": ([*NEW, "--joint", "w,0,0,0"], "--joint: 'w,0,0,0' is not AXIS,X,Y,Z"),
    "point": ([*NEW, "--joint", "x,0,0"], "AXIS,X,Y,Z"),
    "no direction": ([*NEW, "--joint", "0:0:0,0,0,0"], "direction"),
    "skew flange": ([*without("--flange"), "--flange", "0,0,0,x,1:1:0"], "two directions at right angles"),
    "limits": ([*NEW, "--limits", "1:2"], "--limits has 1 parts for 6 joints"),
    "empty range": ([*NEW, "--limits", ",".join(["2:1"] * 6)], "--limits of joint 1"),
    "speed": ([*NEW, "--limits", "1:2:fast"], "'fast' is not a number"),
    "too many": ([*NEW, "--limits", "1:2:3:4:5:6"], "is not LOW:HIGH[:SPEED"),
    "drawn at": ([*NEW, "--drawn-at", "1,2"], "--drawn-at has 2 parts for 6 joints"),
    "mass": ([*NEW, "--mass", "0"], "mass must be positive"),
    "mass of no use": (
        ["design", "--robot", "rx90", "--arm-mass", "50", "--via-points", "4"],
        "--arm-mass has no effect",
    ),
    "payload": ([*NEW, "--rated-payload", "-1"], "rated payload must be positive"),
    "drawing": ([*NEW, "--drawing", "x.gif"], "ends in .png, .svg or .pdf"),
    "no robot": (["robot", "show", "--robot", "kr7"], "no robot 'kr7'"),
    "at": (["robot", "show", "--robot", "panda", "--at", "1,2"], "--at has 2 numbers, panda has 7 joints"),
    "base of no URDF": (["robot", "show", "--robot", "panda", "--chain", ":x"], "links of a URDF"),
    "gravity": (["robot", "show", "--robot", "panda", "--mount", "gravity=0,9"], "not 3 finite numbers"),
    "mount": (["robot", "show", "--robot", "panda", "--mount", "table"], "'table' is not 3 finite numbers"),
    "tool": (["robot", "show", "--robot", "panda", "--tool-frame", "1,2,3"], "not 6 finite numbers"),
    "no bodies": (
        ["robot", "export", "--to", "urdf", "--robot", "panda", "--out", "x.urdf"],
        "bodies need all ten",
    ),
}


@pytest.mark.parametrize(("arguments", "problem"), BAD.values(), ids=BAD.keys())
def test_what_cannot_be_used(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], problem: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, error = run(*arguments)
    assert status == 2
    assert problem in error
    assert error.count("\n") == 1
    assert not list(tmp_path.glob("*.svg"))


def write_csv(path: Path, recording: Recording, sign: Array) -> Path:
    write_recording(path, replace(recording, q=recording.q * sign, torque=recording.torque * sign))
    return path


def test_check_suggests_and_does_not_apply(run: Run, tmp_path: Path) -> None:
    robot = load_robot("rx90")
    log = Simulator(robot).record(random_via_points(robot, 8, seed=5).motion(100.0), None, [0.5] * 6, 1)
    path = write_csv(tmp_path / "turned.csv", log, np.array([1, 1, -1, 1, 1, 1]))
    options = ("--robot", "rx90")
    out = tmp_path / "c.json"
    status, text, _ = run("robot", "check", *options, "--data", str(path), "--json", str(out))
    assert status == 1
    assert "Suggested, not applied: joint 3 turned round (position and torque)" in text
    document = json.loads(out.read_text())
    assert document["suggested"].startswith("joint 3 turned round")
    assert document["ranked"][0]["sign"] == [1, 1, -1, 1, 1, 1]


@pytest.mark.long
def test_payload_on_a_wall_in_a_tool_frame(run: Run, tmp_path: Path) -> None:
    """From a URDF on the wall, the answer stands in the tool frame that is asked for, and says so."""
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(load_robot("irb120"), seed=1, limits=False), encoding="utf-8")
    robot = mounted(load_robot(path), (0.0, np.pi / 2, 0.0))
    tool = Pose.from_rpy((0.0, 0.0, 0.1), (0.0, 0.0, np.pi / 2))
    values = dict(robot.parameters)
    for j in range(1, 7):
        values |= {f"IA{j}": 0.5, f"FS{j}": 2.0, f"FV{j}": 3.0}
    simulator = Simulator(with_tool(replace(robot, parameters=values), tool, "tool"))
    motion = random_via_points(load_robot("irb120"), 10, seed=3).motion(100.0)
    files = []
    for name, load in (("bare", None), ("loaded", LOAD)):
        files.append(write_csv(tmp_path / f"{name}.csv", simulator.record(motion, load, [0.05] * 6, 3), np.ones(6)))
    out = tmp_path / "p.json"
    status, text, error = run(
        "payload", "--robot", str(path), "--mount", "wall", "--tool-frame", "0,0,0.1,0,0,90", "--method", "3",
        "--unloaded", str(files[0]), "--loaded", str(files[1]), "--json", str(out),
    )  # fmt: skip
    assert status in (0, 1), error
    document = json.loads(out.read_text())
    assert document["frame"] == "tool frame (0, 0, 0.1 m; rpy 0, 0, 90 deg) in: flange: link tool0 of arm.urdf"
    assert "tool frame (0, 0, 0.1 m" in " ".join(text.split())
    estimate = document["estimates"][0]
    assert estimate["parameters"]["M"] == pytest.approx(5.0, rel=0.01)
    np.testing.assert_allclose(estimate["com"], LOAD.com, atol=3e-3)
