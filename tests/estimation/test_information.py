"""Information from earlier recordings, by the files of ``dynident identify``."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.results import read_information, recorded_noise
from dynident.common.errors import InputError
from dynident.estimation import PAYLOAD
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.least_squares import weighted

COLUMNS = ("A", "B", "C")


@pytest.fixture
def problem() -> Equations:
    draw = np.random.default_rng(0)
    factors = tuple(np.asarray(np.linalg.qr(draw.standard_normal((60, 4)), mode="r")) for _ in range(2))
    return Equations(COLUMNS, factors, (60, 60), (48.0, 48.0))


@pytest.fixture
def npz(problem: Equations, tmp_path: Path) -> Path:
    problem.save(tmp_path / "r.npz")
    return tmp_path / "r.npz"


def test_rows_weigh_by_noise_and_independence(problem: Equations, npz: Path) -> None:
    noise = np.array([2.0, 0.5])
    information = read_information(npz, noise)
    expected = sum(0.8 * f[:, :3].T @ f[:, :3] / s**2 for f, s in zip(problem.factors, noise, strict=True))
    assert information.columns == COLUMNS
    assert np.allclose(information.factor.T @ information.factor, expected)
    plain = read_information(npz, None).factor
    assert np.allclose(plain.T @ plain, sum(0.8 * f[:, :3].T @ f[:, :3] for f in problem.factors))
    with pytest.raises(InputError, match="2 joints, not 3"):
        read_information(npz, np.ones(3))


def test_noise_is_one_over_the_weights(problem: Equations, npz: Path) -> None:
    assert recorded_noise(npz) is None
    with np.load(npz) as data:
        np.savez(npz, weights=np.array([2.0, 4.0]), **dict(data))
    noise = recorded_noise(npz)
    assert noise is not None
    assert np.allclose(noise, [0.5, 0.25])


def write_json(path: Path, problem: Equations) -> Path:
    """Write what ``identify --json`` has, as far as it is read."""
    estimate = weighted(problem)
    quality = {
        "degrees_of_freedom": 1.0, "error_norms": [1.0, 1.0], "torque_norms": [1.0, 1.0],
        "rows_per_joint": [60, 60], "weights": estimate.weights.tolist(),
    }  # fmt: skip
    values = [{"value": value} for value in estimate.values.tolist()]
    document = {
        "columns": list(COLUMNS), "base_parameters": values, "covariance": estimate.covariance.tolist(),
        "covariance_robust": None, "robust": None, "gain_sensitivity": None,
        "data": quality, "robot": "x", "robot_fingerprint": "y",
        "processing": {"drive_gains": None, "offsets": False, "coulomb": None},
    }  # fmt: skip
    path.write_text(json.dumps(document))
    return path


def test_json_holds_the_covariance(problem: Equations, tmp_path: Path) -> None:
    path = write_json(tmp_path / "r.json", problem)
    estimate = weighted(problem)
    noise = recorded_noise(path)
    assert noise is not None
    assert np.allclose(noise, 1.0 / estimate.weights)
    factor = read_information(path, noise).factor
    assert np.allclose(np.linalg.inv(factor.T @ factor), estimate.covariance)
    with pytest.raises(InputError, match="holds no unweighted rows"):
        read_information(path, None)


def test_files_that_are_neither(tmp_path: Path) -> None:
    text_file = tmp_path / "x.txt"
    text_file.write_text("hello")
    with pytest.raises(InputError, match="dynident identify"):
        recorded_noise(text_file)
    with pytest.raises(InputError, match="no such file"):
        read_information(tmp_path / "none.npz", None)
    bad = tmp_path / "bad.npz"
    bad.write_bytes(b"no")
    with pytest.raises(InputError, match="not a saved reduced problem"):
        read_information(bad, None)


def test_payload_with_the_robot_known(problem: Equations, tmp_path: Path) -> None:
    draw = np.random.default_rng(1)
    factor = np.asarray(np.linalg.qr(draw.standard_normal((60, 12)), mode="r"))
    Equations(("ZZ1", *PAYLOAD), (factor,), (60,), (60.0,)).save(tmp_path / "p.npz")
    names = tuple("abcdefghij")
    information = read_information(tmp_path / "p.npz", None).of_payload(names)
    assert information.columns == names
    assert np.allclose(information.factor.T @ information.factor, factor[:, 1:11].T @ factor[:, 1:11])
    problem.save(tmp_path / "r.npz")
    with pytest.raises(InputError, match="have no payload"):
        read_information(tmp_path / "r.npz", None).of_payload(names)
