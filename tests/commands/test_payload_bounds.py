"""Every payload within bounds on the command line: what is judged, what controllers make of files, what is said."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.commands.options.motions import payload_bounds, region
from dynident.cli import main
from dynident.model import InertialParameters, load_robot, payload_regressor, robot_names
from dynident.tests.commands.runs import Run, document, runner
from dynident.tests.selection import cases
from dynident.tests.trajectories.bodies import dense, drawn_points
from dynident.trajectories import PayloadSet

ARM = ("--robot", "ur10e")
BALL = ("--heaviest-payload", "6@0,0,0.1", "--within", "0.2")
NEAR = (*ARM, "--pose=0,-90,110,-110,-90,0", "--joints", "2,3,5,6", "--duration", "6", *BALL)
REGIONS = ("0.2", "0.1,0.15,0.2", "box:0.1,0.1,0.1")
DESIGN = (
    "--robot", "tx40", "--columns", "payload", "--torque-noise", "1%", "--via-points", "4", "--starts", "1",
    "--seed", "2", "--acceleration", "5x", "--heaviest-payload", "2@0,0,0.05", "--within", "0.1",
)  # fmt: skip
WRITERS = {"--val3": "app", "--ros2": "m.yaml", "--urscript": "m.script"}


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A motion for every payload of a ball, a torque limit being active."""
    path = tmp_path_factory.mktemp("motion") / "n.csv"
    assert main(["near", *NEAR, "--samples", str(path), "--quiet"]) == 0
    return path


def sparse(path: Path, every: int) -> Path:
    """The file with every so manieth sample, and the last one."""
    lines = path.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("t,"))
    rows = lines[first + 1 :]
    place = path.with_name(f"every_{every}.csv")
    place.write_text("\n".join([*lines[: first + 1], *rows[:-1:every], rows[-1]]) + "\n")
    return place


@pytest.mark.parametrize("region", cases(REGIONS, lambda region: region == "0.2"))
def test_score_looks_between_samples(run: Run, motion: Path, tmp_path: Path, region: str) -> None:
    """Every 60th sample tells of the same torques as all of them."""
    torques = []
    for name, path in (("all", motion), ("few", sparse(motion, 60))):
        options = ("--columns", "payload", *BALL[:2], "--within", region, "--json", str(tmp_path / name))
        assert run("score", str(path), *ARM, *options)[0] == 0
        checks = document(tmp_path / name)["limits"]["nearest"]
        torques.append(next(check for check in checks if check["name"].startswith("torque")))
    assert torques[1]["value"] == pytest.approx(torques[0]["value"], rel=0.01)


@pytest.mark.parametrize(
    ("mass", "words"), [("6", "limits hold for every"), ("6.2", "limits do NOT hold for every")]
)
def test_what_is_said_of_the_bounds_is_what_was_seen(run: Run, motion: Path, mass: str, words: str) -> None:
    bounds = ("--heaviest-payload", f"{mass}@0,0,0.1", "--within", "0.2")
    for path in (motion, sparse(motion, 60)):
        status, out, err = run("score", str(path), *ARM, "--columns", "payload", *bounds)
        assert status == 0, err
        flat = " ".join(out.split())
        assert words in flat
        assert ("does NOT keep" in flat) == ("NOT" in words)


REFUSED = ("--val3 trapezoid", "--ros2 trapezoid", "--urscript trapezoid")


@pytest.mark.parametrize("written", cases(REFUSED, lambda written: written.startswith("--val3")))
def test_files_whose_controllers_break_a_limit_are_refused(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: str
) -> None:
    """Nothing is written or shown; with room left by --torque-margin the same file is written."""
    monkeypatch.chdir(tmp_path)
    writer, segments = written.split()
    files = writer, WRITERS[writer]
    status, out, err = run("design", *DESIGN, "--segments", segments, *files, "--json", "m.json")
    assert (status, out) == (2, "")
    assert "the motion does not keep its limits (torque with any payload up to 2 kg of joint" in err
    assert not list(tmp_path.iterdir())
    status, _, err = run("design", *DESIGN, "--segments", segments, *files, "--torque-margin", "30%")
    assert status == 0, err
    assert [path.name for path in tmp_path.iterdir()] == [WRITERS[writer]]


def test_points_too_few_for_their_controller_are_refused(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A point a second: the quintics between them leave the range about the pose."""
    monkeypatch.chdir(tmp_path)
    status, out, err = run("near", *NEAR, "--ros2", "m.yaml", "--sample-rate", "1", "--samples", "m.csv")
    assert (status, out) == (2, "")
    assert "as ROS 2 joins the samples the motion does not keep its limits (position of joint" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "options",
    [("--mass", "5"), ("--mass", "5+-0.01"), ("--mass", "7", "--ladder")],
)
def test_a_payload_expected_beyond_the_bounds_is_refused(run: Run, options: tuple[str, ...]) -> None:
    status, out, err = run("near", *NEAR[:-4], "--heaviest-payload", "2@0,0,0.1", "--within", "0.1", *options)
    assert (status, out) == (2, "")
    assert f"{options[1][0]} kg are expected and --heaviest-payload allows 2: give another {options[0]}" in err


def test_nothing_told_of_the_payload_is_what_is_within_bounds(run: Run, tmp_path: Path) -> None:
    bounds = ("--heaviest-payload", "2@0,0,0.1", "--within", "0.1")
    status, out, _ = run("near", *NEAR[:-4], *bounds, "--json", str(tmp_path / "n.json"))
    assert status == 0
    assert "Predicted for 2 kg" in out


@pytest.mark.parametrize("arm", cases(robot_names(), lambda arm: arm == "tx40"))
def test_bounds_are_in_the_payloads_frame(arm: str) -> None:
    """Bodies described there break no bound of any joint's torque, by the arm's regressor; one comes to it."""
    robot, draw, mass, centre = load_robot(arm), np.random.default_rng(3), 7.0, np.array([0.05, -0.1, 0.2])
    rows = dense(payload_regressor(robot), *draw.uniform(-2.0, 2.0, (3, 10, robot.n))).reshape(-1, 10)
    for text in REGIONS:
        half, box = region(text)
        payloads = payload_bounds(robot, f"{mass:g}@0.05,-0.1,0.2", (half, box))
        assert isinstance(payloads, PayloadSet)
        own = PayloadSet.within(mass, half * (3 // len(half)), centre, box)
        places = drawn_points(own, 500, draw)
        if box:
            places = np.vstack([places, centre + own.half * list(product((-1.0, 1.0), repeat=3))])
        bodies = [
            InertialParameters.from_com(mass, place, np.zeros((3, 3))).moved(robot.flange.R, robot.flange.p).vector
            for place in places
        ]
        torque = rows @ np.array(bodies).T
        largest, smallest = payloads.extremes(rows)
        assert (torque <= largest.torque[:, None] + 1e-9).all()
        assert (torque >= smallest.torque[:, None] - 1e-9).all()
        much = largest.torque > 1.0
        assert np.median(torque.max(axis=1)[much] / largest.torque[much]) > 0.95
