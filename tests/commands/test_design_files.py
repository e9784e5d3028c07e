"""``dynident design`` on the command line: what it writes, and how it judges a motion read back."""

from pathlib import Path

import numpy as np
import pytest
from dynident.model import load_robot
from dynident.tests.commands.runs import QUICK, Run, document, runner
from dynident.tests.report.motions import motion_parsers as read
from dynident.trajectories import Trapezoid, ViaPoints, random_via_points


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "design", "--robot", "rx90")


@pytest.fixture
def score(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "score", "--robot", "rx90")


@pytest.mark.long
def test_every_file(run: Run, tmp_path: Path) -> None:
    files = {
        "--json": "m.json", "--samples": "m.csv", "--ros2": "m.yaml", "--urscript": "m.script", "--val3": "excite",
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
    assert plots == {
        f"{name}.{ending}" for name in ("motion", "predicted_sigma") for ending in ("png", "svg", "pdf")
    }


@pytest.mark.long
def test_trapezoids_of_fixed_durations(run: Run, score: Run, tmp_path: Path) -> None:
    """The JSON's numbers give the motion of the CSV, which is judged as the design was."""
    names = [str(tmp_path / name) for name in ("m.csv", "m.json", "e.json")]
    goal = ("--columns", "payload", "--criterion", "cond-scaled", "--torque-noise", "1,1,1,1,1,1")
    shape = (*QUICK, "--segments", "trapezoid", "--ramp", "0.2", "--segment-durations", "1,1.5,2")
    options = ("--samples", names[0], "--json", names[1])
    status, _, err = run(*goal, *shape, *options, "--val3", str(tmp_path / "excite"), "--sample-rate", "1000")
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
    assert score(*goal, names[0], "--json", names[2])[0] == 0
    judged = document(Path(names[2]))
    assert judged["limits"]["met"]
    assert judged["condition_number_scaled"] == pytest.approx(data["condition_number_scaled"], rel=5e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "shape"),
    [
        (("--columns", "payload", "--criterion", "cond"), ("--via-points", "4")),
        (("--criterion", "d"), ("--fourier", "3", "--duration", "6")),
    ],
)
def test_a_designed_csv_is_judged_as_the_design_was(
    run: Run, score: Run, tmp_path: Path, goal: tuple[str, ...], shape: tuple[str, ...]
) -> None:
    names = [str(tmp_path / name) for name in ("m.csv", "m.json", "e.json")]
    noise = ("--torque-noise", "24,30,10.8,5.1,6.6,2.3")
    assert (
        run(
            *goal,
            *shape,
            *noise,
            "--starts",
            "1",
            "--samples",
            names[0],
            "--sample-rate",
            "1000",
            "--json",
            names[1],
        )[0]
        == 0
    )
    status, out, _ = score(*goal, *noise, names[0], "--json", names[2])
    assert status == 0
    designed, judged = document(Path(names[1])), document(Path(names[2]))
    assert judged["evaluated"] == names[0]
    assert "motion" not in judged
    assert judged["limits"]["met"]
    # The design's own grid has 120 samples a second here: the sign of a speed switches up to 8 ms away, which the
    # condition number in SI units and joint 2's sigmas feel most. At 240, 500, 1,000 and 2,000 samples a second
    # they are .9 to 1 and .7 to .8 % from the design's.
    for key in ("condition_number", "condition_number_scaled", "log_det", "duration_s"):
        error = 1.5e-2 if key == "condition_number" else 2e-3
        assert judged[key] == pytest.approx(designed[key], rel=error), key
        assert f"{judged[key]:.4g}" in out
    for name, sigma in designed["predicted_sigma"].items():
        assert judged["predicted_sigma"][name] == pytest.approx(sigma, rel=1e-2), name


def write_log(path: Path, noise: float) -> None:
    """Positions and torques as a controller writes them."""
    motion = random_via_points(load_robot("rx90"), 10, seed=0).motion(250.0)
    q = motion.q + noise * np.random.default_rng(0).standard_normal(motion.q.shape)
    header = ",".join(["t", *(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7))])
    np.savetxt(path, np.column_stack([motion.t, q, 0.0 * q]), delimiter=",", header=header, comments="")


@pytest.mark.long
def test_a_log_is_judged(score: Run, tmp_path: Path) -> None:
    """Filtered like a recording: noise on positions does not count as motion."""
    target, conditions = tmp_path / "log.csv", []
    for noise in (0.0, 1e-4):
        write_log(target, noise)
        status, _, _ = score(str(target), "--criterion", "cond", "--json", str(tmp_path / "e.json"))
        assert status == 0
        conditions.append(document(tmp_path / "e.json")["condition_number"])
    assert 20.0 < conditions[0] < 500.0
    assert conditions[1] == pytest.approx(conditions[0], rel=0.1)


@pytest.mark.long
def test_a_log_in_other_words_is_judged(score: Run, tmp_path: Path) -> None:
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
    conditions = []
    for options in (("log.csv",), ("own.csv", "--log-map", str(tmp_path / "map.toml"))):
        log, *more = options
        status, _, err = score(str(tmp_path / log), *more, "--json", str(tmp_path / "e.json"))
        assert status == 0, err
        conditions.append(document(tmp_path / "e.json")["condition_number"])
    assert conditions[1] == pytest.approx(conditions[0], rel=1e-6)
