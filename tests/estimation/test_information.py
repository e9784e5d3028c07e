"""Information from earlier recordings, by the files of ``dynident identify``."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.results import read_information, recorded_noise
from dynident.common.errors import InputError
from dynident.common.schema import write_json
from dynident.estimation import PAYLOAD, robot_result
from dynident.estimation.equations.equations import Equations
from dynident.tests.report import made


def saved(path: Path, columns: tuple[str, ...], joints: int = 2) -> Equations:
    """Equations of random rows, in a file."""
    draw, c = np.random.default_rng(0), len(columns) + 1
    factors = tuple(np.asarray(np.linalg.qr(draw.standard_normal((60, c)), mode="r")) for _ in range(joints))
    equations = Equations(columns, factors, (60,) * joints, (48.0,) * joints)
    equations.save(path)
    return equations


def test_rows_weigh_by_noise_and_independence(tmp_path: Path) -> None:
    path = tmp_path / "r.npz"
    factors = saved(path, ("A", "B", "C")).factors
    assert recorded_noise(path) is None
    with np.load(path) as data:
        np.savez(path, weights=np.array([2.0, 4.0]), **dict(data))
    assert recorded_noise(path) == pytest.approx([0.5, 0.25])
    for noise in (np.array([2.0, 0.5]), None):
        information = read_information(path, noise)
        sizes = np.ones(2) if noise is None else noise
        expected = sum(0.8 * f[:, :3].T @ f[:, :3] / s**2 for f, s in zip(factors, sizes, strict=True))
        assert information.columns == ("A", "B", "C")
        assert information.factor.T @ information.factor == pytest.approx(expected)
    with pytest.raises(InputError, match="2 joints, not 3"):
        read_information(path, np.ones(3))
    with pytest.raises(InputError, match="have no payload"):
        read_information(path, None).of_payload(PAYLOAD)


def test_json_holds_the_covariance(tmp_path: Path) -> None:
    path, result = tmp_path / "r.json", made.identification()
    write_json(path, robot_result(result))
    noise = recorded_noise(path)
    assert noise == pytest.approx(1.0 / result.estimate.weights)
    factor = read_information(path, noise).factor
    assert np.linalg.inv(factor.T @ factor) == pytest.approx(result.estimate.covariance)
    with pytest.raises(InputError, match="holds no unweighted rows"):
        read_information(path, None)


def test_payload_with_the_robot_known(tmp_path: Path) -> None:
    path, names = tmp_path / "p.npz", tuple("abcdefghij")
    (factor,) = saved(path, ("ZZ1", *PAYLOAD), 1).factors
    information = read_information(path, None).of_payload(names)
    assert information.columns == names
    assert information.factor.T @ information.factor == pytest.approx(0.8 * factor[:, 1:11].T @ factor[:, 1:11])


@pytest.mark.parametrize(
    ("name", "words"), [("x.txt", "dynident identify"), ("x.npz", "not a saved reduced problem")]
)
def test_files_that_are_neither(name: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("hello")
    with pytest.raises(InputError, match=words):
        read_information(tmp_path / name, None)
