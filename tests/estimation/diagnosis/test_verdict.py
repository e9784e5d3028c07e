"""The verdict: each check of the table on both sides of each of its thresholds, and what they say together."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.diagnosis import causes, checks, hypotheses, scales, verdict
from dynident.estimation.diagnosis.checks import COM_FLOOR, COM_SIGMA, INERTIA_SIGMA, MASS_SIGMA, judged
from dynident.estimation.diagnosis.engine import Effect
from dynident.estimation.diagnosis.evidence import (
    KNOWN_WELL,
    Agreement,
    Alternative,
    Evidence,
    Finding,
    NominalGravity,
    Weighed,
    error,
    warning,
)
from dynident.estimation.diagnosis.hypotheses import WHERE, WITH_PAYLOAD
from dynident.estimation.diagnosis.scales import CHANCE, disagreement
from dynident.estimation.diagnosis.verdict import BEFOREHAND, CHECKS, judge, verdict_of
from dynident.estimation.equations.equations import PAYLOAD
from dynident.estimation.fit.covariance import NORMAL95, few_blocks
from dynident.estimation.fit.estimate import Estimate, Fit
from dynident.estimation.payload.by_joints import ByJoints, JointsMass, Repeats
from dynident.estimation.payload.long_motion import Source
from dynident.estimation.payload.methods import ConstrainedPayload, PayloadEstimate
from dynident.estimation.payload.short_motion import Rests
from dynident.estimation.possible.constraints import Constraint, KnownMass, MassBounds, PossibleBody
from dynident.estimation.possible.intervals import NO_INTERVALS
from dynident.estimation.possible.payload import CONFLICT, Active, Weighing
from dynident.estimation.signals import filtering
from dynident.estimation.signals.filtering import AlignedPair
from dynident.model import InertialParameters, Recording, Robot, load_robot
from dynident.model.inertia import PayloadSpread, payload_spread
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import f

ROBOT = load_robot("rx90")
SOURCE = Source((), (), ROBOT.processing)
MOMENTS = np.array([0.05, 0.05, 0.03])
BODY = InertialParameters.from_com(5.0, [0.0, 0.02, 0.1], np.diag(MOMENTS))
SIZE = float(np.sqrt(np.trace(BODY.inertia) / 2.0 / 5.0))
SIGMA = np.array([1e-4] * 6 + [1e-3] * 3 + [1e-2])


def one_joint(share: float) -> Array:
    """Five joints that fit, and what is left of the third's torque."""
    return np.array([0.05, 0.05, share, 0.05, 0.05, 0.05])


def fit_of(shares: float | Array) -> Fit:
    """A fit that leaves these shares of six joints' torques."""
    return Fit(10.0 * np.broadcast_to(shares, 6), np.full(6, 10.0), (100,) * 6)


def robot_of(left: float | Array = 0.05, friction: tuple[float, ...] = (9.0, 9.0)) -> Estimate:
    """A robot's own parameters: the friction of joint 2, standard deviations of 1."""
    return Estimate(("FS2", "FV2"), np.array(friction), np.eye(2), 500.0, fit_of(left), np.ones(6))


def with_mass(mass: float) -> Array:
    """The payload's parameters with another mass."""
    return np.array([*BODY.vector[:9], mass])


def estimate_of(
    method: int = 4, ten: Array = BODY.vector, sigma: Array = SIGMA, left: float | Array = 0.05
) -> PayloadEstimate:
    """A method's estimate, its parameters uncorrelated."""
    estimate = Estimate(PAYLOAD, ten, np.diag(sigma**2), 500.0, fit_of(left), np.ones(6))
    return PayloadEstimate(method, estimate, "link 6")


@dataclass(frozen=True)
class _Result:
    """The parts of a constrained estimate that the checks look at."""

    body: InertialParameters
    p_value: float
    weighings: tuple[Weighing, ...]


def possible_of(
    free: PayloadEstimate,
    p_value: float = 0.5,
    tested: tuple[Active, ...] = (),
    weighings: tuple[Weighing, ...] = (),
    body: InertialParameters = BODY,
) -> ConstrainedPayload:
    """The possible payload that belongs to an estimate."""
    result: Any = _Result(body, p_value, weighings)
    return ConstrainedPayload(free, result, NO_INTERVALS, None, tested)


def evidence_of(**parts: Any) -> Evidence:
    """Evidence on an RX90."""
    return Evidence(ROBOT, **parts)


def of_payload(*estimates: PayloadEstimate, **more: Any) -> Evidence:
    """Evidence on a payload, the last estimate's body to be used."""
    return of_possible(*map(possible_of, estimates), **more)


def of_possible(*payloads: ConstrainedPayload, **more: Any) -> Evidence:
    """Evidence on possible payloads, the last of them to be used."""
    estimates = tuple(payload.free for payload in payloads)
    free = payloads[-1].free
    formula = payload_spread(free.ten, free.estimate.covariance, free.indices)
    spread = PayloadSpread(float(free.estimate.larger_sigma[9]), formula.com, formula.inertia_com)
    more = {"spread": spread} | more
    body = payloads[-1].body
    ten = np.array([*body.vector[:9], free.mass])
    more = {"judged": judged(ten, np.diag(body.inertia_com), more["spread"])} | more
    return evidence_of(estimates=estimates, constrained=payloads, recommended=payloads[-1], **more)


def spread_of(mass: float) -> PayloadSpread:
    """Standard deviations of a payload whose mass is as uncertain as this [kg]."""
    return PayloadSpread(mass, np.full(3, 1e-4), np.full((3, 3), 1e-6))


def of_weighing(*constrained: ConstrainedPayload, by_joints: ByJoints | None = None, **changed: Any) -> Evidence:
    """Evidence on a short weighing of 5 kg."""
    used = changed.pop("judged", dict.fromkeys(("mass", "centre of mass", "inertia"), ("use", "")))
    weighed, joints = Weighed(changed.pop("mass", 5.0), 0.01, False), by_joints or ByJoints((), ())
    more = {"unexplained": np.full(6, 0.1)} | changed
    return evidence_of(constrained=constrained, by_joints=joints, weighed=weighed, judged=used, **more)


