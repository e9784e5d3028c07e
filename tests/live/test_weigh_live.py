"""``dynident weigh --live`` and ``--replay``: the window is ``weigh``'s own problem, and changes are told once."""

import gzip
import json
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident import estimation, model
from dynident.apps.commands.weigh_live import beyond_gains, out_of_reach
from dynident.benchmarks import invented
from dynident.cli import main
from dynident.estimation.equations.equations import merged
from dynident.estimation.equations.reduction import reduced
from dynident.estimation.payload.live import LiveWeighing
from dynident.estimation.payload.short_motion import Run
from dynident.estimation.payload.weighing import weighing_problem
from dynident.estimation.payload.window import MovingWindow
from dynident.model import InertialParameters, Recording, load_robot
from dynident.tests.live.conftest import Play
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

BOX = InertialParameters.from_com(6.0, [0.01, -0.02, 0.15], np.diag([0.03, 0.03, 0.02]))
GAINS = "11.976,11.976,9.839,10.763,10.757,10.680"


class Empty(NamedTuple):
    """A robot, its parameters by an identification, and what makes recordings of it."""

    robot: model.Robot
    known: estimation.Estimate
    simulator: Simulator


@pytest.fixture(scope="module")
def empty() -> Empty:
    simulator = Simulator(load_robot("rx90"))
    bare = recorded(simulator, 1)
    known = estimation.identify(simulator.robot, [bare]).estimate
    return Empty(simulator.robot, known, simulator)


def recorded(simulator: Simulator, seed: int, payload: InertialParameters | None = None) -> Recording:
    """About 25 s along a random path with the noise of the paper's arm."""
    motion = random_via_points(simulator.robot, 14, seed=seed).motion(100.0)
    measured = simulator.measure(motion, payload)
    noise = np.random.default_rng(seed).standard_normal(measured.torque.shape) * np.array(RX90_NOISE)
    return Recording(motion.t, motion.q, measured.torque + noise, motion.qd)


def after(first: Recording, second: Recording) -> Recording:
    """One recording behind the other, half a second later."""
    assert first.qd is not None
    assert second.qd is not None
    t = np.concatenate([first.t, second.t + first.t[-1] + 0.5])
    q, torque = np.vstack([first.q, second.q]), np.vstack([first.torque, second.torque])
    return Recording(t, q, torque, np.vstack([first.qd, second.qd]))


def filled(empty: Empty, recording: Recording) -> MovingWindow:
    weighing = LiveWeighing(MovingWindow(empty.robot, empty.known))
    list(weighing.feed(recording))
    return weighing.window


def test_the_window_is_the_problem_of_weigh(empty: Empty) -> None:
    """Blocks that were dropped leave nothing; those that are there give what their factors, merged, give."""
    window = filled(empty, recorded(empty.simulator, 3, BOX))
    assert window.seconds == pytest.approx(20.0)
    own = window.problem()
    assert own.short is not None
    factors = merged(reduced(block.equations) for block in window.blocks)
    run = Run("blocks", factors)
    short = own.short
    problem = weighing_problem(
        window.robot, own.base, [run], short.joints, short.held, short.torque_rms, None, window.known
    )
    free = estimation.identify_payload(problem, 1).estimate
    weighed = window.weighed()
    assert weighed.mass == pytest.approx(free["M_L"], rel=1e-9)
    np.testing.assert_allclose(weighed.com * weighed.mass, free.values[6:9], rtol=1e-9)
    assert weighed.low < 6.0 < weighed.high


def test_the_same_seconds_read_as_a_file(empty: Empty) -> None:
    recording = recorded(empty.simulator, 3, BOX)
    window = filled(empty, recording)
    start, stop = window.blocks[0].start, window.blocks[-1].stop
    part = (recording.t >= start - 0.6) & (recording.t <= stop + 0.6)
    assert recording.qd is not None
    cut = Recording(recording.t[part], recording.q[part], recording.torque[part], recording.qd[part])
    problem = estimation.payload.known_robot_weighing(empty.robot, [cut], empty.known)
    whole = estimation.identify_payload(problem, 1).estimate
    sigma = float(whole.larger_sigma[whole.names.index("M_L")])
    assert abs(window.weighed().mass - whole["M_L"]) < 0.2 * sigma


def test_what_the_gains_alone_forbid_is_said(empty: Empty) -> None:
    """An error that all joints share scales the payload: its half of the interval is known in closed form."""
    recording = recorded(empty.simulator, 3, BOX)
    assert recording.qd is not None
    part = slice(0, 800)
    first = Recording(recording.t[part], recording.q[part], recording.torque[part], recording.qd[part])
    alike = MovingWindow(empty.robot, empty.known, gains=estimation.Gains((0.0,), common=0.02))
    list(LiveWeighing(alike).feed(first))
    weighed = alike.weighed()
    assert weighed.by_gains == pytest.approx(1.96 * 0.02 * weighed.mass, rel=1e-3)
    assert weighed.half_width > weighed.by_gains
    assert out_of_reach(weighed, 0.9 * weighed.by_gains)
    assert not out_of_reach(weighed, 1.1 * weighed.by_gains)
    line = beyond_gains(weighed, 0.05, alike.gains, 6)
    assert "--until 50g is out of reach: gains of 2 % allow ±0.2" in line


