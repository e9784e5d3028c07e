"""``dynident design``, ``near`` and ``score``: what is asked for arrives, what is written, and how it is judged."""

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands.options.motions import payload_bounds, region
from dynident.model import InertialParameters, load_robot, payload_regressor, robot_names
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import answered, refused, typed
from dynident.tests.report.motions import motion_parsers as read
from dynident.tests.selection import cases
from dynident.tests.trajectories.bodies import dense, drawn_points
from dynident.trajectories import RX90_NOISE, DesignProblem, PayloadSet, Simulator, ViaPoints, random_via_points

DESIGN, SCORE = "design --robot rx90", "score --robot rx90"
QUICK = f"{DESIGN} --columns payload --via-points 4 --starts 1 --seed 2"
"""A design problem of a second."""
UNIT = "--torque-noise 1,1,1,1,1,1"
NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"


@pytest.mark.long
def test_every_file(here: Path) -> None:
    files = "--samples m.csv --ros2 m.yaml --urscript m.script --val3 excite --plots plots"
    data, text = answered(f"{QUICK} --criterion cond-scaled {UNIT} {files}")
    assert data["limits"]["max_violation"] == 0.0
    assert data["limits"]["met"]
    assert (data["criterion"], data["seed"], data["interrupted"]) == ("cond-scaled", 2, False)
    assert f"{data['condition_number_scaled']:.4g}" in text
    motion = data["motion"]
    p, T, v, a = (np.array(motion[key]) for key in ("points", "durations", "speeds", "accelerations"))
    plan = ViaPoints(p, T, v, a)
    samples = read.csv_samples(Path("m.csv").read_text())
    assert np.abs(samples.q - plan.at(samples.t)[0]).max() < 1e-7
    assert np.allclose(read.ros2(Path("m.yaml").read_text())[1].q, samples.q, atol=1e-8)
    assert np.allclose(read.urscript(Path("m.script").read_text()).first, plan.points[0], atol=1e-8)
    application = {path.name: path.read_text() for path in Path("excite").iterdir()}
    assert np.allclose(read.val3(application).points, np.degrees(plan.points), atol=1e-5)
    replay = data["val3_replay"]
    assert replay["condition_number_scaled"] > data["condition_number_scaled"] > 1.0
    assert f"{replay['duration_s']:.4g} s" in text
    plots = {f"{name}.{ending}" for name in ("motion", "predicted_sigma") for ending in ("png", "svg", "pdf")}
    assert {path.name for path in Path("plots").iterdir()} == plots


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "shape"),
    [("--columns payload --criterion cond", "--via-points 4"), ("--criterion d", "--fourier 3 --duration 6")],
)
def test_a_designed_csv_is_judged_as_the_design_was(here: Path, goal: str, shape: str) -> None:
    designed, _ = answered(f"{DESIGN} {goal} {shape} {NOISE} --starts 1 --samples m.csv --sample-rate 1000")
    judged, text = answered(f"{SCORE} {goal} {NOISE} m.csv")
    assert judged["evaluated"] == "m.csv"
    assert "motion" not in judged
    assert judged["limits"]["met"]
    # The design's own grid has 120 samples a second here: the sign of a speed switches up to 8 ms away, which the
    # condition number in SI units and joint 2's sigmas feel most. At 240, 500, 1,000 and 2,000 samples a second
    # they are .9 to 1 and .7 to .8 % from the design's.
    for key in ("condition_number", "condition_number_scaled", "log_det", "duration_s"):
        error = 1.5e-2 if key == "condition_number" else 2e-3
        assert judged[key] == pytest.approx(designed[key], rel=error), key
        assert f"{judged[key]:.4g}" in text
    assert judged["predicted_sigma"] == pytest.approx(designed["predicted_sigma"], rel=1e-2)


def _identify(folder: Path) -> None:
    robot = load_robot("rx90")
    recording = Simulator(robot).record(random_via_points(robot, 14, seed=1).motion(250.0), None, RX90_NOISE)
    save(folder / "log.csv", recording.t, recording.q, recording.torque, names="q,tau")
    line = f"identify --robot rx90 --data {folder}/log.csv --constrained none"
    assert typed(f"{line} --npz {folder}/r.npz --json {folder}/r.json").status == 0


@pytest.fixture
def identified(shared: Callable[[str, Callable[[Path], object]], Path], here: Path) -> Path:
    """What ``dynident identify`` writes of a short recording."""
    for path in shared("identified", _identify).iterdir():
        (here / path.name).symlink_to(path)
    return here