def of_spread(mass: float = 0.01, com: float = 0.001, inertia: float = 1e-4) -> Evidence:
    """A weighing whose quantities are judged by these standard deviations."""
    spread = PayloadSpread(mass, np.full(3, com), np.full((3, 3), inertia))
    return of_weighing(judged=judged(BODY.vector, MOMENTS, spread))


def alone(left: float | Array) -> Evidence:
    """Residual of the model on a robot's own torque."""
    return Evidence(ROBOT, parameters=robot_of(left))


def leaving(left: float, own: float) -> Evidence:
    """Residuals of method 4, and of the robot alone."""
    return of_payload(estimate_of(left=left), parameters=robot_of(own))


def rubbing(*friction: float) -> Evidence:
    """Coulomb and viscous friction of joint 2."""
    return Evidence(ROBOT, parameters=robot_of(friction=friction))


def heavy(mass: float) -> Evidence:
    """A payload of some mass [kg], 10 g unsure."""
    return of_payload(estimate_of(ten=with_mass(mass)))


def known_to(*sigmas: float) -> Evidence:
    """Motors' gains, as unsure as this."""
    return Evidence(ROBOT, gained=np.array(sigmas))


def held_out(left: float, own: float) -> Evidence:
    """Residuals of a held-out recording, and of the robot's own."""
    return Evidence(ROBOT, parameters=robot_of(own), validation=fit_of(left))


def two_masses(apart: float, sigma: float = 1e-3) -> Evidence:
    """Methods 1 and 3, the second's mass larger [kg]."""
    deviations = np.array([*SIGMA[:9], sigma])
    return of_payload(*(estimate_of(k, with_mass(m), deviations) for k, m in ((1, 5.0), (3, 5.0 + apart))))


def spread_by(share: float) -> Evidence:
    """Two masses apart by a share of their mean."""
    return two_masses(5.0 * share / (1.0 - share / 2.0))


def com_sigma(sigma: float, size: float) -> Evidence:
    """A centre of mass this uncertain along x, of a payload of this size [m]."""
    body = InertialParameters.from_com(5.0, np.zeros(3), 4.0 * size**2 * np.diag([1.0, 1.0, 0.5]))
    deviations = np.array([1e-6] * 6 + [5.0 * sigma, 1e-5, 1e-5, 1e-4])
    return of_possible(possible_of(estimate_of(ten=body.vector, sigma=deviations), body=body))


def inertia_sigma(**sigmas: float) -> Evidence:
    """Standard deviations of single parameters of the inertia [kg m^2], the others certain."""
    deviations = np.full(10, 1e-9)
    for name, sigma in sigmas.items():
        deviations[PAYLOAD.index(f"{name}_L")] = sigma
    return of_payload(estimate_of(sigma=deviations))


def ratio(joint: int, share: float | None, sigma: float = float("nan")) -> JointsMass:
    """The payload ratio of a joint that does not see the mass alone."""
    return JointsMass((joint,), False, None, float("nan"), None, share, sigma)


def by_masses(
    *masses: tuple[float, float], without: float | None = None, make: Callable[..., Evidence] | None = None
) -> Evidence:
    """Masses that single joints show, from the second on, with their deviations, and that of the others."""
    rest = tuple(JointsMass((j,), True, without, 0.001, None) for j in (7, 8)) if without is not None else ()
    shown = tuple(JointsMass((j,), True, *mass, None) for j, mass in enumerate(masses, 2))
    return (make or usual)(by_joints=ByJoints(shown, rest))


def by_share(share: float, sigma: float = 0.001, without: float | None = None, **more: Any) -> Evidence:
    """The payload by the third joint, and the mass by the others."""
    rest = (JointsMass((1, 2, 4), True, without, 0.001, None),) if without is not None else ()
    shares = (ratio(1, 1.0, 0.01), ratio(3, share, sigma), ratio(4, None))
    return usual(by_joints=ByJoints(shares, rest), **more)


def mismatched(rms: float) -> Evidence:
    """A pair whose positions differ by this much [rad]."""
    t = np.linspace(0.0, 1.0, 50)
    bare, loaded = (Recording(t, np.zeros((50, 6)), np.zeros((50, 6)), source=name) for name in ("U", "L"))
    return Evidence(ROBOT, pairs=(AlignedPair(bare, loaded, 0.0, rms, rms),))


def active(p_value: float, constraint: Constraint | None = None) -> ConstrainedPayload:
    """A constraint that holds the answer back, with the probability of what that costs."""
    held = constraint or MassBounds(0.0, 4.9)
    return possible_of(estimate_of(), tested=(Active(held.description, 1.0, held, 3.0, p_value),))


def weighed_as(z: float) -> ConstrainedPayload:
    """A scale's mass, this many standard deviations of the difference away."""
    identified = Estimate.from_values(["M_L"], [5.0 + 0.05 * z], [0.04**2], 1e6)
    return possible_of(estimate_of(), weighings=(Weighing.by(KnownMass(5.0, 0.03), identified),))


def drift_of(z: float) -> float:
    """Rise of the mass of ``drifting`` altogether [kg]."""
    return 5.0 * z * 0.01 * float(np.sqrt(3.0 / 17.5))


def drifting(z: float, spread: PayloadSpread | None = None) -> Evidence:
    """Six weighings whose mass rises by this many standard deviations of the rise."""
    scatter = 0.01 * np.array([1.0, -2.0, 1.0, 1.0, -2.0, 1.0])  # without a slope of its own
    rise = z * 0.01 * np.sqrt(3.0 / 17.5) * np.arange(6)
    return of_weighing(repeats=Repeats.made("abcdef", (5.0 + rise + scatter).tolist(), (0.01,) * 6), spread=spread)


def standing(still: float, swing: float) -> Evidence:
    """A joint whose torque at rest spreads so far of that on the way, and oscillates so much more with payload."""
    wave, one = np.sin(2.0 * np.pi * np.arange(200.0) / 100.0)[:, None], np.ones((1, 1))
    rests = tuple(
        Rests(one, still * np.array([[-1.0], [1.0]]), one, one[0], (size * wave,), 100.0) for size in (1.0, swing)
    )
    parts = {"loaded": SimpleNamespace(torque_norms=one[0], rows=(1,)), "source": SimpleNamespace(unloaded=(0,))}
    problem: Any = SimpleNamespace(rests=rests, joints=(1,), one_sided=(), robot=SimpleNamespace(n=1), **parts)
    return Evidence(ROBOT, at_rest=problem)


