"""``dynident robot check`` where a log carries the pose of the tool."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import ToolColumns, read_tool_poses
from dynident.apps.logs.map import LogMap, read_log_map
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.diagnosis.kinematics import ToolPoses, check_pose
from dynident.model import Pose, Recording, Robot, load_robot
from dynident.model.frames import frames_at
from dynident.tests.commands.runs import Run, runner
from dynident.trajectories import Simulator, random_via_points
from scipy.spatial.transform import Rotation

WORLD = Pose.from_rpy((1.2, -0.4, 0.25), (0.1, -0.2, 2.1))
TOOL = Pose.from_rpy((0.03, -0.02, 0.16), (0.4, 0.3, -1.1))
FORMS: dict[str, tuple[str, Callable[[Rotation], Array]]] = {
    "rotation_vector": ("rx,ry,rz", lambda turn: turn.as_rotvec(degrees=True)),
    "rpy": ("r,p,w", lambda turn: turn.as_euler("xyz", degrees=True)),
    "quaternion": ("qx,qy,qz,qw", lambda turn: turn.as_quat()),
}


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "robot", "check")


@pytest.fixture(scope="module")
def log() -> Recording:
    """An RX90's unloaded recording."""
    robot = load_robot("rx90")
    return Simulator(robot).record(random_via_points(robot, 8, seed=5).motion(100.0), None, [0.5] * 6, 1)


def poses(robot: Robot, q: Array) -> tuple[Array, Rotation]:
    """What a controller would log: the tool in another frame."""
    at = [WORLD @ frames_at(robot, row)[-1] @ TOOL for row in q]
    return np.array([pose.p for pose in at]), Rotation.from_matrix(np.array([pose.R for pose in at]))


def write(path: Path, columns: dict[str, Array]) -> str:
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        delimiter=",",
        header=",".join(columns),
        comments="",
        fmt="%.12g",
    )
    return str(path)


def joints(log: Recording, torques: bool = True) -> dict[str, Array]:
    columns = {"t": log.t} | {f"q{j + 1}": log.q[:, j] for j in range(6)}
    return columns | ({f"tau{j + 1}": log.torque[:, j] for j in range(6)} if torques else {})


def in_metres(positions: Array) -> dict[str, Array]:
    return dict(zip("xyz", positions.T, strict=True))


@pytest.mark.long
@pytest.mark.parametrize("form", FORMS)
def test_pose_in_the_maps_units(run: Run, log: Recording, tmp_path: Path, form: str) -> None:
    """Millimetres and degrees by the log map; base and tool come back; torques are looked at where they are."""
    torques = form == "rpy"
    names, written = FORMS[form]
    positions, turns = poses(load_robot("rx90"), log.q)
    columns = joints(log, torques) | dict(zip(("px", "py", "pz"), 1e3 * positions.T, strict=True))
    columns |= dict(zip(names.split(","), written(turns).T, strict=True))
    path = write(tmp_path / "log.csv", columns)
    unit = "" if form == "quaternion" else 'rotation_unit = "deg"\n'
    (tmp_path / "map.toml").write_text(
        f'[pose]\ncolumns = ["px", "py", "pz"]\nunit = "mm"\nrotation = {json.dumps(names.split(","))}\n'
        f'form = "{form}"\n{unit}'
    )
    out = tmp_path / "c.json"
    status, text, error = run(
        "--robot", "rx90", "--data", path, "--log-map", str(tmp_path / "map.toml"),
        "--json", str(out),
    )  # fmt: skip
    assert status == 0, text
    assert "forward kinematics reproduces the tool pose" in " ".join(text.split())
    assert ("As recorded" in text) == torques
    assert "not used" not in error
    document = json.loads(out.read_text())
    first_pose = document["poses"][0]
    assert first_pose["rms_m"] < 1e-7
    assert first_pose["rms_angle_rad"] < 1e-6
    assert first_pose["base_and_tool_determined"]
    for name, pose in (("base", WORLD), ("tool", TOOL)):
        np.testing.assert_allclose(first_pose[name]["xyz_m"], pose.p, atol=1e-6)
        np.testing.assert_allclose(first_pose[name]["rpy_rad"], pose.rpy, atol=1e-6)
    assert ("ranked" in document) == torques


@pytest.mark.long
def test_pose_without_torques_or_map(run: Run, log: Recording, tmp_path: Path) -> None:
    """Standard names in metres; a log that has no torques is compared by its pose alone."""
    positions, _ = poses(load_robot("rx90"), log.q)
    path = write(tmp_path / "log.csv", joints(log, torques=False) | in_metres(positions))
    status, text, _ = run("--robot", "rx90", "--data", path)
    assert status == 0
    assert "No torques or currents: the pose alone is compared." in text
    assert "axes not logged" in text


