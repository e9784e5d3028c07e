"""Real UR10e and TX40 recordings: the figures that were established independently, with all rows of the UR10e.

The shipped description leaves slow rows out; what that gives stands beside them.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.estimation import Identification, LongMotion, Settings, identify, payload_estimate, payload_problem
from dynident.model import Processing, Recording, load_robot
from dynident.model.friction import PAPER

MASS = 2.805  # kg, weighed
GAINS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)


def ur10e_recording(folder: Path, name: str) -> Recording:
    return read_recording(folder / "ur10e" / f"{name}.csv.gz", load_robot("ur10e"), GAINS)


ALL_ROWS = replace(load_robot("ur10e").processing, slow_speed=0.0)


def ur10e_pair(folder: Path, processing: Processing) -> LongMotion:
    loaded, unloaded = (ur10e_recording(folder, name) for name in ("loaded_2.805kg", "unloaded"))
    return payload_problem(
        load_robot("ur10e"), [loaded], [unloaded], settings=Settings(processing, robust=False, friction=PAPER)
    )


def ur10e_identified(folder: Path, processing: Processing) -> Identification:
    unloaded, validation = (ur10e_recording(folder, name) for name in ("unloaded", "validation_unloaded"))
    return identify(
        load_robot("ur10e"), [unloaded], Settings(processing, robust=False, friction=PAPER), validation=[validation]
    )


@pytest.fixture(scope="module")
def ur10e(recordings: Path) -> LongMotion:
    return ur10e_pair(recordings, ALL_ROWS)


@pytest.fixture(scope="module")
def ur10e_robot(recordings: Path) -> Identification:
    return ur10e_identified(recordings, ALL_ROWS)


def test_ur10e_as_shipped(recordings: Path) -> None:
    """Rows slower than 0.05 rad/s are left out: residuals of the wrist fall to a third, masses come nearer."""
    robot = load_robot("ur10e")
    assert robot.processing.slow_speed == 0.05
    result = ur10e_identified(recordings, robot.processing)
    assert result.problem.equations == pytest.approx(2676, rel=0.01)
    assert result.problem.condition_numbers()[0] == pytest.approx(108.0, rel=0.05)
    assert result.estimate.fit.relative <= 0.033
    assert max(result.estimate.fit.relative_per_joint) <= 0.056
    assert result.validation is not None
    assert result.validation.relative <= 0.042
    pair = ur10e_pair(recordings, robot.processing)
    masses = np.array([payload_estimate(pair, method).mass for method in (1, 2, 3, 4)])
    assert np.abs(masses / MASS - 1.0).max() < 0.005


def test_ur10e_robot(ur10e_robot: Identification) -> None:
    inertial = [name for name in ur10e_robot.base.columns if name[:2] not in ("FS", "FV", "OF")]
    assert (len(ur10e_robot.base.columns), len(inertial)) == (58, 40)
    assert inertial[:3] == ["ZZ1", "XX2", "XY2"]
    assert inertial[-1] == "IA6"
    assert ur10e_robot.problem.equations == pytest.approx(3012, rel=0.01)
    assert ur10e_robot.problem.condition_numbers()[0] == pytest.approx(104.5, rel=0.05)
    assert ur10e_robot.estimate.fit.relative <= 0.039
    assert ur10e_robot.validation is not None
    assert ur10e_robot.validation.relative <= 0.045


def test_ur10e_stiction_shows_on_point_to_point_motion(recordings: Path, ur10e_robot: Identification) -> None:
    """Joint 6 often rests there: its friction is not that of sliding."""
    from dynident.estimation.fit.estimate import fit
    from dynident.estimation.fit.own_equations import base_problem

    robot = load_robot("ur10e")
    recording = ur10e_recording(recordings, "validation_point_to_point")
    check = fit(
        base_problem(robot, ur10e_robot.base, [recording], Settings(ALL_ROWS, robust=False)),
        ur10e_robot.estimate.values,
    )
    assert check.relative == pytest.approx(0.0428, abs=0.002)
    assert check.relative_per_joint[5] > 0.3


def test_ur10e_payload_by_all_methods(ur10e: LongMotion) -> None:
    payloads = [payload_estimate(ur10e, method) for method in (1, 2, 3, 4)]
    masses = np.array([payload.mass for payload in payloads])
    assert np.abs(masses / MASS - 1.0).max() < 0.01
    assert np.ptp(masses) < 0.01 * MASS
    com = np.array([payload.body.com for payload in payloads])
    assert max(np.linalg.norm(a - b) for a in com for b in com) < 5e-3
    assert not any(payload.body.physically_consistent for payload in payloads)


def test_ur10e_pair_is_aligned(ur10e: LongMotion) -> None:
    (pair,) = ur10e.pairs
    assert pair.lag == pytest.approx(1.18, abs=0.002)
    assert pair.rms_mismatch < 2e-4
    assert pair.max_mismatch < 2e-3


@pytest.fixture(scope="module")
def tx40(recordings: Path) -> dict[str, Identification]:
    robot = load_robot("tx40")
    recording = read_recording(recordings / "tx40" / "tx40.csv.gz", robot)
    return {
        form: identify(robot.with_coulomb(form), [recording], Settings(robust=False, friction=PAPER))
        for form in ("sum", "paper")
    }


def test_tx40_has_the_papers_structure(tx40: dict[str, Identification]) -> None:
    result = tx40["sum"]
    assert len(result.base.columns) == 54
    assert 2060 <= result.problem.equations <= 2100
    assert result.problem.condition_numbers()[0] == pytest.approx(291.0, rel=0.05)
    assert result.estimate.fit.relative <= 0.0545
    assert len(result.essential) in (26, 27, 28)


def test_tx40_decides_for_the_friction_of_the_sum(tx40: dict[str, Identification]) -> None:
    ratio = tx40["paper"].estimate.fit.relative_per_joint / tx40["sum"].estimate.fit.relative_per_joint
    assert (ratio[4:] >= 1.25).all()
    assert np.abs(ratio[:4] - 1.0).max() < 0.02