ONE_PERCENT = 2.5758
"""Standard deviations that a difference exceeds with a probability of 1 %."""
FIVE_PERCENT = 2.7764
"""Quantile of Student's t of 4 degrees of freedom that is exceeded, of either sign, with one of 5 %."""


class Side(NamedTuple):
    """A threshold: what is said beyond the limit, and evidence made of a number."""

    severity: str
    words: str
    limit: float
    make: Callable[[float], Evidence]
    below: bool = False
    """True where it is wrong to stay below it."""


BELOW = True


def usual(**more: Any) -> Evidence:
    """A good payload by method 4, beside what is told of it."""
    return of_payload(estimate_of(), **more)


def rival(kind: str, name: str, fall: float, z: float = 9.0) -> Evidence:
    """Another way to take the recordings."""
    return usual(alternatives=(Alternative(kind, name, fall, z),))


def scaled(joint: int, off: float, sigma: float) -> Evidence:
    """Torques with payload on another scale."""
    return usual(scales=(scale_of(joint, off, sigma),))


def scale_of(joint: int, off: float, sigma: float, change: float = 0.0) -> Effect:
    """A scale of all loaded torques, or of one joint's, too small by ``off``; twice the torques change the mass."""
    effect = (5.0 - change) * np.eye(10)[:, 9:]
    where = f"joint {joint}" if joint else ""
    return Effect(where, np.array([-off]), np.array([[sigma**2]]), effect, 0.0, -off, sigma)


def leaning_on(change: float, sigma: float, of_scale: float = 0.001, apart: float = 1.0) -> Evidence:
    """A mass, known to ``sigma`` [kg], that changes by so much [kg] with 1 % of the loaded torques' scale.

    ``apart``: disagreement of the joints.
    """
    spread = PayloadSpread(sigma, np.full(3, 1e-3), np.full((3, 3), 1e-4))
    return usual(scales=(scale_of(0, 0.0, of_scale, 100.0 * change),), spread=spread, disagreement=apart)


def lean_of(angle: float, sigma: float = 1e-4, effect: Array | None = None) -> Effect:
    """Gravity that leans by an angle [rad]; the effect on the ten by methods that model the robot."""
    values, none = np.array([0.6, 0.8]) * angle, np.zeros((10, 2))
    effect = none if effect is None else effect
    return Effect("", values, sigma**2 * np.eye(2), effect, 0.0, angle, sigma, none)


def leaning(angle: float, sigma: float = 1e-4) -> Evidence:
    """A payload beside such a tilt."""
    return usual(effects={"tilt": lean_of(angle, sigma)})


def beside(kind: str, size: float, z: float = 9.0, change: float = 0.0) -> Evidence:
    """Something else in the torques, that changes the mass by a share."""
    effect, sigma = 5.0 * change * np.eye(10)[:, 9:] / size, abs(size) / z
    found = Effect(" with payload", np.array([size]), np.array([[sigma**2]]), effect, 0.0, size, sigma)
    return usual(effects={kind: found})


def lighter(part: float) -> Evidence:
    """A robot whose described gravity is a part less than Earth's, which the torques hardly contradict."""
    gravity = (0.0, 0.0, -hypotheses.EARTH / (1.0 + part))
    return replace(beside("weight", 0.9 * part, 3.0), robot=replace(ROBOT, gravity=gravity))


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
    return Effect(where, values, np.diag([1.0, 1.0, 1.0, 50.0]), effect, fall, force, groups=((0, 3), (1, 2)))


def pulling(force: float, z: float = 9.0, **more: Any) -> Evidence:
    """A payload beside such a pull."""
    return usual(effects={"pull": hose(force, z, **more)})


def apart(constant: float, changing: float = 0.0, second: float = 0.0) -> Evidence:
    """A pair whose third joint differs by a constant, and another one by something that changes [rad]."""
    t = np.linspace(0.0, 1.0, 50)
    bare, heavy = (Recording(t, np.zeros((50, 6)), np.zeros((50, 6)), source=name) for name in ("U", "L"))
    pair = AlignedPair(
        bare, heavy, 0.0, 0.1, 0.1, (0.0, 0.0, constant, 0.0, 0.0, 0.0), (0.0, 0.0, changing, second, 0.0, 0.0)
    )
    return Evidence(ROBOT, Source((), (), ROBOT.processing, (pair,)))


def weighing_arm(ratio: float, *others: float, explained: float = 0.9, sigma: float = 0.1) -> Evidence:
    """An RX90 on whose joints 2, 3 and 4 torques are so many times what the links' weight needs."""
    shown = np.append(np.nan, (ratio, *others, *([np.nan] * (5 - 1 - len(others)))))
    gravity = -9.81 * np.array([np.sin(0.5), 0.0, np.cos(0.5)])
    found = NominalGravity(shown, gravity, sigma, explained, 0.8, "")
    return usual(nominal=found)


DRIFT = drift_of(9.0)


def weighed_apart(agreement: float) -> Evidence:
    way = Agreement("other way", 5.0 * (1.0 + agreement), np.full(3, np.nan))
    return of_weighing(agreement=(way,))


def of_motor(off: float, sigma: float) -> Evidence:
    """A third motor whose currents with payload are too small by a share."""
    return evidence_of(gained=np.full(3, 0.01), scales=(scale_of(3, off, sigma),))


def of_weights(ratio: float, sigma: float) -> Evidence:
    """Two weights, the first of which weighs ``ratio`` times as much as was told, to ``sigma``."""
    weights = ((1, 2.0, 2.0 * ratio, 2.0 * ratio * sigma), (2, 4.0, 4.0, 1e-9))
    return Evidence(ROBOT, gained=np.full(3, 0.01), weights=weights)