@pytest.mark.long
def test_a_turned_last_joint_is_found_by_the_axes(run: Run, log: Recording, tmp_path: Path) -> None:
    """A tool on axis 6 tells nothing of it by its position; its axes do.

    Seen from a tool turned over, joint 5 half a turn on is the same: both are told.
    """
    robot = load_robot("rx90")
    turns = Rotation.from_matrix(np.array([frames_at(robot, row)[-1].R for row in log.q]))
    columns = joints(log, torques=False) | in_metres(np.array([frames_at(robot, row)[-1].p for row in log.q]))
    columns |= dict(zip(("qx", "qy", "qz", "qw"), turns.as_quat().T, strict=True))
    columns["q6"] = -columns["q6"]
    out = tmp_path / "c.json"
    status, text, _ = run("--robot", "rx90", "--data", write(tmp_path / "log.csv", columns), "--json", str(out))
    assert status == 1
    assert "does NOT reproduce" in text
    assert "Suggested, not applied: joint" in text
    assert "joint 6 turned round" in text
    assert "joint 5 zero moved by 180 degrees" in text
    (pose,) = json.loads(out.read_text())["poses"]
    assert pose["rms_m"] < 1e-6
    assert pose["rms_angle_rad"] > 0.1
    assert {(1, 1, 1, 1, 1, -1), (1,) * 6} == {tuple(reading["sign"]) for reading in pose["readings"]["ranked"][:2]}


@pytest.mark.long
def test_a_wrong_unit_is_told(run: Run, log: Recording, tmp_path: Path) -> None:
    positions, _ = poses(load_robot("rx90"), log.q)
    path = write(tmp_path / "log.csv", joints(log, torques=False) | in_metres(1e3 * positions))
    status, text, _ = run("--robot", "rx90", "--data", path)
    assert status == 1
    assert "positions in mm that are read as m?" in " ".join(text.split())


def test_a_still_tool_is_refused(run: Run, log: Recording, tmp_path: Path) -> None:
    still = in_metres(np.full((len(log.t), 3), 0.4))
    path = write(tmp_path / "log.csv", joints(log, torques=False) | still)
    status, _, error = run("--robot", "rx90", "--data", path)
    assert status == 2
    assert "moves by less than 50 mm" in error
    assert error.count("\n") == 1


def test_base_and_tool_of_one_moving_joint_are_not_told() -> None:
    robot, q = load_robot("rx90"), np.zeros((50, 6))
    q[:, 1] = np.linspace(-1.0, 1.0, 50)
    positions, _ = poses(robot, q)
    check = check_pose(robot, ToolPoses("log", q, positions))
    assert check.reproduced
    assert not check.determined


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ('columns = ["x", "y"]', "give those of x, y and z"),
        ('columns = ["x", "y", "z"]\nunit = "cm"', "'pose.unit': must be 'm' or 'mm', got 'cm'"),
        ('columns = ["x", "y", "z"]\nrotation = ["a", "b", "c"]', "go together"),
        (
            'columns = ["x", "y", "z"]\nrotation = ["a", "b", "c"]\nform = "euler"',
            "'pose.form': must be 'quaternion' or 'rotation_vector'",
        ),
        ('columns = ["x", "y", "z"]\nrotation = ["a", "b", "c"]\nform = "quaternion"', "has 4 columns"),
        ('columns = ["x", "y", "z"]\nsign = [1]', "unknown"),
    ],
)
def test_maps_that_contradict_themselves(tmp_path: Path, table: str, problem: str) -> None:
    path = tmp_path / "map.toml"
    path.write_text(f"[pose]\n{table}\n")
    with pytest.raises(InputError, match=problem):
        read_log_map(path)


def test_logs_that_do_not_hold_the_pose(rx90: Robot, log: Recording, tmp_path: Path) -> None:
    columns: dict[str, Any] = joints(log, torques=False)
    bare = write(tmp_path / "bare.csv", columns)
    assert read_tool_poses(bare, rx90) is None
    with pytest.raises(InputError, match="column a missing"):
        read_tool_poses(bare, rx90, LogMap(pose=ToolColumns(("a", "q1", "q2"))))
    columns |= in_metres(np.zeros((len(log.t), 3))) | dict.fromkeys(("qx", "qy", "qz", "qw"), 0.0 * log.t)
    with pytest.raises(InputError, match="line 2, columns qx, qy, qz, qw: a quaternion of length 0"):
        read_tool_poses(write(tmp_path / "bad.csv", columns), rx90)
