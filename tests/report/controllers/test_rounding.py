"""How many digits of a document's numbers a controller gets."""

from typing import Any

import numpy as np
import pytest
from dynident.apps.export.controllers import FORMATS
from dynident.apps.export.load import load_of
from dynident.common.schema import convert
from dynident.estimation import PayloadResult
from dynident.model import InertialParameters

BODY = InertialParameters.from_com(3.001234, [0.02, 0.05, 0.11], np.diag([0.0123, 0.0234, 0.0301]))


def line_of(estimate: dict[str, Any], **more: Any) -> str:
    """The command of a Universal Robots controller for a document with one estimate of method 4."""
    document = {
        "frame": "tool0: flange",
        "estimates": [{"method": 4, "parameters": BODY.named()} | estimate],
        "verdict": {"level": "use", "reasons": []},
    }
    load = load_of(convert(document | more, PayloadResult), "p.json")
    return FORMATS["ur"].text(load).splitlines()[-1]


def test_an_assumed_inertia_is_not_rounded_by_what_was_measured() -> None:
    """The measured one is hardly known; the assumed one keeps its digits, the mass those of its interval."""
    loose = np.tile([-0.4, 0.6], (3, 3, 1)).tolist()
    measured = {"estimator": "constrained", "interval95": {"M": [2.97, 3.03]}, "inertia_com_interval95": loose}
    assumed = {"inertia": "box 100 x 100 x 100 mm", "parameters": BODY.named()}
    line = line_of(measured, recommended={"method": 4}, assumed=assumed)
    assert line.startswith("set_target_payload(3.001,")
    inertia = [float(number) for number in line.removesuffix("])").rpartition("[")[2].split(",")]
    assert inertia == pytest.approx([0.0123, 0.0234, 0.0301, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("sigma", "mass"), [(0.02, "3.001"), (0.06, "3.0"), (0.006, "3.001")])
def test_digits_of_a_free_estimate_are_those_of_two_sigma(sigma: float, mass: str) -> None:
    """Two digits of half the interval, 0.04, 0.12 and 0.012 kg."""
    assert line_of({"estimator": "wls", "sigma": {"M": sigma}}).startswith(f"set_target_payload({mass},")