@pytest.fixture
def one_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search for causes that finds one that is not serious."""
    cause = Finding("warning", "L", "L looks as if q1 is late", True, 0.3)
    monkeypatch.setattr(verdict, "likely_causes", lambda *_: [cause])
    monkeypatch.setattr(verdict, "states_of", lambda _: None)


SIDES: dict[str, list[tuple[Any, ...]]] = {
    "residual": [
        ("error", "the model leaves 25 %", checks.RESIDUAL, alone),
        ("error", "50 % of the torque of joint 3", checks.JOINT_RESIDUAL, lambda x: alone(one_joint(x))),
        ("error", "method 4 leaves 25 % of the torque unexplained", checks.RESIDUAL, lambda x: leaving(x, 0.2)),
        ("error", "of the torque with payload", checks.LOADED_RATIO, lambda x: leaving(0.05 * x, 0.05)),
        ("error", "of the torque with payload", checks.LOADED_RATIO, lambda x: leaving(0.01 * x, 0.001)),
        ("warning", "does not carry over", checks.VALIDATION_RATIO, lambda x: held_out(0.05 * x, 0.05)),
        ("warning", "does not carry over", checks.VALIDATION_FLOOR, lambda x: held_out(x, 0.01)),
        ("error", "does not carry over", checks.VALIDATION, lambda x: held_out(x, 0.19)),
    ],
    "parameters": [
        ("error", "friction of joint 2 comes out negative", -checks.DRIVEN_SIGMAS, lambda x: rubbing(x, -9.0)),
        ("note", "friction of joint 2 falls with speed", -checks.DRIVEN_SIGMAS, lambda x: rubbing(1.0, x)),
        ("warning", "no physical robot", CONFLICT, lambda x: evidence_of(possible=x), BELOW),
    ],
    "masses": [
        ("error", "mass is negative", -checks.SIGMAS, lambda x: heavy(0.01 * x)),
        ("error", "cannot be told from zero", checks.SIGMAS, lambda x: heavy(0.01 * x), BELOW),
        ("error", "mass is negative", -checks.SIGMAS, lambda x: of_weighing(mass=0.01 * x)),
        ("error", "cannot be told from zero", checks.SIGMAS, lambda x: of_weighing(mass=0.01 * x), BELOW),
        ("error", "masses range from 5 to", checks.MASS_SPREAD, spread_by),
        ("error", "methods 1 and 3 disagree", checks.METHODS_APART, spread_by),
        ("error", "methods 1 and 3 disagree", checks.SIGMAS, lambda x: two_masses(x * np.hypot(0.03, 0.03), 0.03)),
    ],
    "measured": [
        ("error", "1 sigma is 5 % ", MASS_SIGMA, lambda x: of_payload(estimate_of(sigma=np.full(10, 5.0 * x)))),
        ("error", "along x is 20 mm", COM_FLOOR, lambda x: com_sigma(x, 0.01)),
        ("error", "along x is 60 mm", COM_SIGMA, lambda x: com_sigma(0.2 * x, 0.2)),
        ("error", "the mass is not measured", MASS_SIGMA, lambda x: of_spread(mass=5.0 * x)),
        ("error", "the centre of mass is not measured", COM_SIGMA, lambda x: of_spread(com=SIZE * x)),
        ("warning", "the inertia is not measured", INERTIA_SIGMA, lambda x: of_spread(inertia=MOMENTS[2] * x)),
        ("warning", "30 % of YY", INERTIA_SIGMA, lambda x: inertia_sigma(YY=MOMENTS[1] * x)),
        ("error", "50 % of the torque of joint 3", checks.JOINT_RESIDUAL,
         lambda x: of_weighing(unexplained=one_joint(x))),
    ],
    "joints": [
        ("error", "joint 2 5.5", scales.WRONG, lambda x: by_masses((5.0 + 5.0 * x, 0.001))),
        ("error", "joint 2 5.9", scales.SIGMAS, lambda x: by_masses((5.0 + 0.2 * x, 0.2))),
        ("error", "joint 2 5 ± 0.001 kg, joint 3 5.15", scales.NOTABLE,
         lambda x: by_masses((5.0, 0.001), (5.0 + 5.0 * x, 0.001))),
        ("warning", "joint 2 5 ± 0.03 kg, joint 3 5.17", scales.NOTABLE_SIGMAS,
         lambda x: by_masses((5.0, 0.03), (5.0 + 0.05 * x, 0.04), without=5.0)),
        ("error", "joint 3 measures 1.15", scales.SHARE, lambda x: by_share(1.0 + x)),
        ("error", "joint 3 measures 0.85", scales.SHARE, lambda x: by_share(1.0 - x)),
        ("error", "joint 3 measures 1.23", scales.SIGMAS, lambda x: by_share(1.0 + 0.05 * x, 0.05)),
        ("note", "joint 3 most of all", scales.TOGETHER,
         lambda x: by_share(1.06, 0.05, without=5.0, disagreement=x)),
        ("error", "without joint 3 the mass is 5.0", 1.0,
         lambda x: by_share(1.3, without=5.0 + 0.01 * x * NORMAL95, spread=spread_of(0.009))),
        ("error", "an interval that covers all joints is ± 10 %", scales.USEFUL,
         lambda x: by_share(1.3, without=5.0, spread=spread_of(5.0 * x / NORMAL95))),
        ("error", "joint 2 5.5", scales.WRONG, lambda x: by_masses((5.0 + 5.0 * x, 0.001), make=of_weighing)),
    ],
    "scale": [
        ("error", "the scale of the torques", scales.SCALE, lambda x: scaled(0, x, 0.0)),
        ("error", "the scale of the torques", scales.SCALE_Z, lambda x: scaled(0, 0.1 * x, 0.1)),
        ("error", "scale of joint 3's torques", scales.JOINT_SCALE, lambda x: scaled(3, x, 0.0)),
        ("error", "scale of joint 3's torques", scales.JOINT_SCALE_Z, lambda x: scaled(3, 0.1 * x, 0.1)),
        ("note", "3.0 %, out of its interval", scales.SENSITIVE, lambda x: leaning_on(5.0 * x, 0.01)),
        ("note", "3.9 %, out of its interval", 1.96, lambda x: leaning_on(0.1 * x, 0.1)),
        ("note", "3.0 %, out of its interval", 3.0, lambda x: leaning_on(0.05, 0.001, x / 196.0)),
        ("note", "scale error of 5 %", 1.0, lambda x: leaning_on(0.03 * x, 0.001, 0.1)),
        ("error", "about the payload, and a scale", scales.TOGETHER, lambda x: leaning_on(0.2, 1e-3, apart=x)),
    ],
    "hypotheses": [
        ("error", "degrees too small", hypotheses.ZERO, lambda x: beside("zero", x)),
        ("error", "degrees too small", hypotheses.ZERO_Z, lambda x: beside("zero", 0.1, x)),
        ("error", "gravity of 10.1", hypotheses.WEIGHT, lambda x: beside("weight", x)),
        ("error", "gravity of 10.8", hypotheses.WEIGHT_Z, lambda x: beside("weight", 0.1, x)),
        ("error", "one scale: joint  with payload's is 1.2", hypotheses.GAIN, lambda x: beside("gain", x)),
        ("error", "joint  with payload's is 1.5", hypotheses.GAIN_Z, lambda x: beside("gain", 0.5, x)),
        ("note", "gravity is tilted by 0.5", hypotheses.TILT, leaning),
        ("note", "gravity is tilted by 2.9", hypotheses.TILT_Z, lambda x: leaning(0.05, 0.05 / x)),
        ("error", "gravity is tilted by", hypotheses.STEEP, leaning),
        ("error", "without it the mass would be 10 ± 0.6 kg", hypotheses.PULL, pulling),
        ("error", "(4.5 ± 1 N/m", hypotheses.ALONG_Z, lambda x: pulling(1.0, x)),
        ("error", "7 N to the side", hypotheses.PULL_Z, lambda x: pulling(1.0, x, across=True)),
        ("error", "(7.01 ± 1 N/m", hypotheses.PULL_Z, lambda x: pulling(1.0, x, where=WHERE[0])),
        ("warning", "lag the positions by 8", hypotheses.LATE, lambda x: beside("late", x)),
        ("warning", "lead the positions by 8", hypotheses.LATE, lambda x: beside("late", -x)),
        ("warning", "lag the positions by 20", hypotheses.LATE_Z, lambda x: beside("late", 0.02, x)),
        ("error", "moves by 10", hypotheses.SLIP, lambda x: beside("slip", x)),
        ("error", "moves by 50", hypotheses.SLIP_Z, lambda x: beside("slip", 0.05, x)),
        ("error", "mass grows", hypotheses.CHANGE, lambda x: beside("change", x)),
        ("error", "mass shrinks", hypotheses.CHANGE_Z, lambda x: beside("change", -0.5, x)),
    ],
    "new_zeros": [
        ("error", "q3 of L differs from that of U", filtering.OFFSET, apart),
        ("error", "constant -20.0", filtering.CONSTANT, lambda x: apart(-0.02, 0.02 * x), BELOW),
        ("error", "constant +50.0", filtering.CHANGING, lambda x: apart(0.05, 0.0, x), BELOW),
    ],
    "other_readings": [
        ("error", "the robot is 'ur5e'", causes.ROBOT, lambda x: rival("robot", "ur5e", x)),
        ("error", "the robot is 'ur5e'", causes.ROBOT_Z, lambda x: rival("robot", "ur5e", 0.1, x)),
        ("note", "'ur5e' would fit", causes.ALIKE, lambda x: rival("robot", "ur5e", -x), BELOW),
        ("error", "joint 5 has the opposite sign", causes.TURNED, lambda x: rival("turned", "5", x)),
        ("error", "joint 5 has the opposite sign", causes.TURNED_Z, lambda x: rival("turned", "5", 0.1, x)),
        ("error", "lack gravity", causes.WEIGHTLESS, lambda x: rival("weightless", "", x)),
    ],
    "weight": [
        ("error", "look like mN·m", scales.UNIT, weighing_arm),
        ("error", "look like motor-side", 1.0 / scales.UNIT, weighing_arm, BELOW),
        ("error", "torque of joint 2 has another scale", scales.GAIN, lambda x: weighing_arm(x, 1.0, 1.0)),
        ("error", "torque of joint 2 has another scale", 1.0 / scales.GAIN,
         lambda x: weighing_arm(x, 1.0, 1.0), BELOW),
        ("error", "acts 29 degrees away", 0.8 + scales.CLEARLY, lambda x: weighing_arm(1.0, explained=x)),
        ("error", "acts 29 degrees away", scales.SURE * 9.81,
         lambda x: weighing_arm(1.0, explained=1.0, sigma=x), BELOW),
        ("error", "Earth's is 9.81", hypotheses.WEIGHT, lighter),
    ],
    "conflicts": [
        ("error", "exceeds the arm's rated payload of 12 kg", NORMAL95, lambda x: heavy(1.02 * 12.0 + 0.01 * x)),
        *(
            ("error", words, limit, lambda x, make=make, held=held: make(held(x)), side)
            for make, method in ((of_weighing, "torques"), (of_possible, "method 4"))
            for words, limit, held, side in (
                (f"{method} contradict a constraint: mass", CONFLICT, active, BELOW),
                ("the scale shows 5 ± 0.03 kg", ONE_PERCENT, weighed_as, False),
                ("constraints together contradict", CONFLICT, lambda x: possible_of(estimate_of(), x), BELOW),
            )
        ),
    ],
    "other_ways": [
        ("error", "other way gives a mass of 5.25", checks.OTHER_WAY, weighed_apart),
        ("error", "mass drifts", FIVE_PERCENT, drifting),
        ("error", "mass drifts", 2.0 * 1.96, lambda x: drifting(9.0, spread_of(DRIFT / x))),
    ],
    "rests": [
        ("error", "a brake holds", checks.HOLDS, lambda x: standing(x, 1.0), BELOW),
        ("error", "the payload swings", checks.SWINGS, lambda x: standing(1.0, x)),
    ],
    "excitation": [
        ("warning", "U and L differ by 5.0 mrad", checks.MISMATCH, mismatched),
        ("warning", "nearly dependent", checks.CONDITION, lambda x: Evidence(ROBOT, condition=x)),
    ],
    "gains": [
        ("error", "known weights contradict", checks.APART, lambda x: of_weights(1.0 + x, 0.0001)),
        ("error", "known weights contradict", checks.APART_SIGMAS, lambda x: of_weights(1.05, 0.05 / x)),
        ("warning", "motor 2: the gain is known only to 5 %", KNOWN_WELL, lambda x: known_to(0.01, x, 0.01)),
        ("error", "use a heavier weight", KNOWN_WELL, lambda x: known_to(0.06, x, 0.06)),
        ("warning", "motor 3", scales.JOINT_SCALE, lambda x: of_motor(x, x / 4.0)),
        ("warning", "motor 3", scales.OWN_SCALE_Z, lambda x: of_motor(0.1, 0.1 / x)),
    ],
    "causes": [
        ("warning", "L looks as if q1 is late", causes.SUSPICIOUS,
         lambda x: of_payload(estimate_of(left=one_joint(x)), source=SOURCE)),
    ],
}  # fmt: skip
"""The rows of ``Side`` for each check."""
FUNCTIONS: dict[str, Callable[[Evidence], Iterable[Finding]]] = {
    check.__name__: check for check in (*CHECKS, *BEFOREHAND)
} | {"causes": lambda evidence: [finding for finding in judge(evidence).findings if finding.explains]}


def test_every_check_has_a_threshold_here() -> None:
    assert set(SIDES) == set(FUNCTIONS)
    assert len(FUNCTIONS) == len(CHECKS) + len(BEFOREHAND) + 1


ALL = [(name, Side(*row)) for name, rows in SIDES.items() for row in rows]


@pytest.mark.usefixtures("one_cause")
@pytest.mark.parametrize(("check", "side"), ALL, ids=[f"{name}: {side.words}" for name, side in ALL])
def test_a_check_speaks_on_one_side_of_its_threshold(check: str, side: Side) -> None:
    """And what it says reaches the verdict."""
    near, beyond = (1.001, 0.999) if side.below else (0.999, 1.001)
    quiet, loud = side.make(near * side.limit), side.make(beyond * side.limit)

    def said(evidence: Evidence) -> list[Finding]:
        found = FUNCTIONS[check](evidence)
        return [each for each in found if each.severity == side.severity and side.words in each.text]

    assert said(quiet) == []
    (finding,) = said(loud)
    told = judge(loud)
    assert finding in told.findings
    assert finding not in judge(quiet).findings
    partly = "mass_and_com_only" if loud.gained is None else "identified_only"
    assert told.level == {"error": "do_not_use", "warning": partly, "note": "use"}[side.severity]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_check_is_silent_about_what_was_not_computed(name: str) -> None:
    assert list(FUNCTIONS[name](Evidence(ROBOT))) == []


def test_a_delay_or_a_pull_that_moves_the_centre_of_mass_leaves_nothing() -> None:
    for share, severity in ((0.999, "warning"), (1.001, "error")):
        moved = share * hypotheses.SLIP * 5.0 * np.array([0.6, 0.0, 0.8])
        late = beside("late", 0.02).effects["late"]
        by_delay, by_pull = np.zeros((10, 1)), np.zeros((10, 4))
        by_delay[6:9, 0], by_pull[6:9, 0] = moved / 0.02, moved / 9.0
        both = {"late": late._replace(effect=by_delay), "pull": hose(1.0)._replace(effect=by_pull)}
        for effect in both.items():
            (finding,) = hypotheses.hypotheses(of_payload(estimate_of(), effects=dict([effect])))
            assert finding.severity == severity


def test_bursts_matter_that_move_the_mass_by_more_than_chance() -> None:
    for share, matters in ((0.999, False), (1.001, True)):
        for mass, sigma in ((5.0, 1e-3), (1e-3, 5.0 * hypotheses.MOVED / 2.0)):
            change = share * 5.0 * hypotheses.MOVED * np.eye(10)[:, 9:]
            effect = Effect("", np.ones(1), np.zeros((1, 1)), change, size=1, sigma=20)
            assert hypotheses.matter(effect, mass, sigma) is matters
            (finding,) = hypotheses.hypotheses(of_payload(estimate_of(), effects={"bursts": effect}))
            assert (finding.severity, "1 of 20 stretches" in finding.text) == ("note", True)


def test_a_mass_that_was_weighed_a_pull_or_a_scale_that_is_seen_leaves_nothing_to_say_of_scale() -> None:

    def unnoticed(evidence: Evidence) -> bool:
        return any("would go unnoticed" in finding.text for finding in scales.scale(evidence))

    plain = leaning_on(0.2, 1e-3)
    assert unnoticed(plain)
    (whole,) = plain.scales
    seen = replace(plain, scales=(scale_of(0, 30.0 * whole.sigma, whole.sigma),))
    assert len(list(scales.scale(seen))) == 1
    assert not unnoticed(seen)
    assert not unnoticed(replace(plain, effects={"pull": hose(1.0)}))
    assert not unnoticed(replace(plain, constrained=(weighed_as(0.0),)))


def test_a_robot_that_cannot_exist_is_a_reason_and_beside_another_one_leaves_nothing() -> None:
    for p_value, left, level in (
        (0.011, 0.05, "use"),
        (0.009, 0.05, "mass_and_com_only"),
        (0.009, 0.07, "do_not_use"),
    ):
        evidence = replace(held_out(left, 0.04), possible=p_value)
        assert judge(evidence).level == level


def test_good_evidence_is_used() -> None:
    good = of_payload(
        estimate_of(1), estimate_of(3), estimate_of(4), parameters=robot_of(), condition=10.0, source=SOURCE
    )
    assert judge(good).level == "use"
    assert judge(of_weighing()).level == "use"
    assert judge(good).reasons == judge(of_weighing()).reasons == ()


def test_bounds_that_hold_the_answer_are_told_and_possibility_is_not() -> None:
    for evidence in (of_possible(active(0.5)), of_weighing(active(0.5))):
        assert judge(evidence).reasons == (
            "the answer lies on a bound that you gave: mass from 0 to 4.9 kg; check its unit and frame",
        )
        assert judge(evidence).level == "mass_and_com_only"
    for evidence in (of_possible(active(0.5, PossibleBody())), of_weighing(active(0.5, PossibleBody()))):
        assert judge(evidence).level == "use"


def test_hidden_and_unknown_quantities() -> None:
    """Parameters that joints do not show are not visible; a payload of unknown size has 20 mm."""
    unknown = np.full(10, np.nan)
    for sigma, use in ((0.999 * COM_FLOOR, "use"), (1.001 * COM_FLOOR, "not measured well enough")):
        spread = PayloadSpread(0.01, np.full(3, sigma), np.eye(3))
        assert judged(unknown, MOMENTS, spread)["centre of mass"][0] == use
    hidden = judged(BODY.vector, MOMENTS, PayloadSpread(0.01, np.array([0.0, np.inf, 0.0]), np.eye(3)))
    assert hidden["centre of mass"] == ("not visible", "these joints do not show y")


def test_causes_are_looked_for_where_something_contradicts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then a smaller gain is told as well."""
    flags: list[bool] = []

    def likely(_: Robot, __: object, contradicted: bool, free_gains: bool) -> list[Finding]:
        flags.append(contradicted)
        return []

    monkeypatch.setattr(verdict, "likely_causes", likely)
    for evidence in (of_payload(estimate_of(), source=SOURCE), of_payload(estimate_of(left=0.2), source=SOURCE)):
        judge(evidence)
    judge(of_payload(estimate_of(ten=with_mass(-5.0)), source=SOURCE))
    assert flags == [False, True]


