"""``dynident robot mjcf --passport``: a robot for a simulator by several identifications together."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps import fleet
from dynident.cli import main
from dynident.estimation import identify
from dynident.model import Recording, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Passports of two recordings of one robot, and what merging makes of them."""
    folder = tmp_path_factory.mktemp("pooled")
    simulator = Simulator(load_robot("rx90"))
    for seed, name in enumerate(("first", "second")):
        motion = random_via_points(simulator.robot, 14, seed=seed).motion(100.0)
        torque = simulator.measure(motion).torque
        noise = np.random.default_rng(seed).standard_normal(torque.shape) * np.array(RX90_NOISE)
        result = identify(simulator.robot, [Recording(motion.t, motion.q, torque + noise, motion.qd)])
        log = fleet.Log("without payload", f"{name}.csv", 64 * str(seed))
        recipe = fleet.Recipe("identify", simulator.robot.processing)
        fleet.write_passport(folder / f"{name}.npz", fleet.robot_passport(result, recipe, [log]))
    both = [str(folder / f"{name}.npz") for name in ("first", "second")]
    assert main(["passport", "merge", *both, "--out", str(folder / "merged.npz"), "--quiet"]) == 0
    return folder


def written(folder: Path, robot: str, *words: str) -> tuple[int, str]:
    """Status of the command, and what it wrote."""
    out = folder / "out.xml"
    out.unlink(missing_ok=True)
    status = main(["robot", "mjcf", "--robot", robot, *words, "--out", str(out)])
    return status, out.read_text() if out.exists() else ""


def numbers(text: str) -> np.ndarray:
    """All numbers of links and drives, in their order."""
    return np.array([float(value) for value in re.findall(r"value=(\S+) ", text)])


def passports(folder: Path, *names: str) -> list[str]:
    return [word for name in names for word in ("--passport", str(folder / f"{name}.npz"))]


@pytest.mark.long
def test_pooled_is_what_merging_gives(folder: Path) -> None:
    pooled, merged, alone = (
        written(folder, "rx90", *passports(folder, *names))
        for names in (("first", "second"), ("merged",), ("first",))
    )
    assert pooled[0] == merged[0] == alone[0] == 0
    assert "first.csv, second.csv" in pooled[1]
    first, second, third = (numbers(text) for _, text in (pooled, merged, alone))
    # The prior's weight is searched, from factors of other rounding.
    np.testing.assert_allclose(first, second, rtol=1e-4, atol=1e-7)
    assert not np.allclose(first, third, rtol=1e-4, atol=1e-7)


def test_what_cannot_be_pooled_is_refused(folder: Path, capsys: Any) -> None:
    several = ("--robot-parameters", "a.json", "--robot-parameters", "b.json")
    twice, single = passports(folder, "first", "first"), passports(folder, "first")
    refused = {
        "give --passport once for each": ("rx90", *several),
        "is in both passports": ("rx90", *twice),
        "of robot 'rx90', which is not 'tx40'": ("tx40", *single),
        "--robot-parameters or --passport": ("rx90", *several[:2], *single),
        "--prior-mass belongs to --passport": ("rx90", "--prior-mass", "20"),
    }
    for why, (robot, *words) in refused.items():
        assert written(folder, robot, *words) == (2, "")
        (line,) = capsys.readouterr().err.splitlines()
        assert why in line
