"""Weighing on the command line, from the design to the exported file; one line for what cannot be."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import read_trajectory
from dynident.cli import main
from dynident.model import load_robot
from dynident.tests.commands.runs import runner

NEAR = ["--robot", "rx90", "--pose=0,-45,90,0,45,0", "--speed-override", "0.5"]
PAYLOAD = "mass = 7.02\ncom = [0.01, -0.02, 0.15]\ninertia_com = [0.03, 0, 0, 0.03, 0, 0.015]\n"


def designed(folder: Path, joints: str, *more: str) -> tuple[int, dict[str, Any]]:
    out = [
        "--samples",
        str(folder / "motion.csv"),
        "--json",
        str(folder / "motion.json"),
        "--sample-rate",
        "125",
        "--details",
    ]
    status = main(["near", *NEAR, "--joints", joints, "--duration", "12", *out, *more])
    path = folder / "motion.json"
    return status, json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


@pytest.fixture(scope="module")
def logs(shared: Callable[[str, Callable[[Path], object]], Path]) -> dict[str, str]:
    """Designed motions of arm and wrist, and of the wrist alone, run by a simulated controller."""

    def fill(folder: Path) -> None:
        (folder / "payload.toml").write_text(PAYLOAD, encoding="utf-8")
        for name, joints, known in (
            ("arm", "2,3,5,6", ()),
            ("wrist", "4,5,6", ("--mass", "7.02+-0.02")),
        ):
            (folder / name).mkdir()
            assert designed(folder / name, joints, *known)[0] == 0
            run = ["--trajectory", str(folder / name / "motion.csv"), "--payload", str(folder / "payload.toml")]
            out = ["--seed", "1", "--out", str(folder / name / "logs")]
            assert main(["simulate", "--robot", "rx90", *run, *out]) == 0

    folder = shared("weighing", fill)
    return {
        f"{name} {load}": str(folder / name / "logs" / f"motion_{load}.csv")
        for name in ("arm", "wrist")
        for load in ("unloaded", "loaded")
    }


def weigh(logs: dict[str, str], name: str, *more: str) -> int:
    pair = ["--unloaded", logs[f"{name} unloaded"], "--loaded", logs[f"{name} loaded"]]
    return main(["weigh", "--robot", "rx90", *pair, *more])


def test_visibility_and_sigma_before_any_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, document = designed(tmp_path, "2,3,5,6")
    text = capsys.readouterr().out
    assert status == 0
    assert "Visible to joints 2, 3, 5, 6: 10 of 10" in " ".join(text.split())
    assert document["visibility"]["rank"] == 10
    assert document["predicted_sigma"]["mass"] < 0.13
    assert max(document["predicted_sigma"]["com"]) < 8.4e-3
    assert (document["limits"]["max_violation"], document["limits"]["torque_checked"]) == (0.0, True)
    assert all(limit["room"] >= 0.0 for limit in document["limits"]["nearest"])
    assert "Assumed, not published: torque limits" in text
    robot = load_robot("rx90")
    fast, slow = (read_trajectory(tmp_path / f"motion{end}.csv", robot) for end in ("", "_rehearsal"))
    assert fast.qd is not None
    assert slow.qd is not None
    assert np.abs(slow.qd).max() == pytest.approx(0.1 * np.abs(fast.qd).max(), rel=1e-3)
    assert slow.t[-1] == pytest.approx(document["rehearsal_s"])
    assert "REHEARSAL" in (tmp_path / "motion_rehearsal.csv").read_text(encoding="utf-8")


@pytest.mark.long
def test_every_output_of_a_motion_near_a_pose(tmp_path: Path) -> None:
    files = {name: tmp_path / f"near.{name}" for name in ("csv", "yaml", "script", "html")}
    outputs = [
        "--samples",
        files["csv"],
        "--ros2",
        files["yaml"],
        "--urscript",
        files["script"],
        "--report",
        files["html"],
    ]
    plots, slow = tmp_path / "plots", tmp_path / "slow.csv"
    more = [*map(str, outputs), "--plots", str(plots), "--rehearsal", str(slow), "--sample-rate", "50"]
    assert main(["near", *NEAR, "--joints", "2,3,5,6", "--duration", "12", *more]) == 0
    assert {path.name for path in plots.iterdir()} == {"motion.pdf", "motion.png", "motion.svg"}
    texts = {name: path.read_text(encoding="utf-8") for name, path in files.items()}
    assert "servoj" in texts["script"]
    assert "positions" in texts["yaml"]
    for words in ("10 of 10", "Predicted for 3 kg", "Assumed, not published: torque limits", "REHEARSAL"):
        assert (words in texts["html"]) == (words != "REHEARSAL")
    assert texts["html"].count("<svg") == 1  # the motion
    robot = load_robot("rx90")
    fast, rehearsed = read_trajectory(files["csv"], robot), read_trajectory(slow, robot)
    assert np.diff(rehearsed.t[:2]) == pytest.approx(np.diff(fast.t[:2]))


def test_refused_before_any_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, document = designed(tmp_path, "4,5,6")
    printed = capsys.readouterr()
    assert (status, document) == (2, {})
    assert "mass not visible near this pose" in printed.err
    assert "9 of 10" in " ".join(printed.out.split())
    assert not (tmp_path / "motion.csv").exists()


@pytest.mark.long
def test_refused_after_the_motion_accepted_with_the_mass(
    logs: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "w.json"
    assert weigh(logs, "wrist", "--json", str(target)) == 2
    assert "mass not visible" in capsys.readouterr().err
    assert not target.exists()
    assert weigh(logs, "wrist", "--mass", "7.02+-0.02", "--json", str(target)) in (0, 1)
    document = json.loads(target.read_text(encoding="utf-8"))
    assert document["mass_from_scale"]
    assert document["quantities"]["mass"]["use"] == "weighed"
    assert document["visibility"]["parameters"]["M"] == "no"


@pytest.mark.long
def test_the_first_screen_leads_with_what_to_do(
    logs: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status = weigh(logs, "arm", "--mass", "7.02+-0.02")
    text = capsys.readouterr().out
    assert status == 0
    flat = " ".join(text.split())
    for words in (
        "mass kg 7.0",
        "Verdict: use",
        "in agreement",
        "Joint that agrees least",
        "For the controller: mass",
    ):
        assert words in flat
    assert "condition" not in flat
    assert "chi2" not in flat
    assert weigh(logs, "arm", "--details", "--plots", str(tmp_path / "figures")) == 0
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        f"{name}.{x}" for name in ("by_joints", "flange", "methods") for x in ("png", "svg", "pdf")
    }
    flat = " ".join(capsys.readouterr().out.split())
    assert "condition number" in flat
    assert "joints 2-3 kg" in flat


@pytest.mark.long
def test_assumed_inertia_is_labelled_down_to_the_controller(
    logs: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "w.json"
    assert weigh(logs, "arm", "--inertia", "box:60x60x350", "--json", str(target)) == 0
    assert "Inertia ASSUMED" in capsys.readouterr().out
    document = json.loads(target.read_text(encoding="utf-8"))
    assert document["quantities"]["inertia"]["use"] == "assumed"
    torques = document["constant_torques"]
    assert set(torques["joints"]) <= {2, 3}  # the arm's that move
    assert [sigma > 0.0 for sigma in torques["sigma"]] == [j in torques["joints"] for j in range(1, 7)]
    keys = {"source", "joint", "waves_per_turn", "amplitude", "probability_by_noise"}
    assert all(set(entry) == keys for entry in document["ripple"])
    assert "box" in document["assumed"]["inertia"]
    flange = ["--flange-frame", "0", "0", "0", "0", "0", "0"]
    for name in ("ur", "abb", "staubli", "urdf", "mjcf"):
        assert main(["export", str(target), "--to", name, *flange]) == 0
        printed = capsys.readouterr()
        assert "ASSUMED" in printed.out + printed.err
    main(["export", str(target), "--to", "staubli", *flange])
    lines = capsys.readouterr().out.splitlines()
    Izz = float(next(line for line in lines if line.startswith("Izz")).split()[-1])
    assumed = document["quantities"]["mass"]["value"] * (0.06**2 + 0.06**2) / 12.0
    assert Izz == pytest.approx(assumed, rel=2e-3)  # as many digits as the mass supports


@pytest.mark.long
def test_without_an_assumption_a_point_mass_is_exported(
    logs: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "w.json"
    assert weigh(logs, "arm", "--json", str(target)) == 0
    capsys.readouterr()
    assert main(["export", str(target), "--to", "staubli", "--flange-frame", *["0"] * 6]) == 0
    text = capsys.readouterr().out
    assert "ASSUMED" not in text
    assert not any(line.startswith("Izz") for line in text.splitlines())


@pytest.mark.long
@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--inertia", "ball:3"], "box:60x60x350"),
        (["--mass", "7"], "give one mass and its standard deviation"),
        (["--moving", "1,2"], "does not move"),
    ],
)
def test_wrong_options_of_weigh(
    logs: dict[str, str], more: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert weigh(logs, "arm", *more) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.startswith("dynident: error:")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--pose=0,0,90,0,45,0"], "give --joints"),
        (["--pose=0,0,90", "--joints", "2,3"], "give one each"),
        (["--pose=0,0,900,0,45,0", "--joints", "2,3,5"], "within the limits"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,9"], "has 6 joints"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--range", "30,20"], "one, or one for each"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--range=-3"], "one positive number"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--bound"], "Unknown option: --bound"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--mass", "3,4"], "give one mass"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--second-pose", "1,2"], "give one each"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--torque-noise", "1,2"], "6 positive numbers"),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--val3", "app"], "Unknown option: --val3"),
        (
            ["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--torque-noise", "@9"],
            "give sigma before the @",
        ),
        (["--pose=0,0,90,0,45,0", "--joints", "2,3,5", "--sample-rate", "100"], "has no effect without --samples"),
        (["--joints", "2,3"], "give --pose"),
        (["--rehearsal", "x.csv"], "give --pose"),
    ],
)
def test_wrong_options_of_near(more: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = runner(capsys, "near", "--robot", "rx90")(*more)
    assert status == 2
    errors = [line for line in err.splitlines() if "error:" in line]
    assert len(errors) == 1
    assert words in errors[0]


def test_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = np.arange(1000) / 100.0
    q = 0.4 * np.sin(np.outer(t, [1.3, 1.1, 1.7, 2.3, 0.9, 1.4]))
    names = ["t"] + [f"{prefix}{j}" for prefix in ("q", "tau", "qref") for j in range(1, 7)]
    for name, share in (("before", 1.0), ("after", 0.7)):
        error = 1e-3 * share * np.cos(np.outer(t, [2.0, 3.0, 2.5, 1.9, 2.2, 2.8]))
        table = np.column_stack([t, q, 30.0 * np.cos(q), q + error])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=",".join(names), comments="")
    before, after, target = (str(tmp_path / name) for name in ("before.csv", "after.csv", "v.json"))
    rx90 = ["verify", "--robot", "rx90"]
    assert main([*rx90, "--before", before, "--after", after, "--json", target]) == 0
    flat = " ".join(capsys.readouterr().out.split())
    assert "The following error fell by 30.0 %" in flat
    document = json.loads(Path(target).read_text(encoding="utf-8"))
    assert document["all"]["fall"] == pytest.approx(0.3, abs=1e-6)
    assert main([*rx90, "--before", after, "--after", before]) == 1
    assert "does harm" in capsys.readouterr().out