def test_the_scale_of_all_and_that_of_a_joint_are_told_where_either_may_be() -> None:
    """A joint's z of 10, and that of all on both sides of the share from which it explains them as well."""
    for z, words in (
        (0.999, "the scale of joint 4's torques"),
        (1.001, "the scale of all torques, or only those of joint 4,"),
    ):
        whole = scale_of(0, 0.1, 0.1 / (10.0 * z * scales.EITHER), 4.5)
        (finding,) = scales.scale(of_payload(estimate_of(), scales=(whole, scale_of(4, -0.1, 0.01, 5.5))))
        assert finding.text.startswith(words)
    assert "0.900 ± 0.015 or 1.100 ± 0.01 with payload" in finding.text
    assert "5.5 or 4.5 kg" in finding.text


def test_a_tilt_that_does_not_stand_out_moves_nothing() -> None:
    """But its mean square is in the covariance; one that does is taken out as far as it is believed."""
    for share, moved in ((0.999, False), (1.001, True)):
        lean = lean_of(share * hypotheses.TILT, 1e-4, np.eye(10)[:, :2])
        change, covariance = hypotheses.tilt_correction(lean, 4)
        assert change[:2] == pytest.approx(lean.values if moved else 0.0, rel=1e-3)
        square = lean.values[0] ** 2 * (not moved)
        assert covariance[0, 0] == pytest.approx(square + 1e-8, rel=1e-3)
        assert not hypotheses.tilt_correction(lean, 3)[0].any()