@pytest.mark.long
def test_data_from_earlier_recordings(identified: Path) -> None:
    """NPZ and JSON hold the same information: one motion is worth the same; with it less is left to learn."""
    shape = f"{DESIGN} --fourier 2 --duration 4 --starts 1 --samples m.csv --sample-rate 1000"
    judge = f"{SCORE} m.csv --data-length 4"
    designed, _ = answered(f"{shape} --data-from r.npz")
    npz, _ = answered(f"{judge} --data-from r.npz")
    of_json, _ = answered(f"{judge} --data-from r.json --robot-parameters r.json")
    noise = ",".join(map(str, npz["torque_noise"]))
    alone, _ = answered(f"{shape.replace('m.csv', 'alone.csv')} --data-length 4 --torque-noise {noise}")
    assert of_json["torque_noise"] == pytest.approx(npz["torque_noise"])
    assert npz["criterion_value"] == pytest.approx(designed["criterion_value"], abs=2e-3)
    # The noise is that of the ordinary solution's errors, the covariance that of the weighted one's.
    assert of_json["criterion_value"] == pytest.approx(npz["criterion_value"], abs=0.03)
    base = json.loads((identified / "r.json").read_text())["base_parameters"]
    after, one = (np.array(list(data["predicted_sigma"].values())) for data in (designed, alone))
    assert (after <= 1.0001 * np.array([entry["sigma"] for entry in base])).all()
    # Two motions: one parameter or another may be shown better by the one that has everything to show.
    assert designed["criterion_value"] < alone["criterion_value"] - 0.3
    assert np.median(after / one) < 0.9


def test_ctrl_c_keeps_the_best_motion(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls, true = [0], DesignProblem.evaluate

    def evaluate(self: DesignProblem, *arguments: Any, **named: Any) -> Any:
        calls[0] += 1
        if calls[0] == 60:
            raise KeyboardInterrupt
        return true(self, *arguments, **named)

    monkeypatch.setattr(DesignProblem, "evaluate", evaluate)
    data, text = answered(f"{QUICK} {UNIT} --samples m.csv")
    assert "interrupted: this is the best motion so far; it keeps every limit" in text
    assert data["interrupted"]
    assert data["limits"]["met"]
    assert "interrupted" in Path("m.csv").read_text().split("\n")[2]


BALL = "--heaviest-payload 6@0,0,0.1 --within 0.2"
HELD = "near --robot ur10e --pose=0,-90,110,-110,-90,0 --joints 2,3,5,6 --duration 6"
JUDGED = "score --robot ur10e --columns payload"
REGIONS = ("0.2", "0.1,0.15,0.2", "box:0.1,0.1,0.1")


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A motion for every payload of a ball, a torque limit being active."""
    path = tmp_path_factory.mktemp("motion") / "n.csv"
    assert typed(f"{HELD} {BALL} --samples {path}").status == 0
    return path


@pytest.fixture(scope="module")
def sparse(motion: Path) -> Path:
    """The file with every 60th sample, and the last one."""
    lines = motion.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("t,")) + 1
    path = motion.with_name("sparse.csv")
    path.write_text("\n".join([*lines[:first], *lines[first:-1:60], lines[-1]]) + "\n")
    return path


@pytest.mark.parametrize("half", cases(REGIONS, lambda half: half == "0.2"))
def test_score_looks_between_samples(motion: Path, sparse: Path, half: str) -> None:
    """Every 60th sample tells of the same torques as all of them."""
    torques = []
    for path in (motion, sparse):
        data, _ = answered(f"{JUDGED} {path} {BALL.split(' --within')[0]} --within {half}")
        checks = data["limits"]["nearest"]
        torques.append(next(check["value"] for check in checks if check["name"].startswith("torque")))
    assert torques[1] == pytest.approx(torques[0], rel=0.01)


@pytest.mark.parametrize(
    "file", cases(("--val3 app", "--ros2 m.yaml", "--urscript m.script"), lambda file: file.startswith("--val3"))
)
def test_files_whose_controllers_break_a_limit_are_refused(here: Path, file: str) -> None:
    """Nothing is written or shown; with room left by --torque-margin the same file is written."""
    line = (
        "design --robot tx40 --columns payload --torque-noise 1% --via-points 4 --starts 1 --seed 2 "
        f"--acceleration 5x --heaviest-payload 2@0,0,0.05 --within 0.1 --segments trapezoid {file}"
    )
    error = refused(f"{line} --json m.json")
    assert "the motion does not keep its limits (torque with any payload up to 2 kg of joint" in error
    assert not list(here.iterdir())
    status, _, err = typed(f"{line} --torque-margin 30%")
    assert status == 0, err
    assert [path.name for path in here.iterdir()] == [file.split()[1]]


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
        largest, smallest = payloads.extremes(rows)[:, 0]
        assert (torque <= largest[:, None] + 1e-9).all()
        assert (torque >= smallest[:, None] - 1e-9).all()
        much = largest > 1.0
        assert np.median(torque.max(axis=1)[much] / largest[much]) > 0.95
