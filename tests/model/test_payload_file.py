"""A payload file holds a body that can exist, or is refused with the reason."""

from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import InertialParameters, read_payload


def read(folder: Path, text: str) -> InertialParameters:
    path = folder / "p.toml"
    path.write_text(text)
    return read_payload(path)


def test_both_forms_are_one_body(tmp_path: Path) -> None:
    inertia = np.array([[0.03, 0.001, 0.002], [0.001, 0.04, 0.003], [0.002, 0.003, 0.05]])
    body = InertialParameters.from_com(2.0, [0.01, 0.02, 0.1], inertia)
    com = read(
        tmp_path,
        "mass = 2\ncom = [0.01, 0.02, 0.1]\ninertia_com = [0.03, 0.001, 0.002, 0.04, 0.003, 0.05]\n",
    )
    ten = read(tmp_path, "[payload]\n" + "\n".join(f"{name} = {value!r}" for name, value in body.named().items()))
    assert np.allclose(com.vector, body.vector, atol=1e-15)
    assert np.allclose(ten.vector, body.vector, atol=1e-15)


def test_what_is_missing_is_zero(tmp_path: Path) -> None:
    body = read(tmp_path, "XX = 0.161\nYY = 0.161\nZZ = 0.035\nMZ = 1.003\nM = 7.025\n")
    assert body.mass == 7.025
    assert body.vector[1] == 0.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("M = -1", "no body has such parameters"),
        ("M = 1\nXX = 1.0", "no body has such parameters"),
        ("mass = 1\ncom = [0, 0]", "key 'com': must be a list of 3 numbers"),
        ("mass = 1\nM = 2", "key 'M': unknown"),
        ("M = 'heavy'", "key 'M': must be a finite number"),
        ("M = inf", "key 'M': must be a finite number"),
        ("M = [1]", "key 'M': must be a finite number"),
        ("payload = 3", "key 'payload': must be a table"),
        ("M = ", "not valid TOML"),
    ],
)
def test_what_is_no_payload_is_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, text)
    with pytest.raises(InputError, match="no such file"):
        read_payload(tmp_path / "nothing.toml")