def test_a_pull_that_leaves_the_mass_as_it_is_speaks_against_the_inertia_alone() -> None:
    """The change of the mass and twice its deviation count: 5 kg (x + 2 x / 9) beside 2.5 % of 5 kg."""
    for share, severity in ((0.999, "warning"), (1.001, "error")):
        change = share * hypotheses.MOVED / (1.0 + 2.0 / 9.0)
        (finding,) = hypotheses.hypotheses(pulling(1.0, change=change))
        assert finding.severity == severity


def test_what_a_pull_explains_better_is_not_told() -> None:
    """A scale by fewer deviations, a robot and a turned joint that take off half; the next robot is no matter."""

    def hung(evidence: Evidence, z: float = 9.0) -> Evidence:
        return replace(evidence, effects={"pull": hose(1.0, z=z)})

    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 8.9), scales.scale),
        (rival("robot", "ur5e", 0.049), causes.other_readings),
        (rival("robot", "ur5e", 0.0), causes.other_readings),
        (rival("turned", "5", 0.049), causes.other_readings),
    ):
        assert list(check(evidence))
        assert not list(check(hung(evidence)))
        assert list(check(hung(evidence, 0.5)))
    for evidence, check in (
        (scaled(0, 0.1, 0.1 / 9.1), scales.scale),
        (rival("robot", "ur5e", 0.051), causes.other_readings),
        (rival("turned", "5", 0.051), causes.other_readings),
    ):
        assert list(check(hung(evidence)))


