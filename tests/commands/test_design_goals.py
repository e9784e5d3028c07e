"""``dynident design`` on the command line: limits, scenes, the floor, criteria, and what was learnt before."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.commands.runs import QUICK, Run, document, runner
from dynident.trajectories import random_via_points

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
    return runner(capsys, "design", "--robot", "rx90")


@pytest.fixture
def score(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "score", "--robot", "rx90")


@pytest.mark.long
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


@pytest.mark.long
def test_the_floor_is_told(run: Run, tmp_path: Path) -> None:
    options = ("--criterion", "cond-scaled", "--torque-noise", "1,1,1,1,1,1", "--json", str(tmp_path / "m.json"))
    status, out, _ = run(*QUICK, *options, "--bound")
    assert status == 0
    floor = document(tmp_path / "m.json")["floor"]
    value = document(tmp_path / "m.json")["criterion_value"]
    assert floor["gap"] == pytest.approx(value - floor["criterion_value"])
    assert floor["gap"] >= -1e-6
    assert f"{np.exp(floor['gap']):.3g} times the floor's" in " ".join(out.split())


@pytest.mark.long
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


@pytest.mark.long
def test_data_from_earlier_recordings(run: Run, score: Run, tmp_path: Path, identified: dict[str, str]) -> None:
    """NPZ and JSON hold the same information: one motion is worth the same; with it less is left to learn."""
    target, motion = tmp_path / "m.json", str(tmp_path / "m.csv")
    shape = ("--fourier", "2", "--duration", "4", "--starts", "1", "--samples", motion, "--sample-rate", "1000")
    judge = (motion, "--data-length", "4")
    npz = ("--data-from", identified["npz"])
    documents: dict[str, dict[str, Any]] = {}
    for name, options in {
        "designed": (*npz, *shape),
        "npz": (*npz, *judge),
        "json": ("--data-from", identified["json"], "--robot-parameters", identified["json"], *judge),
        "alone": (*shape, "--data-length", "4"),
    }.items():
        noise = () if name != "alone" else ("--torque-noise", ",".join(map(str, documents["npz"]["torque_noise"])))
        command = run if "--samples" in options else score
        status, _, err = command(*options, *noise, "--json", str(target))
        assert status == 0, err
        documents[name] = document(target)
    assert documents["json"]["torque_noise"] == pytest.approx(documents["npz"]["torque_noise"])
    assert documents["npz"]["criterion_value"] == pytest.approx(documents["designed"]["criterion_value"], abs=2e-3)
    # The noise is that of the ordinary solution's errors, the covariance that of the weighted one's.
    assert documents["json"]["criterion_value"] == pytest.approx(documents["npz"]["criterion_value"], abs=0.03)
    before = [entry["sigma"] for entry in document(Path(identified["json"]))["base_parameters"]]
    after, alone = (list(documents[name]["predicted_sigma"].values()) for name in ("designed", "alone"))
    assert (np.array(after) <= 1.0001 * np.array(before)).all()
    # Two motions: one parameter or another may be shown better by the one that has everything to show.
    assert documents["designed"]["criterion_value"] < documents["alone"]["criterion_value"] - 0.3
    assert np.median(np.array(after) / np.array(alone)) < 0.9


@pytest.mark.long
def test_data_from_takes_the_length_of_fixed_segments(run: Run, tmp_path: Path, identified: dict[str, str]) -> None:
    """One time for all of 4 points' moves, or each; a free motion has none."""
    target = tmp_path / "m.json"
    options = ("--data-from", identified["npz"], "--via-points", "4", "--starts", "1", "--json", str(target))
    for durations, length in (("1.5", 4.5), ("1,1.5,2.5", 5.0)):
        status, _, err = run(*options, "--segment-durations", durations)
        assert status == 0, err
        assert document(target)["data_length_s"] == length
        assert document(target)["duration_s"] == pytest.approx(length)
    status, _, err = run(*options)
    assert status == 2
    assert "--data-from needs --data-length" in err
