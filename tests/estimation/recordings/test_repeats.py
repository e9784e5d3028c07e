"""Logs as they are: held samples, freezes, dead channels, files of one signal each; TOML and URDF robots."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import LogMap, grouped, read_recordings
from dynident.apps.logs.map import Layout
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.estimation import identify_payload
from dynident.estimation.signals.filtering import measurement
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, base_parameters, load_robot
from dynident.trajectories import Simulator

RATE, COUNT, EVERY = 500.0, 15000, 3
EXAMPLES = Path(__file__).parents[3] / "examples/robots"


def arm_of(name: str) -> Robot:
    """A robot; "sliding" is one whose third joint slides."""
    if name == "sliding":
        robot = load_robot("ur10e")
        third = replace(robot.joints[2], kind="prismatic")
        return replace(
            robot, joints=(*robot.joints[:2], third, *robot.joints[3:]), processing=Processing(cutoff=5.0)
        )
    return load_robot(str(EXAMPLES / name) if "." in name else name)


@pytest.fixture(scope="module", params=["ur10e", "iiwa14", "six_axis.urdf", "sliding"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return arm_of(request.param)


def signals(n: int, rest: bool = False) -> dict[str, np.ndarray]:
    """Half a minute of a smooth motion with noisy torques; with ``rest`` the last joint stands still."""
    draw = np.random.default_rng(0)
    t = np.arange(COUNT) / RATE
    speed, phase = draw.uniform(0.5, 1.5, n) * ([1.0] * (n - 1) + [float(not rest)]), draw.uniform(0.0, 6.0, n)
    angle = np.outer(t, speed) + phase
    torque = 20.0 * np.cos(angle) + draw.normal(0.0, 0.5, (COUNT, n))
    return {"t": t, "q": 0.8 * np.sin(angle), "qd": 0.8 * speed * np.cos(angle), "tau": torque}


def written(path: Path, log: dict[str, np.ndarray], kinds: Sequence[str] = ("q", "qd", "tau")) -> Path:
    names = ["t", *(f"{kind}{j + 1}" for kind in kinds for j in range(log[kind].shape[1]))]
    table = np.column_stack([log["t"], *(log[kind] for kind in kinds)])
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    return path


def held(log: dict[str, np.ndarray], kinds: Sequence[str]) -> dict[str, np.ndarray]:
    return log | {kind: np.repeat(log[kind][::EVERY], EVERY, axis=0) for kind in kinds}


@pytest.mark.parametrize("kinds", [("q", "qd", "tau"), ("tau",)])
def test_held_samples_are_the_slower_signal(tmp_path: Path, robot: Robot, kinds: Sequence[str]) -> None:
    """What follows of it is what follows of the original: a joint at rest does not matter."""
    log = signals(robot.n, rest=True)
    slow = read_recording(written(tmp_path / "slow.csv", {kind: own[::EVERY] for kind, own in log.items()}), robot)
    thinned = read_recording(written(tmp_path / "held.csv", held(log, kinds)), robot)
    assert "change once in 3 rows (500 Hz): thinned to 5000 rows" in thinned.notes[-1]
    assert np.allclose(thinned.t, slow.t)
    for name in ("q", "qd", "torque"):
        assert np.allclose(getattr(thinned, name), getattr(slow, name), atol=1e-9)


def test_held_positions_of_true_torques_lose_no_torque(tmp_path: Path, robot: Robot) -> None:
    log = signals(robot.n)
    recording = read_recording(written(tmp_path / "log.csv", held(log, ("q", "qd"))), robot)
    assert np.allclose(recording.torque, log["tau"])
    assert np.abs(recording.q - log["q"])[:-EVERY].max() < 1e-5
    assert "position, velocity change" in recording.notes[-1]


@pytest.mark.parametrize("quantum", [2e-3, 1e-2])
def test_coarse_numbers_are_not_held(tmp_path: Path, robot: Robot, quantum: float) -> None:
    log = signals(robot.n, rest=True)
    log["q"] = np.round(log["q"] / quantum) * quantum
    log["tau"] = np.round(log["tau"])
    recording = read_recording(written(tmp_path / "log.csv", log), robot)
    assert np.mean(recording.q[1:] == recording.q[:-1]) > 0.4
    assert not recording.notes
    assert np.allclose(recording.q, log["q"])


def frozen(log: dict[str, np.ndarray], rows: int, every: int = 2100) -> dict[str, np.ndarray]:
    """Seven freezes, in which all but time stands still."""
    result = {kind: own.copy() for kind, own in log.items()}
    for start in range(1000, COUNT, every):
        for kind in ("q", "qd", "tau"):
            result[kind][start + 1 : start + rows + 1] = log[kind][start]
    return result


@pytest.mark.parametrize("rest", [0, 3000])
def test_freezes_are_cut_out_and_counted(tmp_path: Path, robot: Robot, rest: int) -> None:
    """A robot that starts from rest does not freeze before, even without any noise."""
    log = signals(robot.n)
    for kind in ("q", "qd", "tau"):
        log[kind][:rest] = log[kind][rest]
    if rest:
        log["q"][rest:] = log["q"][rest] + 0.5 * (1.0 - np.cos(0.5 * (log["t"] - log["t"][rest])))[rest:, None]
        recording = read_recording(written(tmp_path / "log.csv", log), robot)
        assert len(recording.t) == COUNT
        return
    kept = read_recordings(written(tmp_path / "log.csv", frozen(log, 80)), robot)
    assert "jump 7 times (3.7 % of the rows): cut out" in " ".join(kept[0].notes)
    assert sum(len(piece.t) for piece in kept) == COUNT - 7 * 80
    for piece in kept:
        rows = np.rint(piece.t * RATE).astype(int)
        assert np.allclose(piece.q, log["q"][rows])
    with pytest.raises(InputError, match=r"7 times \(7 % of the rows\), first at line 1003: the logger froze"):
        read_recordings(written(tmp_path / "log.csv", frozen(log, 150)), robot)


@pytest.mark.parametrize("speeds", [False, True])
def test_a_motion_that_was_cut_is_filtered_as_the_whole(speeds: bool) -> None:
    """Where a filter stopped it at its ends, accelerations were off by all of what they are."""
    log = signals(6)
    whole = Recording(log["t"], log["q"], log["tau"], log["qd"] if speeds else None)
    cut = slice(4000, 9000)
    part = Recording(log["t"][cut], log["q"][cut], log["tau"][cut], log["qd"][cut] if speeds else None)
    one, other = (measurement(own, Processing(cutoff=5.0)).motion for own in (whole, part))
    settled = slice(100, -100)  # one period of the cut-off
    assert np.abs(one.qd[cut][[0, -1]] - other.qd[[0, -1]]).max() < 0.05
    assert np.abs(one.qdd[cut][settled] - other.qdd[settled]).max() < 0.1


def test_files_of_one_signal_each_are_the_log(tmp_path: Path, robot: Robot) -> None:
    """Joints stand in any order by name; files that are recordings by themselves stay so."""
    log, order = signals(robot.n), np.random.default_rng(1).permutation(robot.n)
    whole = read_recording(written(tmp_path / "log.csv", log), robot)
    for kind, name in (("tau", "x_efforts"), ("q", "x_positions"), ("qd", "x_velocities")):
        header = ",".join(["time", *(f"arm_{j}" for j in order)])
        table = np.column_stack([log["t"], log[kind][:, order]])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=header, comments="", fmt="%.12g")
    for kind in ("q", "qd", "tau"):
        written(tmp_path / f"{kind}.csv", log, [kind])
    (tmp_path / "x_current.csv").write_text("t,q1,tau1\n0,1,2\n")
    (tmp_path / "y_position.csv").write_text("t,q1,tau1\n0,1,2\n")
    (tmp_path / "y_torque.csv").write_text("t,q1,tau1\n0,1,2\n")
    scrambled, plain = (
        [str(tmp_path / f"{name}.csv") for name in names]
        for names in (("x_efforts", "x_positions", "x_velocities"), ("q", "qd", "tau"))
    )
    complete = [str(tmp_path / f"y_{name}.csv") for name in ("position", "torque")]
    assert grouped([*scrambled, *plain, *complete]) == [tuple(scrambled), tuple(plain), *complete]
    for files in (scrambled, plain):
        recording = read_recording(files, robot)
        for name in ("q", "qd", "torque"):
            assert np.array_equal(getattr(recording, name), getattr(whole, name))
        assert recording.torque_unit == ("unknown" if files is scrambled else "named")
    written(tmp_path / "tau.csv", log | {"t": log["t"] + 1.0}, ["tau"])
    with pytest.raises(InputError, match=r"have not the same times: are they of one recording\?"):
        read_recording(plain, robot)
    (tmp_path / "x_efforts.csv").rename(tmp_path / "x_c.csv")
    with pytest.raises(InputError, match=r"x_c\.csv: name it after its signal"):
        read_recording([str(tmp_path / "x_c.csv"), *scrambled[1:]], robot)
    with pytest.raises(InputError, match=r"\[file\] name has no effect on files that are named"):
        read_recording(plain, robot, log_map=LogMap(layout=Layout(name="q.csv")))


@pytest.mark.parametrize("name", ["rx90", "iiwa14", "six_axis.urdf"])
@pytest.mark.parametrize("dead", [2, 6])
def test_a_payload_does_without_a_joints_torque(name: str, dead: int, wander: Callable[..., Motion]) -> None:
    """Base parameters of the other torques are the same sums, fewer; the payload is found by what is left."""
    robot = arm_of(name)
    whole, left = (
        base_parameters(replace(robot, drives=replace(robot.drives, unmeasured=joints))) for joints in ((), (dead,))
    )
    assert {f"FS{dead}", f"FV{dead}"}.isdisjoint(left.columns)
    assert np.allclose(left.grouping, whole.grouping[[whole.columns.index(column) for column in left.columns]])
    known = load_robot("rx90").parameters
    simulator = Simulator(replace(robot, parameters={one: known.get(one, 0.5) for one in whole.standard}))
    fast = wander(robot.n, seed=0, points=20, rate=300.0)
    motion = Motion(3.0 * fast.t, fast.q, fast.qd / 3.0, fast.qdd / 9.0)
    body = InertialParameters.from_com(2.5, [0.01, 0.03, 0.08], np.diag([0.01, 0.01, 0.006]))
    pair = []
    for load in (None, body):
        measured = simulator.measure(motion, load)
        torque = measured.torque.copy()
        torque[:, dead - 1] = 0.0
        pair.append(Recording(motion.t, motion.q, torque, motion.qd, f"{load is not None}", gain_sigma=0.0))
    result = identify_payload(robot, [pair[1]], [pair[0]])
    assert result.mass.value == pytest.approx(2.5, rel=0.01)
