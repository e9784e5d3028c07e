"""``dynident design``, ``near`` and ``score``: what is asked for arrives, what is written, and how it is judged."""

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands import near
from dynident.apps.commands.options.motions import payload_bounds, region
from dynident.apps.report.sections.motion import ladder_tables
from dynident.common.errors import InputError
from dynident.model import InertialParameters, Robot, load_robot, payload_regressor, robot_names
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import answered, parsed, refused, typed
from dynident.tests.report.motions import motion_parsers as read
from dynident.tests.selection import cases
from dynident.tests.trajectories.bodies import dense, drawn_points
from dynident.trajectories import (
    RX90_NOISE,
    DesignProblem,
    NearMotion,
    PayloadSet,
    Simulator,
    Trapezoid,
    ViaPoints,
    random_via_points,
)
from dynident.trajectories.design.full_trajectory import Rung

DESIGN, SCORE = "design --robot rx90", "score --robot rx90"
QUICK = f"{DESIGN} --columns payload --via-points 4 --starts 1 --seed 2"
"""A design problem of a second."""
UNIT = "--torque-noise 1,1,1,1,1,1"
NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"
SCENE = """
clearance = 0.01
pairs = [["tool", "column"]]
surfaces = [{name = "floor", offset = -0.42}]
[[bodies]]
name = "column"
link = 0
radius = 0.2
start = [0, 0, -0.42]
end = [0, 0, 0.1]
[[bodies]]
name = "tool"
link = 6
radius = 0.12
start = [0, 0, 0.2]
"""


@pytest.mark.long
def test_every_file(here: Path) -> None:
    files = "--samples m.csv --ros2 m.yaml --urscript m.script --val3 excite plots=plots"
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
def test_trapezoids_of_fixed_durations(here: Path) -> None:
    """The JSON's numbers give the motion of the CSV, which is judged as the design was."""
    goal = f"--columns payload --criterion cond-scaled {UNIT}"
    shape = "--segments trapezoid ramp=0.2 segment-durations=1,1.5,2"
    data, _ = answered(f"{QUICK} {goal} {shape} --samples m.csv --val3 excite sample-rate=1000")
    motion = data["motion"]
    assert (motion["segments"], motion["ramp"], motion["speeds"]) == ("trapezoid", 0.2, None)
    assert motion["durations"] == [1.0, 1.5, 2.0]
    samples = read.csv_samples(Path("m.csv").read_text())
    plan = ViaPoints(np.array(motion["points"]), np.array(motion["durations"]), segment=Trapezoid(motion["ramp"]))
    assert np.abs(samples.q - plan.at(samples.t)[0]).max() < 1e-8
    scaled = data["condition_number_scaled"]
    assert data["val3_replay"]["condition_number_scaled"] == pytest.approx(scaled, rel=0.05)
    judged, _ = answered(f"{SCORE} {goal} m.csv")
    assert judged["limits"]["met"]
    assert judged["condition_number_scaled"] == pytest.approx(scaled, rel=5e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "shape"),
    [("--columns payload --criterion cond", "--via-points 4"), ("--criterion d", "--fourier 3 --duration 6")],
)
def test_a_designed_csv_is_judged_as_the_design_was(here: Path, goal: str, shape: str) -> None:
    designed, _ = answered(f"{DESIGN} {goal} {shape} {NOISE} --starts 1 --samples m.csv sample-rate=1000")
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


@pytest.mark.long
def test_a_log_is_judged(here: Path) -> None:
    """Filtered like a recording: noise on positions does not count as motion; in other words by a map."""
    motion = random_via_points(load_robot("rx90"), 10, seed=0).motion(250.0)
    draw, conditions = np.random.default_rng(0), []
    for name, noise in (("exact", 0.0), ("noisy", 1e-4)):
        q = motion.q + noise * draw.standard_normal(motion.q.shape)
        save(f"{name}.csv", motion.t, q, 0.0 * q, names="q,tau")
    save("own.csv", motion.t, np.degrees(motion.q), 0.0 * motion.q, names="deg_,amp_")
    Path("map.toml").write_text('[position]\ncolumns = "deg_{}"\nunit = "deg"\n[current]\ncolumns = "amp_{}"\n')
    for log in ("exact.csv", "noisy.csv", "own.csv --log-map map.toml"):
        conditions.append(answered(f"{SCORE} {log} --criterion cond").document["condition_number"])
    assert 20.0 < conditions[0] < 500.0
    assert conditions[1] == pytest.approx(conditions[0], rel=0.1)
    assert conditions[2] == pytest.approx(conditions[0], rel=1e-6)


