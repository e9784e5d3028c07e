"""Evidence that is made: nothing is wrong with it but what a test asks for."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from dynident.common.arrays import Array
from dynident.estimation.diagnosis.checks import judge_com, judge_inertia, judge_mass
from dynident.estimation.diagnosis.evidence import Diagnosis, Evidence, Judged, Weighed
from dynident.estimation.equations.equations import PAYLOAD
from dynident.estimation.fit.estimate import Estimate, Fit
from dynident.estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from dynident.estimation.payload.long_motion import Source
from dynident.estimation.payload.repeats import Repeats
from dynident.estimation.payload.result import ConstrainedPayload, PayloadEstimate
from dynident.estimation.possible.constraints import Constraint, MassBounds
from dynident.estimation.possible.intervals import NO_INTERVALS
from dynident.estimation.possible.payload import Active, Weighing
from dynident.estimation.signals.alignment import AlignedPair
from dynident.model import InertialParameters, Recording, load_robot
from dynident.model.inertia import PayloadSpread

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


def robot_of(left: float | Array = 0.05, friction: tuple[float, float] = (9.0, 9.0)) -> Estimate:
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
    """What of a constrained estimate the checks look at."""

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
    """Evidence on an RX90, what belongs to the diagnosis among its parts."""
    seen = {field.name for field in fields(Diagnosis)} & parts.keys()
    return Evidence(ROBOT, diagnosis=Diagnosis(**{name: parts.pop(name) for name in seen}), **parts)


def of_payload(*estimates: PayloadEstimate, **more: Any) -> Evidence:
    """Evidence on a payload, the last estimate's body to be used."""
    return of_possible(*map(possible_of, estimates), **more)


def of_possible(*payloads: ConstrainedPayload, **more: Any) -> Evidence:
    """Evidence on possible payloads, the last of them to be used."""
    estimates = tuple(payload.free for payload in payloads)
    free = payloads[-1].free
    spread = PayloadSpread(float(free.larger_sigma[9]), free.spread.com, free.spread.inertia_com)
    more = {"spread": spread} | more
    body = payloads[-1].body
    judged = {
        "mass": judge_mass(free.mass, more["spread"], False),
        "centre of mass": judge_com(body.vector, more["spread"]),
        "inertia": judge_inertia(np.diag(body.inertia_com), more["spread"]),
    }
    more = {"judged": judged} | more
    return evidence_of(estimates=estimates, constrained=payloads, recommended=payloads[-1], **more)


def spread_of(mass: float) -> PayloadSpread:
    """Standard deviations of a payload whose mass is as uncertain as this [kg]."""
    return PayloadSpread(mass, np.full(3, 1e-4), np.full((3, 3), 1e-6))


def of_weighing(*constrained: ConstrainedPayload, by_joints: ByJoints | None = None, **changed: Any) -> Evidence:
    """Evidence on a short weighing of 5 kg."""
    judged = changed.pop("judged", dict.fromkeys(("mass", "centre of mass", "inertia"), Judged("use")))
    spread = changed.pop("spread", None)
    weighed = replace(Weighed(5.0, 0.01, False, np.full(6, 0.1)), **changed)
    joints = by_joints or ByJoints((), ())
    return evidence_of(constrained=constrained, by_joints=joints, weighed=weighed, spread=spread, judged=judged)


def of_spread(mass: float = 0.01, com: float = 0.001, inertia: float = 1e-4) -> Evidence:
    """A weighing whose quantities are judged by these standard deviations."""
    spread = PayloadSpread(mass, np.full(3, com), np.full((3, 3), inertia))
    judged = (judge_mass(5.0, spread, False), judge_com(BODY.vector, spread), judge_inertia(MOMENTS, spread))
    return of_weighing(judged=dict(zip(("mass", "centre of mass", "inertia"), judged, strict=True)))


def held_out(left: float, own: float) -> Evidence:
    """What is left of a held-out recording, and of the robot's own."""
    return Evidence(ROBOT, parameters=robot_of(own), validation=fit_of(left))


def two_masses(apart: float, sigma: float = 1e-3) -> Evidence:
    """Methods 1 and 3, the second's mass larger [kg]."""
    deviations = np.array([*SIGMA[:9], sigma])
    return of_payload(*(estimate_of(k, with_mass(m), deviations) for k, m in ((1, 5.0), (3, 5.0 + apart))))


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


def by_masses(*masses: tuple[float, float], without: float | None = None) -> ByJoints:
    """Masses that single joints show, from the second on, with their standard deviations, and that of the
    others."""
    rest = tuple(JointsMass((j,), without, 0.001) for j in (7, 8)) if without is not None else ()
    return ByJoints(tuple(JointsMass((j,), value, sigma) for j, (value, sigma) in enumerate(masses, 2)), (), rest)


def by_share(share: float, sigma: float = 0.001, without: float | None = None) -> ByJoints:
    """What the third joint shows of the payload, and the mass by the others."""
    rest = (JointsMass((1, 2, 4), without, 0.001),) if without is not None else ()
    return ByJoints((), (JointShare(1, 1.0, 0.01), JointShare(3, share, sigma), JointShare(4, None)), rest)


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
    return possible_of(estimate_of(), weighings=(Weighing(5.0, 0.03, 5.0 + 0.05 * z, 0.04, 1e6),))


def drift_of(z: float) -> float:
    """How far the mass of ``drifting`` rises altogether [kg]."""
    return 5.0 * z * 0.01 * float(np.sqrt(3.0 / 17.5))


def drifting(z: float, spread: PayloadSpread | None = None) -> Evidence:
    """Six weighings whose mass rises by this many standard deviations of the rise."""
    scatter = 0.01 * np.array([1.0, -2.0, 1.0, 1.0, -2.0, 1.0])  # without a slope of its own
    rise = z * 0.01 * np.sqrt(3.0 / 17.5) * np.arange(6)
    return of_weighing(repeats=Repeats.made("abcdef", (5.0 + rise + scatter).tolist(), (0.01,) * 6), spread=spread)