def test_another_robot_must_explain_more_than_more_friction_does() -> None:
    """One further friction column a joint on the robot as described."""
    for fall, count in ((0.019, 1), (0.021, 0)):
        both = (Alternative("robot", "ur5e", 0.02, 9.0), Alternative("friction", "", fall, 0.0))
        findings = causes.other_readings(of_payload(estimate_of(), alternatives=both))
        assert sum("the robot is 'ur5e'" in finding.text for finding in findings) == count
        assert sum("would fit" in finding.text for finding in findings) == 1 - count


def test_what_is_told_of_findings() -> None:
    """Against all first; of the rest, where nothing may be used, only causes unless all is asked for."""
    bad, vague, cause = error("bad"), warning("vague"), Finding("warning", "log", "cause", cause=True)
    note = Finding("note", "time", "uneven")
    assert verdict_of([note]).level == "use"
    assert verdict_of([note]).notes == ("uneven",)
    assert verdict_of([vague, vague, note]).reasons == ("vague",)
    assert verdict_of([vague, cause]).level == "mass_and_com_only"
    assert verdict_of([vague, cause, bad]).reasons == ("cause", "bad")
    assert verdict_of([vague, bad, cause], brief=False).reasons == ("bad", "cause", "vague")
    assert verdict_of([vague, bad]).level == "do_not_use"


def test_what_explains_most_comes_first_and_what_it_outdoes_is_not_told() -> None:
    """A turned joint may look like another robot; a cause in one recording stands beside one of all."""

    def cause(about: str, text: str, explains: float) -> Finding:
        return Finding("error", about, text, cause=True, explains=explains)

    turned, robot = cause("everything", "turned", 0.9), cause("everything", "robot", 0.8)
    assert verdict_of([robot, turned]).reasons == ("turned",)
    assert verdict_of([robot._replace(explains=0.86), turned]).reasons == ("turned", "robot")
    late = cause("loaded.csv", "late", 0.3)
    assert verdict_of([late, error("bad"), turned]).reasons == ("turned", "late", "bad")
    assert verdict_of([late._replace(explains=0.9), turned]).reasons == ("turned", "late")
    alike = late._replace(severity="warning", explains=0.5)  # too little to be told first: it outdoes nothing
    assert verdict_of([alike, robot._replace(explains=0.2)]).reasons == ("robot", "late")


def test_a_fault_that_takes_off_little_comes_last_and_a_pull_first() -> None:
    """A slip is a cause from a tenth of the squared residual on."""
    wrong = with_mass(-5.0)
    for name, fall, first in (("slip", 0.099, False), ("slip", 0.101, True), ("pull", 0.01, True)):
        evidence = pulling(1.0) if name == "pull" else beside("slip", 0.05)
        effect = evidence.effects[name]._replace(fall=fall)
        reasons = judge(of_payload(estimate_of(ten=wrong), effects={name: effect})).reasons
        told = [("pulls at the flange" in text or "payload slip" in text) for text in reasons]
        assert told.index(True) == (0 if first else len(reasons) - 1)


