"""Real UR10e and TX40 recordings: figures established independently, the pair's verdict, and wrong inputs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.estimation import (
    Gains,
    Identification,
    LongMotion,
    PayloadAnswer,
    Settings,
    answer_payload,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.alignment import aligned
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


def test_ur10e_payload_by_all_methods(ur10e: LongMotion) -> None:
    payloads = [payload_estimate(ur10e, method) for method in (1, 2, 3, 4)]
    masses = np.array([payload.mass for payload in payloads])
    assert np.abs(masses / MASS - 1.0).max() < 0.01
    assert np.ptp(masses) < 0.01 * MASS
    com = np.array([payload.body.com for payload in payloads])
    assert max(np.linalg.norm(a - b) for a in com for b in com) < 5e-3
    assert not any(payload.body.physically_consistent for payload in payloads)


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


Pair = tuple[Recording, Recording]


@pytest.fixture(scope="module")
def pair(recordings: Path) -> Pair:
    """Recordings without and with the payload."""
    names = ("unloaded", "loaded_2.805kg")
    bare, loaded = (
        read_recording(recordings / "ur10e" / f"{name}.csv.gz", load_robot("ur10e"), GAINS) for name in names
    )
    return bare, loaded


def answered(bare: Recording, loaded: Recording, robot: str = "ur10e") -> PayloadAnswer:
    return answer_payload(payload_problem(load_robot(robot), [loaded], [bare]))


@pytest.fixture(scope="module")
def answer(pair: Pair) -> PayloadAnswer:
    return answered(*pair)


def test_the_pair_gives_mass_and_centre_of_mass_without_a_conflict(answer: PayloadAnswer) -> None:
    assert answer.verdict.level == "mass_and_com_only"
    assert "inertia: not measured well enough" in answer.verdict.reasons[-1]
    assert not any(payload.conflict for payload in answer.constrained)
    assert min(payload.p_value for payload in answer.constrained) > 0.05
    assert abs(answer.recommended.mass / MASS - 1.0) < 0.015


def part(recording: Recording, start: float, length: float) -> Recording:
    t = recording.t - recording.t[0]
    keep = (t >= start) & (t < start + length)
    assert recording.qd is not None
    return replace(
        recording, t=recording.t[keep], q=recording.q[keep], torque=recording.torque[keep], qd=recording.qd[keep]
    )


@pytest.fixture(scope="module")
def windowed(recordings: Path) -> tuple[Recording, Recording, float]:
    """Without, with payload, and what the second's own time runs late [s]."""
    robot = load_robot("ur10e")
    names = ("unloaded", "loaded_2.805kg")
    bare, loaded = (read_recording(recordings / "ur10e" / f"{name}.csv.gz", robot, GAINS) for name in names)
    lag = aligned(bare, loaded, 100.0, 0.02).lag - (loaded.t[0] - bare.t[0])
    return bare, loaded, lag


def windows(
    windowed: tuple[Recording, Recording, float], length: float, starts: list[float]
) -> list[PayloadAnswer]:
    bare, loaded, lag = windowed
    robot, gains = load_robot("ur10e"), Gains((0.02,))
    return [
        answer_payload(
            difference_weighing(robot, [part(loaded, start + lag, length)], [part(bare, start, length)]),
            gains=gains,
        )
        for start in starts
    ]


@pytest.mark.long
@pytest.mark.parametrize(
    ("length", "within", "starts"),
    [(10.0, 0.06, [3.0, 9.0, 15.0, 21.0, 27.0, 33.0, 37.0, 41.0]), (20.0, 0.03, [4.0, 14.0, 24.0, 31.0])],
)
def test_windows(
    windowed: tuple[Recording, Recording, float], length: float, within: float, starts: list[float]
) -> None:
    answers = windows(windowed, length, starts)
    off = np.array([answer.mass / MASS - 1.0 for answer in answers])
    assert np.abs(off).max() <= within
    hits = [answer.mass_interval[0] <= MASS <= answer.mass_interval[1] for answer in answers]
    assert sum(hits) >= len(hits) - 1