@pytest.mark.long
def test_limits_torques_scene_and_start(here: Path) -> None:
    Path("scene.toml").write_text(SCENE)
    data, text = answered(
        f"{QUICK} --torque-noise 10% --torque-limits 300,300,120,50,40,20 acceleration=3x --speed-override 0.5 "
        "--heaviest-payload 4@0,0,0.1 scene=scene.toml --start 10,-70,60,0,45,0 --max-duration 12"
    )
    checks = {check["name"]: check for check in data["limits"]["nearest"]}
    torques = {"torque without payload", "torque with the heaviest payload"}
    assert set(checks) == {"position", "speed", "acceleration", "duration", "clearance"} | torques
    assert checks["clearance"]["value"] >= 0.01
    assert data["duration_s"] <= 12.0
    assert np.allclose(np.degrees(data["motion"]["points"][0]), [10, -70, 60, 0, 45, 0])
    assert data["torque_noise"] == pytest.approx([30, 30, 12, 5, 4, 2])
    speed = load_robot("rx90").joints[0].limits.speed
    assert np.abs(np.array(data["motion"]["speeds"])[:, 0]).max() <= 0.5 * speed
    assert "torque with the heaviest payload" in text


@pytest.mark.long
def test_the_floor_is_told(here: Path) -> None:
    data, text = answered(f"{QUICK} --criterion cond-scaled {UNIT} --bound")
    floor = data["floor"]
    assert floor["gap"] == pytest.approx(data["criterion_value"] - floor["criterion_value"])
    assert floor["gap"] >= -1e-6
    assert f"{np.exp(floor['gap']):.3g} times the floor's" in text


@pytest.mark.long
def test_criterion_a_for_some_parameters() -> None:
    values = []
    for goal in ("--criterion a parameters=ZZ1,IA5", "--criterion cond"):
        data, _ = answered(f"{DESIGN} {goal} --fourier 3 --duration 5 --starts 1 {NOISE}")
        values.append(np.hypot(*(data["predicted_sigma_percent"][name] for name in ("ZZ1", "IA5"))))
    assert values[0] < 0.8 * values[1]


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
    shape = f"{DESIGN} --fourier 2 --duration 4 --starts 1 --samples m.csv sample-rate=1000"
    judge = f"{SCORE} m.csv data-length=4"
    designed, _ = answered(f"{shape} --data-from r.npz")
    npz, _ = answered(f"{judge} --data-from r.npz")
    of_json, _ = answered(f"{judge} --data-from r.json --robot-parameters r.json")
    noise = ",".join(map(str, npz["torque_noise"]))
    alone, _ = answered(f"{shape.replace('m.csv', 'alone.csv')} data-length=4 --torque-noise {noise}")
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


@pytest.mark.long
def test_data_from_takes_the_length_of_fixed_segments(identified: Path) -> None:
    """One time for all of 4 points' moves, or each; a free motion has none."""
    line = f"{DESIGN} --data-from r.npz --via-points 4 --starts 1"
    for durations, length in (("1.5", 4.5), ("1,1.5,2.5", 5.0)):
        data, _ = answered(f"{line} segment-durations={durations}")
        assert data["data_length_s"] == length
        assert data["duration_s"] == pytest.approx(length)
    assert "--data-from needs data-length" in refused(line)


@pytest.mark.long
def test_limits_that_cannot_be_met_are_told_in_one_line(here: Path) -> None:
    error = refused(
        f"{DESIGN} --columns ZZ1,FV1,FS1,XX2,MX2,FV2,FS2 --fourier 2 --duration 4 --starts 1 "
        f"--torque-limits 300,20,120,50,40,20 {UNIT} --samples m.csv"
    )
    for words in ("no motion was found that keeps every limit", "torque of joint 2", "violated by"):
        assert words in error
    assert not list(here.iterdir())


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