@pytest.mark.long
def test_a_change_is_told_once_and_an_empty_robot_is_left_alone(empty: Empty) -> None:
    first, second = recorded(empty.simulator, 4), recorded(empty.simulator, 5, BOX)
    weighing = LiveWeighing(MovingWindow(empty.robot, empty.known))
    alarms = [news for news in weighing.feed(first) if news.change]
    assert not alarms
    whole = LiveWeighing(MovingWindow(empty.robot, empty.known))
    both = after(first, second)
    (change,) = [news.change for news in whole.feed(both) if news.change]
    put_on = float(first.t[-1]) + 0.5
    assert put_on - 1.0 <= change.time < put_on + 2.0
    assert change.low < 6.0 < change.high
    assert whole.latest is not None
    assert whole.latest.weighed.low < 6.0 < whole.latest.weighed.high


@pytest.mark.parametrize("name", ["kr6_r900", pytest.param("panda", marks=pytest.mark.long)])
def test_half_a_kilogram_is_told_within_three_seconds_of_motion(name: str) -> None:
    """On arms with invented links, noise of 5 % of each joint's torque, and nothing tuned to any of them."""
    robot = invented.robot(name)
    simulator = Simulator(robot)

    def measured(seed: int, points: int, payload: InertialParameters | None = None) -> Recording:
        motion = random_via_points(robot, points, seed=seed).motion(100.0)
        torque = simulator.measure(motion, payload).torque
        size = 0.05 * np.sqrt((torque**2).mean(axis=0))
        torque = torque + np.random.default_rng(seed).standard_normal(torque.shape) * size
        return Recording(motion.t, motion.q, torque, motion.qd)

    known = estimation.identify(robot, [measured(1, 14)]).estimate
    box = InertialParameters.from_com(0.5, [0.02, -0.01, 0.1], np.diag([0.002, 0.002, 0.001]))
    weighing = LiveWeighing(MovingWindow(robot, known))
    bare, loaded = measured(300, 14), measured(600, 6, box)
    for recording in (bare, Recording(loaded.t + bare.t[-1] + 0.5, loaded.q, loaded.torque, loaded.qd)):
        for part in np.array_split(np.arange(len(recording.t)), len(recording.t) // 20):
            assert recording.qd is not None
            portion = Recording(recording.t[part], recording.q[part], recording.torque[part], recording.qd[part])
            list(weighing.feed(portion))
    ((change, at),) = weighing.changes
    assert bare.t[-1] - 1.0 <= change.time
    assert at <= bare.t[-1] + 0.5 + 3.5  # a block of 1 s, and the filter's margin behind it
    assert change.low < 0.5 < change.high


@pytest.mark.long
def test_gaps_and_repeated_samples_do_no_harm(empty: Empty) -> None:
    """Samples in odd portions, twice, with a second missing: the blocks are those of the same times."""
    recording = recorded(empty.simulator, 3, BOX)
    assert recording.qd is not None
    arrays = recording.t, recording.q, recording.torque, recording.qd
    window = MovingWindow(empty.robot, empty.known)
    weighing, k = LiveWeighing(window), 0
    for size in np.random.default_rng(0).integers(1, 90, 200):
        rows = np.clip(np.arange(k - 3, k + size), 0, len(recording.t) - 1)
        rows = rows[(recording.t[rows] < 8.0) | (recording.t[rows] > 9.0)]
        if len(rows):
            list(weighing.feed(Recording(*(array[rows] for array in arrays))))
        k += int(size)
    assert not any(block.stop > 8.0 and block.start < 9.0 for block in window.blocks)
    assert not weighing.changes
    weighed = window.weighed()
    assert weighed.low < 6.0 < weighed.high


def test_a_robot_that_stands_is_not_weighed(empty: Empty) -> None:
    recording = recorded(empty.simulator, 3)
    still = replace(recording, q=0.0 * recording.q, qd=0.0 * recording.q)
    window = filled(empty, still)
    assert not window.blocks
    assert window.weighed().hidden == "no joint moves"


@pytest.fixture(scope="module")
def ur10e(recordings: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the parameters of the real arm, and its recordings one after the other."""
    folder = tmp_path_factory.mktemp("ur10e")
    bare, loaded = recordings / "ur10e/unloaded.csv.gz", recordings / "ur10e/loaded_2.805kg.csv.gz"
    line = ["identify", "--robot", "ur10e", "--data", str(bare), "--drive-gains", GAINS, "--gain-sigma", "2%"]
    assert main([*line, "--offsets", "--json", str(folder / "robot.json"), "--quiet"]) in (0, 1)
    rows, offset = [], 0.0
    for path in (bare, loaded, bare):
        header, *lines = gzip.decompress(path.read_bytes()).decode().split()
        cells = [line.partition(",") for line in lines]
        rows += [f"{float(t) + offset:.3f},{rest}" for t, _, rest in cells]
        offset = float(rows[-1].partition(",")[0]) + 0.01
    (folder / "joined.csv").write_text("\n".join([header, *rows]) + "\n")
    return folder


def weigh(folder: Path, *more: str) -> int:
    known = ["--robot", "ur10e", "--robot-parameters", str(folder / "robot.json"), "--drive-gains", GAINS]
    return main(["weigh", *known, *more, "--json", str(folder / "answer.json")])


@pytest.mark.long
def test_the_real_pair_joined(ur10e: Path) -> None:
    """The arm moves for good 3.5 s and 2.4 s after the joints of the recordings; jogs under 1 s do not count."""
    watched = ur10e / "w.jsonl"
    assert weigh(ur10e, "--replay", str(ur10e / "joined.csv"), "--watch", str(watched)) == 0
    on, off = map(json.loads, watched.read_text().splitlines())
    for event, moves, mass in ((on, 56.398 + 3.5, 2.805), (off, 112.168 + 2.4, -2.805)):
        assert moves - 3.5 < event["time_s"] < moves + 1.0
        assert event["told_s"] - moves < 3.0
        low, high = event["interval95_kg"]
        assert low < mass < high
    low, high = json.loads((ur10e / "answer.json").read_text())["interval95_kg"]
    assert low < 0.0 < high


@pytest.mark.long
def test_the_real_recordings_alone(ur10e: Path, recordings: Path) -> None:
    """No change in either; the settled window's interval holds the weighed mass."""
    for name, mass in (("loaded_2.805kg", 2.805), ("validation_unloaded", 0.0)):
        watched = ur10e / f"{name}.jsonl"
        assert weigh(ur10e, "--replay", str(recordings / f"ur10e/{name}.csv.gz"), "--watch", str(watched)) == 0
        assert not watched.exists()
        answer = json.loads((ur10e / "answer.json").read_text())
        assert answer["seconds"] == pytest.approx(20.0)
        assert answer["interval95_kg"][0] < mass < answer["interval95_kg"][1]


@pytest.mark.long
def test_live_from_the_player(ur10e: Path, recordings: Path, play: Play, capsys: Any) -> None:
    """Until the mass is known to 200 g; and a line that is cut ends in what was known, with status 2."""
    log = str(recordings / "ur10e/loaded_2.805kg.csv.gz")
    before = threading.active_count()
    options = ("--live", "ur", "--until", "200g")
    assert weigh(ur10e, *options, *play(play=log, pace=8.0).address) == 0
    low, high = json.loads((ur10e / "answer.json").read_text())["interval95_kg"]
    assert high - low <= 0.4
    assert low < 2.805 < high
    begin = time.monotonic()
    cut = play(play=log, pace=20.0, fault="closed", after=1500)
    assert weigh(ur10e, *options[:2], *cut.address) == 2
    assert time.monotonic() - begin < 60.0
    out, err = capsys.readouterr()
    assert "closed the connection" in err
    assert "mass " in out
    assert threading.active_count() == before


@pytest.mark.long
def test_an_interval_that_the_gains_forbid_ends_at_once(ur10e: Path, recordings: Path, capsys: Any) -> None:
    log = str(recordings / "ur10e/loaded_2.805kg.csv.gz")
    assert weigh(ur10e, "--replay", log, "--gain-sigma", "2%", "--until", "30g") == 2
    out, err = capsys.readouterr()
    assert "--until 30g is out of reach: gains of 2 % allow ±" in err
    assert "mass 2." in out
    assert json.loads((ur10e / "answer.json").read_text())["seconds"] < 6.5


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (("--replay", "x.csv"), "need --robot-parameters"),
        (("--live", "ur"), "need --robot-parameters"),
        (("--replay", "x.csv", "--mass", "2", "--mass-sigma", "1"), "--mass has no meaning for --live"),
        (("--replay", "x.csv", "--loaded", "y.csv"), "--loaded has no meaning"),
        (("--loaded", "y.csv", "--until", "50g"), "--until belongs to --live or --replay"),
        (("--loaded", "y.csv", "--host", "h"), "--host belongs to --live or --replay"),
        ((), "give --loaded recordings, or --live"),
    ],
)
def test_lines_that_make_no_sense(more: tuple[str, ...], why: str, capsys: Any) -> None:
    assert main(["weigh", "--robot", "ur10e", *more]) == 2
    assert why in capsys.readouterr().err


@pytest.mark.parametrize(("text", "mass"), [("50g", 0.05), ("0.05kg", 0.05), ("0.05", 0.05)])
def test_masses(text: str, mass: float) -> None:
    from dynident.apps.commands.values import mass as read

    assert read(text) == pytest.approx(mass)
