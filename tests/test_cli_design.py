"""``dynident design`` on the command line: files, figures, bad requests in one line, Ctrl-C."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.report.motions import motion_parsers as read
from dynident.trajectories import DesignProblem, Trapezoid, ViaPoints, random_via_points

Run = Callable[..., tuple[int, str, str]]
QUICK = ("--payload-only", "--via-points", "4", "--starts", "1", "--seed", "2")
"""A problem of a second."""
SCENE = """
clearance = 0.01
pairs = [["tool", "column"]]
[[surfaces]]
name = "floor"
offset = -0.42
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


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def runner(*arguments: str) -> tuple[int, str, str]:
        try:
            status = main(["design", "--robot", "rx90", *arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return runner


def document(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def test_every_file(run: Run, tmp_path: Path) -> None:
    files = {
        "--json": "m.json", "--csv": "m.csv", "--ros2": "m.yaml", "--urscript": "m.script", "--val3": "excite",
        "--plots": "plots",
    }  # fmt: skip
    options = [part for option, name in files.items() for part in (option, str(tmp_path / name))]
    status, out, err = run(*QUICK, "--criterion", "cond-scaled", "--torque-noise", "1,1,1,1,1,1", *options)
    assert status == 0
    assert err == ""
    data = document(tmp_path / "m.json")
    assert {
        "robot", "criterion", "condition_number", "condition_number_scaled", "predicted_sigma_percent",
        "duration_s", "cpu_s", "limits", "seed",
    } <= set(data)  # fmt: skip
    assert data["limits"]["max_violation"] == 0.0
    assert data["limits"]["met"]
    assert (data["criterion"], data["seed"], data["interrupted"]) == ("cond-scaled", 2, False)
    assert f"{data['condition_number_scaled']:.4g}" in out
    assert "met" in out
    motion = data["motion"]
    p, T, v, a = (np.array(motion[key]) for key in ("points", "durations", "speeds", "accelerations"))
    plan = ViaPoints(p, T, v, a)
    samples = read.csv_samples((tmp_path / "m.csv").read_text())
    assert np.abs(samples.q - plan.at(samples.t)[0]).max() < 1e-7
    assert np.allclose(read.ros2((tmp_path / "m.yaml").read_text())[1].q, samples.q, atol=1e-8)
    assert np.allclose(read.urscript((tmp_path / "m.script").read_text()).first, plan.points[0], atol=1e-8)
    application = {path.name: path.read_text() for path in (tmp_path / "excite").iterdir()}
    assert np.allclose(read.val3(application).points, np.degrees(plan.points), atol=1e-5)
    replay = data["val3_replay"]
    assert replay["condition_number_scaled"] > data["condition_number_scaled"] > 1.0
    assert f"{replay['duration_s']:.4g} s" in " ".join(out.split())
    plots = {path.name for path in (tmp_path / "plots").iterdir()}
    assert plots == {"arm.svg"} | {
        f"{name}.{ending}" for name in ("motion", "predicted_sigma", "poses") for ending in ("png", "svg")
    }


def test_trapezoids_of_fixed_durations(run: Run, tmp_path: Path) -> None:
    """The JSON's numbers give the motion of the CSV, which is judged as the design was."""
    names = [str(tmp_path / name) for name in ("m.csv", "m.json", "e.json")]
    goal = (*QUICK, "--criterion", "cond-scaled", "--segments", "trapezoid", "--torque-noise", "1,1,1,1,1,1")
    options = ("--ramp", "0.2", "--segment-durations", "1,1.5,2", "--csv", names[0], "--json", names[1])
    status, _, err = run(*goal, *options, "--val3", str(tmp_path / "excite"), "--sample-rate", "1000")
    assert (status, err) == (0, "")
    data = document(Path(names[1]))
    motion = data["motion"]
    assert (motion["segments"], motion["ramp"], motion["speeds"]) == ("trapezoid", 0.2, None)
    assert motion["durations"] == [1.0, 1.5, 2.0]
    samples = read.csv_samples(Path(names[0]).read_text())
    plan = ViaPoints(np.array(motion["points"]), np.array(motion["durations"]), segment=Trapezoid(motion["ramp"]))
    assert np.abs(samples.q - plan.at(samples.t)[0]).max() < 1e-8
    assert data["val3_replay"]["condition_number_scaled"] == pytest.approx(
        data["condition_number_scaled"], rel=0.05
    )
    assert run(*goal, "--evaluate", names[0], "--json", names[2])[0] == 0
    judged = document(Path(names[2]))
    assert judged["limits"]["met"]
    assert judged["condition_number_scaled"] == pytest.approx(data["condition_number_scaled"], rel=5e-3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--ramp", "0.2"), "--ramp has no effect without --segments trapezoid"),
        (("--segments", "trapezoid", "--ramp", "0.7"), "a ramp of 0.7 of a move's time"),
        (("--fourier", "3", "--ramp", "0"), "--ramp belongs to --via-points"),
        (("--fourier", "3", "--segments", "quintic"), "--segments belongs to --via-points"),
        (("--segment-durations", "1,2"), "fixed durations 1, 2: 14 via points need 13"),
        (("--segment-durations", "1", "--max-duration", "20"), "leave --max-duration out"),
    ],
)
def test_segments_that_cannot_be(run: Run, options: tuple[str, ...], words: str) -> None:
    status, out, err = run("--torque-noise", "1,1,1,1,1,1", *options)
    assert (status, out) == (2, "")
    assert words in err
    assert len(err.splitlines()) == 1


def test_same_seed_same_digits(run: Run, tmp_path: Path) -> None:
    texts = []
    for seed in ("5", "5", "6"):
        target = tmp_path / "m.csv"
        assert run(*QUICK[:-1], seed, "--csv", str(target), "--torque-noise", "1,1,1,1,1,1")[0] == 0
        texts.append(target.read_text())
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


@pytest.mark.parametrize(
    "goal",
    [
        ("--payload-only", "--criterion", "cond", "--via-points", "4"),
        ("--criterion", "d", "--fourier", "3", "--duration", "6"),
    ],
)
def test_a_designed_csv_is_judged_as_the_design_was(run: Run, tmp_path: Path, goal: tuple[str, ...]) -> None:
    names = [str(tmp_path / name) for name in ("m.csv", "m.json", "e.json")]
    noise = ("--torque-noise", "24,30,10.8,5.1,6.6,2.3")
    assert (
        run(*goal, *noise, "--starts", "1", "--csv", names[0], "--sample-rate", "1000", "--json", names[1])[0] == 0
    )
    status, out, _ = run(*goal, *noise, "--evaluate", names[0], "--json", names[2])
    assert status == 0
    designed, judged = document(Path(names[1])), document(Path(names[2]))
    assert judged["evaluated"] == names[0]
    assert "motion" not in judged
    assert judged["limits"]["met"]
    # The design's own grid has 120 samples a second here: the sign of a speed switches up to 8 ms away.
    for key in ("condition_number", "condition_number_scaled", "log_det", "duration_s"):
        assert judged[key] == pytest.approx(designed[key], rel=2e-3), key
        assert f"{judged[key]:.4g}" in out
    for name, sigma in designed["predicted_sigma"].items():
        assert judged["predicted_sigma"][name] == pytest.approx(sigma, rel=5e-3)


def write_log(path: Path, noise: float) -> None:
    """Positions and torques as a controller writes them."""
    motion = random_via_points(load_robot("rx90"), 10, seed=0).motion(250.0)
    q = motion.q + noise * np.random.default_rng(0).standard_normal(motion.q.shape)
    header = ",".join(["t", *(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7))])
    np.savetxt(path, np.column_stack([motion.t, q, 0.0 * q]), delimiter=",", header=header, comments="")


def test_a_log_is_judged(run: Run, tmp_path: Path) -> None:
    """Filtered like a recording: noise on positions does not count as motion."""
    target, found = tmp_path / "log.csv", []
    for noise in (0.0, 1e-4):
        write_log(target, noise)
        status, _, _ = run("--evaluate", str(target), "--criterion", "cond", "--json", str(tmp_path / "e.json"))
        assert status == 0
        found.append(document(tmp_path / "e.json")["condition_number"])
    assert 20.0 < found[0] < 500.0
    assert found[1] == pytest.approx(found[0], rel=0.1)


def test_a_log_in_other_words_is_judged(run: Run, tmp_path: Path) -> None:
    """Degrees, other names, currents: a map tells; gains do not matter to a motion."""
    write_log(tmp_path / "log.csv", 0.0)
    lines = (tmp_path / "log.csv").read_text().splitlines()
    table = np.loadtxt(lines[1:], delimiter=",")
    table[:, 1:7] = np.degrees(table[:, 1:7])
    header = ",".join(["s", *(f"{kind}_{j}" for kind in ("deg", "amp") for j in range(6))])
    np.savetxt(tmp_path / "own.csv", table, delimiter=",", header=header, comments="")
    (tmp_path / "map.toml").write_text(
        '[time]\ncolumn = "s"\n[position]\ncolumns = "deg_{0}"\nunit = "deg"\n[current]\ncolumns = "amp_{0}"\n'
    )
    found = []
    for options in (("log.csv",), ("own.csv", "--log-map", str(tmp_path / "map.toml"))):
        log, *more = options
        status, _, err = run("--evaluate", str(tmp_path / log), *more, "--json", str(tmp_path / "e.json"))
        assert status == 0, err
        found.append(document(tmp_path / "e.json")["condition_number"])
    assert found[1] == pytest.approx(found[0], rel=1e-6)


def test_limits_torques_scene_and_start(run: Run, tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE)
    status, out, err = run(
        *QUICK, "--torque-noise", "10%", "--torque-limits", "300,300,120,50,40,20", "--acceleration", "3x",
        "--speed-override", "0.5", "--heaviest-payload", "4@0,0,0.1", "--scene", str(scene), "--start",
        "10,-70,60,0,45,0", "--max-duration", "12", "--json", str(tmp_path / "m.json"),
    )  # fmt: skip
    assert status == 0, err
    data = document(tmp_path / "m.json")
    checks = {check["name"]: check for check in data["limits"]["nearest"]}
    assert set(checks) == {
        "position", "speed", "acceleration", "torque without payload", "torque with the heaviest payload",
        "duration", "clearance",
    }  # fmt: skip
    assert checks["clearance"]["value"] >= 0.01
    assert data["duration_s"] <= 12.0
    assert np.allclose(np.degrees(data["motion"]["points"][0]), [10, -70, 60, 0, 45, 0])
    assert data["torque_noise"] == pytest.approx([30, 30, 12, 5, 4, 2])
    speed = load_robot("rx90").joints[0].limits.speed
    assert np.abs(np.array(data["motion"]["speeds"])[:, 0]).max() <= 0.5 * speed
    assert "torque with the heaviest payload" in out


def test_the_floor_is_told(run: Run, tmp_path: Path) -> None:
    options = ("--criterion", "cond-scaled", "--torque-noise", "1,1,1,1,1,1", "--json", str(tmp_path / "m.json"))
    status, out, _ = run(*QUICK, *options, "--bound")
    assert status == 0
    floor = document(tmp_path / "m.json")["floor"]
    value = document(tmp_path / "m.json")["criterion_value"]
    assert floor["gap"] == pytest.approx(value - floor["criterion_value"])
    assert floor["gap"] >= -1e-6
    assert f"{np.exp(floor['gap']):.3g} times the floor's" in " ".join(out.split())


def test_limits_that_cannot_be_met_are_told_in_one_line(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "m.csv"
    status, out, err = run(
        "--columns", "ZZ1,FV1,FS1,XX2,MX2,FV2,FS2", "--fourier", "2", "--duration", "4", "--starts", "1",
        "--torque-limits", "300,20,120,50,40,20", "--torque-noise", "1,1,1,1,1,1", "--csv", str(target),
    )  # fmt: skip
    assert status == 2
    assert err.count("\n") == 1
    assert "no motion was found that keeps every limit" in err
    assert "torque of joint 2" in err
    assert "violated by" in err
    assert out == ""
    assert not target.exists()


def test_ctrl_c_keeps_the_best_motion(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls, true = [0], DesignProblem.evaluate

    def evaluate(self: DesignProblem, *arguments: Any, **named: Any) -> Any:
        calls[0] += 1
        if calls[0] == 60:
            raise KeyboardInterrupt
        return true(self, *arguments, **named)

    monkeypatch.setattr(DesignProblem, "evaluate", evaluate)
    target = tmp_path / "m.json"
    status, _, err = run(
        *QUICK, "--torque-noise", "1,1,1,1,1,1", "--json", str(target), "--csv", str(tmp_path / "m.csv")
    )
    assert status == 0
    assert "interrupted: this is the best motion so far; it keeps every limit" in err
    data = document(target)
    assert data["interrupted"]
    assert data["limits"]["met"]
    assert "interrupted" in (tmp_path / "m.csv").read_text().split("\n")[2]


def test_ctrl_c_while_the_floor_is_sought(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dynident.trajectories.floor_under", stopped)
    target = tmp_path / "m.json"
    options = ("--torque-noise", "1,1,1,1,1,1", "--json", str(target), "--csv", str(tmp_path / "m.csv"))
    status, _, err = run(*QUICK, *options, "--bound")
    assert status == 0
    assert "interrupted: the floor is not known" in err
    assert document(target)["floor"] is None
    assert (tmp_path / "m.csv").exists()


def test_criterion_a_for_some_parameters(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "m.json"
    options = ("--fourier", "3", "--duration", "5", "--starts", "1", "--torque-noise", "24,30,10.8,5.1,6.6,2.3")
    values = []
    for goal in (
        ("--criterion", "a", "--parameters", "ZZ1,IA5"),
        (
            "--criterion",
            "cond",
        ),
    ):
        assert run(*goal, *options, "--json", str(target))[0] == 0
        percent = document(target)["predicted_sigma_percent"]
        values.append(np.hypot(percent["ZZ1"], percent["IA5"]))
    assert values[0] < 0.8 * values[1]


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What ``dynident identify`` writes of a short recording."""
    from dynident.trajectories import RX90_NOISE, Simulator

    folder = tmp_path_factory.mktemp("identified")
    robot = load_robot("rx90")
    recording = Simulator(robot).record(random_via_points(robot, 14, seed=1).motion(250.0), None, RX90_NOISE)
    table = np.column_stack([recording.t, recording.q, recording.torque])
    header = ",".join(["t", *(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7))])
    np.savetxt(folder / "log.csv", table, delimiter=",", header=header, comments="")
    files = {"npz": str(folder / "r.npz"), "json": str(folder / "r.json")}
    main(["identify", "--robot", "rx90", "--data", str(folder / "log.csv"), "--constrained", "none",
          "--npz", files["npz"], "--json", files["json"]])  # fmt: skip
    return files


def test_data_from_earlier_recordings(run: Run, tmp_path: Path, identified: dict[str, str]) -> None:
    """NPZ and JSON hold the same information; with it less is left to learn."""
    target = tmp_path / "m.json"
    found: dict[str, dict[str, Any]] = {}
    shape = ("--fourier", "2", "--duration", "4", "--starts", "1")
    for name, options in {
        "npz": ("--data-from", identified["npz"]),
        "json": ("--data-from", identified["json"], "--robot-parameters", identified["json"]),
        "alone": ("--data-length", "4"),
    }.items():
        noise = () if name != "alone" else ("--torque-noise", ",".join(map(str, found["npz"]["torque_noise"])))
        status, _, err = run(*shape, *options, *noise, "--json", str(target))
        assert status == 0, err
        found[name] = document(target)
    assert found["json"]["torque_noise"] == pytest.approx(found["npz"]["torque_noise"])
    # The noise is that of the ordinary solution's errors, the covariance that of the weighted one's.
    assert found["json"]["criterion_value"] == pytest.approx(found["npz"]["criterion_value"], abs=0.03)
    before = [entry["sigma"] for entry in document(Path(identified["json"]))["base_parameters"]]
    after, alone = (list(found[name]["predicted_sigma"].values()) for name in ("npz", "alone"))
    assert (np.array(after) <= 1.0001 * np.array(before)).all()
    # Two motions: one parameter or another may be shown better by the one that has everything to show.
    assert found["npz"]["criterion_value"] < found["alone"]["criterion_value"] - 0.3
    assert np.median(np.array(after) / np.array(alone)) < 0.9


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--criterion", "e"), "invalid choice"),
        (("--via-points", "5", "--fourier", "3"), "not allowed with"),
        (("--via-points", "2"), "at least 3"),
        (("--fourier", "1"), "give at least 2"),
        (("--duration", "5"), "via points take --max-duration"),
        (("--fourier", "3", "--max-duration", "5"), "--fourier takes --duration"),
        (("--fourier", "3", "--rest"), "--rest belongs to --via-points"),
        (("--fourier", "3", "--val3", "x"), "Fourier motion has none"),
        (("--duration", "-1"), "not a number above 0"),
        (("--speed-override", "1.5"), "speed override is 1.5"),
        (("--acceleration", "0x"), "not a factor such as 3x"),
        (("--acceleration", "1,2"), "2 numbers for the 6 joints"),
        (("--torque-limits", "1,2"), "needs 6 positive numbers"),
        (("--torque-noise", "10%"), "needs a torque limit of every joint"),
        (("--torque-noise", "1,2"), "needs 6 positive numbers"),
        (("--start", "1,2,3"), "3 numbers for the 6 joints"),
        (("--start", "0,0,0,0,121,0"), "joint 5 at 121 deg is outside -105 to 120 deg"),
        (("--parameters", "XX9"), "XX9"),
        (("--parameters", "FV1,FV1"), "not a list of different names"),
        (("--columns", "XX1,ZZ1"), "XX1 has no effect"),
        (("--criterion", "cond", "--parameters", "FV1"), "counts for d and a only"),
        (("--payload-only", "--columns", "XX6"), "leave columns out"),
        (("--payload-only", "--criterion", "a"), "needs reference values"),
        (("--heaviest-payload", "7"), "give --torque-limits"),
        (("--heaviest-payload", "heavy", "--torque-limits", "1,1,1,1,1,1"), "give kg, kg@x,y,z (m), or a TOML"),
        (("--scene", "nowhere.toml"), "no such file"),
        (("--robot-parameters", "nowhere.json"), "no such file"),
        (("--data-from", "nowhere.npz"), "needs --data-length"),
        (("--data-from", "nowhere.npz", "--data-length", "9"), "no such file"),
        (("--evaluate", "nowhere.csv"), "no such file"),
        (("--evaluate", "nowhere.csv", "--csv", "x.csv"), "writes a designed motion"),
        (("--cutoff", "5"), "no effect without --evaluate"),
        (("--joint-names", "a,b"), "no effect without --ros2"),
        (("--joint-names", "a,b", "--ros2", "x.yaml"), "6 different names"),
        (("--sample-rate", "100"), "no effect without --csv or --ros2"),
        (("--urscript", "x", "--controller-rate", "250"), "500 Hz (e-Series) or 125 Hz"),
        (("--val3", "no-name"), "VAL3 application's name"),
        (("--csv", "nowhere/x.csv"), "not a file in a folder that exists"),
        (("--ros2", "nowhere/x.yaml"), "not a file in a folder that exists"),
        (("--starts", "0"), "at least 1"),
    ],
)
def test_bad_requests(
    run: Run, options: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line that says what is wrong, nothing written."""
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*options)
    assert status == 2
    errors = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert len(errors) == 1
    assert words in errors[0]
    assert out == ""
    assert list(tmp_path.iterdir()) == []