@pytest.mark.long
def test_ctrl_c_while_the_floor_is_sought(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dynident.trajectories.floor_under", stopped)
    data, text = answered(f"{QUICK} {UNIT} --samples m.csv --bound")
    assert "interrupted: the floor is not known" in text
    assert data["floor"] is None
    assert Path("m.csv").exists()


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
    ("mass", "words"), [("6", "limits hold for every"), ("6.2", "limits do NOT hold for every")]
)
def test_what_is_said_of_the_bounds_is_what_was_seen(motion: Path, sparse: Path, mass: str, words: str) -> None:
    for path in (motion, sparse):
        _, text = answered(f"{JUDGED} {path} {BALL.replace('6@', f'{mass}@')}")
        assert words in text
        assert ("does NOT keep" in text) == ("NOT" in words)


@pytest.mark.parametrize(
    "file", cases(("--val3 app", "--ros2 m.yaml", "--urscript m.script"), lambda file: file.startswith("--val3"))
)
def test_files_whose_controllers_break_a_limit_are_refused(here: Path, file: str) -> None:
    """Nothing is written or shown; with room left by the setting torque-margin the same file is written."""
    line = (
        "design --robot tx40 --columns payload --torque-noise 1% --via-points 4 --starts 1 --seed 2 "
        f"acceleration=5x --heaviest-payload 2@0,0,0.05 --within 0.1 --segments trapezoid {file}"
    )
    error = refused(f"{line} --json m.json")
    assert "the motion does not keep its limits (torque with any payload up to 2 kg of joint" in error
    assert not list(here.iterdir())
    status, _, err = typed(f"{line} torque-margin=30%")
    assert status == 0, err
    assert [path.name for path in here.iterdir()] == [file.split()[1]]


def test_points_too_few_for_their_controller_are_refused(here: Path) -> None:
    """A point a second: the quintics between them leave the range about the pose."""
    error = refused(f"{HELD} {BALL} --ros2 m.yaml sample-rate=1 --samples m.csv")
    assert "as ROS 2 joins the samples the motion does not keep its limits (position of joint" in error
    assert not list(here.iterdir())


def test_nothing_told_of_the_payload_is_what_is_within_bounds() -> None:
    assert "Predicted for 2 kg" in answered(f"{HELD} --heaviest-payload 2@0,0,0.1 --within 0.1").text


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


@pytest.mark.parametrize(("option", "rate"), [("", 100.0), ("@40", 40.0)])
def test_samples_a_second_of_a_goal(rx90: Robot, option: str, rate: float) -> None:
    parts, _ = parsed(f"{DESIGN} --torque-noise 1,2,3,4,5,6{option}".split())
    goal = parts["goal"].goal(rx90, parts["limits"].of(rx90).bounds, {}, None)
    assert goal.rate == rate
    assert goal.noise == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])


def test_full_speed_of_a_ladder_bears_a_quarter_more_than_expected(rx90: Robot) -> None:
    line = "near --robot rx90 --pose 0,-90,90,0,0,0 --joints 2,3,5,6 --torque-limits 300 --ladder --mass 4"
    parts, _ = parsed(f"{line} --heaviest-payload 9@0,0,0.1 --within 0.1".split())
    loads = near._loads(parts["limits"].of(rx90), parts["options"])
    assert loads is not None
    assert isinstance(loads.heaviest, PayloadSet)
    assert loads.heaviest.mass == pytest.approx(1.25 * 4.0)


def test_a_ladder_shows_what_each_run_leaves_possible() -> None:
    still = np.zeros((1, 6, 2))
    run = NearMotion(np.zeros((1, 6)), still, still, 5.0, 1, 0.0)
    (table,) = ladder_tables([Rung(0.25, 6.5, 4.5, run)])
    assert [tuple(row) for row in table.rows] == [("run 1", "25", "6.50", "4.50")]


def test_a_sag_is_told_in_mrad(monkeypatch: pytest.MonkeyPatch, here: Path) -> None:
    sags = []

    def sagging(*arguments: object) -> None:
        sags.append(arguments[-1])
        raise InputError("that is enough")

    monkeypatch.setattr("dynident.trajectories.simulation.closed_loop.Controller.sagging", sagging)
    Path("body.toml").write_text(
        "mass = 3.0\ncom = [0.0, 0.0, 0.1]\ninertia_com = [0.01, 0.0, 0.0, 0.01, 0.0, 0.01]\n"
    )
    refused("simulate --robot rx90 --payload body.toml --controller proportional --sag 4 --out out")
    assert sags == [pytest.approx(4e-3)]
