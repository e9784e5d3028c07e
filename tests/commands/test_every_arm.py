"""Every shipped arm goes through every command as shipped, with noise on its recordings."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from dynident.model import Robot, load_robot, robot_names, with_stand_in
from dynident.tests.commands.runs import Run, runner

FORMAT = {"ur10e": "ur", "panda": "franka", "tx40": "staubli", "rx90": "staubli"}
NOISE = "0.02"
_ANSWERED = (0, 1)
"""An answer was given: to be used, or not."""


class Arm:
    """An arm, the files that its commands write, and the last command's words."""

    def __init__(self, name: str, folder: Path, run: Run) -> None:
        self.robot, self.folder, self.run = load_robot(name), folder, run

    def path(self, name: str) -> str:
        return str(self.folder / name)

    def told(self, *words: str) -> str:
        """What a command prints; it answers, and no traceback is among its words."""
        status, out, err = self.run(words[0], "--robot", self.robot.name, *words[1:])
        assert status in _ANSWERED, f"{' '.join(words)}: {err}"
        assert "Traceback" not in out + err, err
        return out

    def written(self, name: str) -> dict[str, object]:
        return dict(json.loads(Path(self.path(name)).read_text(encoding="utf-8")))


def pose(robot: Robot) -> str:
    """A bent pose about the middle of the ranges, in degrees."""
    ranges = np.degrees([joint.limits.position for joint in robot.joints])
    return ",".join(f"{value:.1f}" for value in ranges.mean(axis=1) + 0.075 * np.ptp(ranges, axis=1))


def half_the_rating(robot: Robot) -> str:
    """A payload file."""
    mass = 0.5 * robot.rated_payload
    moments = ", ".join(f"{value * mass:.6g}" for value in (0.004, 0, 0, 0.003, 0, 0.002))
    return f"mass = {mass:g}\ncom = [0.02, -0.02, 0.08]\ninertia_com = [{moments}]\n"


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name in ("panda", "ur10e") else name for name in robot_names()],
)
@pytest.mark.usefixtures("hasty")
def test_an_arm_goes_through_every_command(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Shown, weighed near a pose, moved, simulated, checked, identified, written for a controller."""
    arm = Arm(name, tmp_path, runner(capsys))
    robot, path = arm.robot, arm.path
    Path(path("load.toml")).write_text(half_the_rating(robot), encoding="utf-8")
    shown = arm.run("robot", "show", "--robot", name)
    assert shown[0] == 0
    assert "assumed" in shown[1]
    assert "Mass of the arm" in shown[1]

    joints = "2,4,6,7" if robot.n == 7 else "2,3,5,6"
    near = arm.told(
        "near", f"--pose={pose(robot)}", "--joints", joints, "--range", "20", "--duration", "5", "--starts", "1",
        "--samples", path("near.csv"), "--sample-rate", "100", "--json", path("near.json"),
    )  # fmt: skip
    designed = arm.told(
        "design", "--fourier", "3", "--duration", "8", "--starts", "1", "--speed-override", "0.8",
        "--samples", path("wide.csv"), "--sample-rate", "100", "--json", path("wide.json"),
    )  # fmt: skip
    if robot.assumed("torque"):
        assert "torque limits" in near
        assert "torque limits" in designed
    for file in ("near.json", "wide.json"):
        assert arm.written(file)["assumed"] == robot.assumed("acceleration", "torque") | stand_in(robot)

    simulated = arm.told(
        "simulate", "--trajectory", path("wide.csv"), "--trajectory", path("near.csv"), "--payload",
        path("load.toml"), "--rate", "100", "--noise", NOISE, "--out", path("logs"),
    )  # fmt: skip
    assert robot.parameters or "Assumed" in simulated
    wide = ["--unloaded", path("logs/wide_unloaded.csv"), "--loaded", path("logs/wide_loaded.csv")]
    # The TX40's own recording comes at 1 kHz.
    rate = ["--equation-rate", "20"] if robot.processing.decimate > 50 else []
    arm.told("check", *rate, path("logs/wide_unloaded.csv"), path("logs/wide_loaded.csv"))
    # A page is drawn of the same numbers whatever arm they are of: one of seven joints, and one of coupled drives.
    page = ["--report", path("payload.html")] if name in ("panda", "rx90") else []
    arm.told("payload", *rate, *wide, "--json", path("payload.json"), *page)
    arm.told(
        "weigh", *rate, "--unloaded", path("logs/near_unloaded.csv"), "--loaded", path("logs/near_loaded.csv"),
        "--json", path("weighed.json"),
    )  # fmt: skip
    arm.told(
        "identify", *rate, "--data", path("logs/wide_unloaded.csv"), "--constrained", "base",
        "--json", path("robot.json"),
    )  # fmt: skip
    for file in ("payload.json", "weighed.json"):
        recommended = weighed_mass(arm.written(file))
        assert recommended == pytest.approx(0.5 * robot.rated_payload, rel=0.15), file
    status, out, err = arm.run(
        "export", path("payload.json"), "--to", FORMAT.get(name, "kuka"), "--despite-verdict"
    )
    assert status == 0, err
    assert out


def stand_in(robot: Robot) -> dict[str, str]:
    """What a design says of parameters that are not known."""
    return with_stand_in(robot).assumed("parameters")


def weighed_mass(document: dict[str, object]) -> float:
    """The recommended estimate's mass [kg]."""
    estimates, recommended = document["estimates"], document["recommended"]
    assert isinstance(estimates, list)
    assert isinstance(recommended, dict)
    candidates = [estimate for estimate in estimates if estimate["method"] == recommended["method"]]
    mass = candidates[-1]["parameters"]["M"]
    assert math.isfinite(mass)
    return float(mass)