def test_few_blocks_widen_what_every_quantity_is_judged_by() -> None:
    """Half of a 95 % interval over 1.96: 12.7 over 1.96 with one degree of freedom."""
    assert few_blocks(1.0) == pytest.approx(12.7062 / 1.95996, rel=1e-5)
    assert few_blocks(1e9) == pytest.approx(1.0)
    for freedom, told in ((1e9, True), (1.0, False)):
        view = ByJoints((ratio(1, 1.0, 0.01), ratio(3, 1.3, 0.05), ratio(4, None)), degrees_of_freedom=freedom)
        findings = judge(of_weighing(by_joints=view)).findings
        assert any("joint 3 measures" in finding.text for finding in findings) == told


_SHARES = st.floats(0.5, 1.5)
_MASSES = st.floats(4.0, 6.0)


@given(
    shares=st.lists(_SHARES, min_size=2, max_size=5),
    masses=st.lists(_MASSES, max_size=4),
    sigma=st.floats(1e-3, 0.3),
    scale=st.floats(0.9, 1.1),
    factor=st.floats(1.0, 4.0),
    fall=st.floats(-0.1, 0.1),
    left=st.floats(0.02, 0.3),
)
def test_no_reason_speaks_against_a_mass_that_may_be_used(
    shares: list[float], masses: list[float], sigma: float, scale: float, factor: float, fall: float, left: float
) -> None:
    """Whatever is made up: what is said of the mass, or of everything, leaves nothing to be used."""
    by_joints = ByJoints(
        (
            *(JointsMass((j,), True, mass, sigma, None) for j, mass in enumerate(masses, 2)),
            *(ratio(j, share, sigma) for j, share in enumerate(shares, 2)),
        )
    )
    verdict = judge(
        of_payload(
            estimate_of(left=left),
            by_joints=by_joints,
            disagreement=factor,
            scales=(scale_of(0, 1.0 - scale, sigma / 10.0),),
            alternatives=(
                Alternative("robot", "ur5e", fall, 100.0 * fall),
                Alternative("turned", "2", fall, 100.0 * fall),
            ),
            spread=spread_of(sigma),
        )
    )
    reasons = [finding for finding in verdict.findings if finding.severity != "note"]
    if verdict.level != "do_not_use":
        assert all(finding.about not in ("mass", "everything") for finding in reasons)
        assert all(abs(share - 1.0) <= max(scales.SHARE, scales.SIGMAS * sigma) for share in shares)
        assert abs(scale - 1.0) <= max(scales.SCALE, scales.SCALE_Z * sigma / 10.0)


def test_a_joint_without_torque_is_judged_by_noise() -> None:
    """A joint's own norm says nothing here: what it leaves is as little as any torque's noise."""
    draw = np.random.default_rng(0).standard_normal((1000, 6))
    recording = Recording(np.arange(1000) / 100.0, np.zeros((1000, 6)), 0.1 * draw)
    white = 0.1 / np.sqrt(ROBOT.processing.decimate)
    slides = replace(
        ROBOT, joints=(*ROBOT.joints[:2], replace(ROBOT.joints[2], kind="prismatic"), *ROBOT.joints[3:])
    )
    for evidence, most in (
        (Evidence(ROBOT), checks.NOISE * 20.0),  # of the largest torque
        (Evidence(ROBOT, Source((), (recording,), ROBOT.processing)), checks.FLOOR * white),
        (Evidence(slides), 0.0),  # a force is no torque: by its own
    ):
        for share, told in ((0.9, most == 0.0), (1.1, True)):
            errors, torques = np.ones(6), np.array([200.0, 150.0, 2.0, 50.0, 50.0, 50.0])
            errors[2] = share * (10.0 * most or 2.0)
            torques[2] = errors[2]
            fitted = replace(robot_of(), fit=Fit(errors, torques, (100,) * 6))
            findings = list(checks.residual(replace(evidence, parameters=fitted)))
            assert ["joint 3 " in finding.text for finding in findings] == [True] * bool(told)


K, FREEDOM = 6, 20
EXACT = np.zeros((K, K))


def seen(offs: Array, sigmas: Array, freedom: float = FREEDOM) -> ByJoints:
    """Shares that differ from 1, and the degrees of freedom of their standard deviations."""
    rows = enumerate(zip(offs, sigmas, strict=True), 1)
    ratios = tuple(ratio(joint, 1.0 + float(x), float(s)) for joint, (x, s) in rows)
    return ByJoints(ratios, degrees_of_freedom=freedom)


def even(square: float) -> ByJoints:
    """All joints off alike, their mean square in units of their variances."""
    return seen(np.full(K, 0.02 * np.sqrt(square)), np.full(K, 0.02))


def test_what_chance_brings_about_widens_one_of_ten() -> None:
    draw, widened = np.random.default_rng(0), 0
    for _ in range(1000):
        sigmas = 0.02 * np.sqrt(draw.chisquare(FREEDOM) / FREEDOM) * np.ones(K)
        widened += disagreement(seen(0.02 * draw.standard_normal(K), sigmas), EXACT) > 1.0
    assert 0.07 < widened / 1000 < 0.13


def test_where_it_begins_and_where_it_is_whole() -> None:
    first, last = (float(f.isf(chance, K, FREEDOM)) for chance in CHANCE)
    assert disagreement(even(0.999 * first), EXACT) == 1.0
    assert 1.0 < disagreement(even(1.01 * first), EXACT) < 1.05
    for square in (1.001 * last, 30.0):
        assert disagreement(even(square), EXACT) == pytest.approx(np.sqrt(K * square / (K - 1)))


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0))
def test_more_disagreement_never_widens_less(a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert disagreement(even(low), EXACT) <= disagreement(even(high), EXACT) + 1e-12


def test_a_gain_that_is_off_widens_unless_gains_are_told_unsure() -> None:
    offs = np.array([0.0, -0.08, 0.05, 0.0, 0.0, 0.0])
    view = seen(offs, np.full(K, 0.01))
    assert disagreement(view, EXACT) > 3.0
    assert disagreement(view, 0.05**2 * np.eye(K)) == 1.0
