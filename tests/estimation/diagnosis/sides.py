"""Evidence on either side of a threshold: one number that moves, and where the check begins to speak."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.diagnosis import verdict
from dynident.estimation.diagnosis.engine import Effect
from dynident.estimation.diagnosis.evidence import Agreement, Alternative, Evidence, Gained, KnownWeight
from dynident.estimation.diagnosis.finding import Finding
from dynident.estimation.diagnosis.hypotheses import WITH_PAYLOAD
from dynident.estimation.fit.estimate import Estimate
from dynident.estimation.gains.current_side import RelativeScales
from dynident.estimation.signals.alignment import AlignedPair
from dynident.model import Recording
from dynident.model.inertia import PayloadSpread
from dynident.tests.estimation.diagnosis.made import (
    MOMENTS,
    ROBOT,
    drift_of,
    estimate_of,
    evidence_of,
    of_payload,
    of_weighing,
    robot_of,
)

ONE_PERCENT = 2.5758
"""Standard deviations that a difference exceeds with a probability of 1 %."""
FIVE_PERCENT = 2.7764
"""Quantile of Student's t of 4 degrees of freedom that is exceeded, of either sign, with one of 5 %."""
OWN = float(MOMENTS.sum()) / 2.0


class Side(NamedTuple):
    """A threshold: evidence made of a number, the limit that is wrong to exceed, and what is then said."""

    check: str
    severity: str
    words: str
    make: Callable[[float], Evidence]
    limit: float
    below: bool = False
    """Whether it is wrong to stay below it."""


def rival(kind: str, name: str, fall: float, z: float = 9.0) -> Evidence:
    """Another way to take the recordings."""
    return of_payload(estimate_of(), alternatives=(Alternative(kind, name, fall, z),))


def scaled(joint: int, off: float, sigma: float) -> Evidence:
    """Torques with payload on another scale."""
    return of_payload(estimate_of(), scales=(scale_of(joint, off, sigma),))


def scale_of(joint: int, off: float, sigma: float, change: float = 0.0) -> Effect:
    """A scale of all loaded torques, or of one joint's, too small by ``off``; twice the torques change the mass."""
    effect = (5.0 - change) * np.eye(10)[:, 9:]
    where = f"joint {joint}" if joint else ""
    return Effect("scale", where, np.array([-off]), np.array([[sigma**2]]), effect, 0.0, -off, sigma)


def signals(off: float, sigma: float = 0.001) -> Evidence:
    """A robot alone whose second joint's torque has to be multiplied by exp(off)."""
    ratio, sigmas = np.exp(np.array([0.0, off, 0.0])), np.array([0.0, sigma, 0.01])
    return evidence_of(signals=RelativeScales(ratio, sigmas, 0))


def leaning_on(change: float, sigma: float, of_scale: float = 0.001) -> Evidence:
    """A mass, known to ``sigma`` [kg], that changes by so much [kg] with 1 % of the loaded torques' scale."""
    spread = PayloadSpread(sigma, np.full(3, 1e-3), np.full((3, 3), 1e-4))
    return of_payload(estimate_of(), scales=(scale_of(0, 0.0, of_scale, 100.0 * change),), spread=spread)


def lean_of(angle: float, sigma: float = 1e-4, effect: Array | None = None) -> Effect:
    """Gravity that leans by an angle [rad]; the effect on the ten by methods that model the robot."""
    values, none = np.array([0.6, 0.8]) * angle, np.zeros((10, 2))
    effect = none if effect is None else effect
    return Effect("tilt", "", values, sigma**2 * np.eye(2), effect, 0.0, angle, sigma, none)


def leaning(angle: float, sigma: float = 1e-4) -> Evidence:
    """A payload beside such a tilt."""
    return of_payload(estimate_of(), effects=(lean_of(angle, sigma),))


def beside(kind: str, size: float, z: float = 9.0, change: float = 0.0) -> Evidence:
    """Something else in the torques, that changes the mass by a share."""
    effect, sigma = 5.0 * change * np.eye(10)[:, 9:] / size, abs(size) / z
    found = Effect(kind, " with payload", np.array([size]), np.array([[sigma**2]]), effect, 0.0, size, sigma)
    return of_payload(estimate_of(), effects=(found,))


def hose(
    force: float,
    z: float = 9.0,
    fall: float = 0.1,
    change: float = 1.0,
    across: bool = False,
    where: str = WITH_PAYLOAD,
) -> Effect:
    """A pull at the flange of a share of the payload's weight, that changes the mass by a share."""
    effect, values = np.zeros((10, 4)), np.zeros(4)
    effect[9, int(across)] = 5.0 * change / 9.0
    values[int(across)] = z
    return Effect("pull", where, values, np.diag([1.0, 1.0, 1.0, 50.0]), effect, fall, force)


def pulling(force: float, z: float = 9.0, **more: Any) -> Evidence:
    """A payload beside such a pull."""
    return of_payload(estimate_of(), effects=(hose(force, z, **more),))


def apart(constant: float, changing: float = 0.0, second: float = 0.0) -> Evidence:
    """A pair whose third joint differs by a constant, and another one by something that changes [rad]."""
    t = np.linspace(0.0, 1.0, 50)
    bare, heavy = (Recording(t, np.zeros((50, 6)), np.zeros((50, 6)), source=name) for name in ("U", "L"))
    pair = AlignedPair(
        bare, heavy, 0.0, 0.1, 0.1, (0.0, 0.0, constant, 0.0, 0.0, 0.0), (0.0, 0.0, changing, second, 0.0, 0.0)
    )
    return Evidence(ROBOT, compared=(pair,))


def weighing_arm(share: float) -> Evidence:
    """An RX90 whose torques show this share of its weight."""
    moment = share * ROBOT_MASS * sum(float(np.hypot(joint.d, joint.r)) for joint in ROBOT.joints[1:])
    names, values = ("MX2", "MY2", "MX3", "MY3"), np.array([0.6 * moment, 0.0, 0.0, 0.4 * moment])
    parameters = Estimate(names, values, np.eye(4), 500.0, robot_of().fit, np.ones(6))
    return of_payload(estimate_of(), parameters=parameters)


ROBOT_MASS = 111.0
DRIFT = drift_of(9.0)


def weighed_apart(agreement: float) -> Evidence:
    way = Agreement("other way", 5.0 * (1.0 + agreement), np.full(3, np.nan))
    return of_weighing(agreement=(way,))


def of_motor(off: float, sigma: float) -> Evidence:
    """A third motor whose currents with payload are too small by a share."""
    return evidence_of(gained=Gained(np.full(3, 0.01), ()), scales=(scale_of(3, off, sigma),))


def of_weights(ratio: float, sigma: float) -> Evidence:
    """Two weights, the first of which weighs ``ratio`` times as much as was told, to ``sigma``."""
    weights = (KnownWeight(1, 2.0, 2.0 * ratio, 2.0 * ratio * sigma), KnownWeight(2, 4.0, 4.0, 1e-9))
    return Evidence(ROBOT, gained=Gained(np.full(3, 0.01), weights))


@pytest.fixture(autouse=True)
def one_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where causes are looked for, one is found that is not serious."""
    cause = Finding("warning", "L", "L looks as if q1 is late", True, 0.3)
    monkeypatch.setattr(verdict, "likely_causes", lambda *_: [cause])
    monkeypatch.setattr(verdict, "states_of", lambda _: None)
