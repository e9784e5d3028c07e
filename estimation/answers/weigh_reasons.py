"""The verdict on a weighing: what speaks against its numbers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ..diagnosis.verdict.joints import by_joints_reasons
from ..diagnosis.verdict.mass import SIGMAS
from ..diagnosis.verdict.reasons import Reason, against_all, against_inertia
from ..diagnosis.verdict.residual import JOINT_RESIDUAL
from ..diagnosis.verdict.verdict import Level, Verdict
from ..fit.estimate import Estimate
from ..fit.robust import few_blocks
from ..payload.by_joints import ByJoints
from ..payload.constrained import ConstrainedPayload
from ..possible.constraints import PossibleBody
from ..weigh.repeats import Repeats
from .weigh_judge import Agreement, Judged

_APART = 0.05
"""Relative difference of the mass by another way that speaks against all numbers."""


def verdict_of(
    model: Estimate,
    unexplained: Array,
    from_scale: bool,
    constrained: ConstrainedPayload | None,
    judged: dict[str, Judged],
    by_joints: ByJoints,
    repeats: Repeats | None,
    agreement: "Sequence[Agreement]",
) -> Verdict:
    """Judge a weighing.

    Args:
        model: the free estimate with the covariance of its errors.
        unexplained: each joint's error over its torque, nan for held ones.
        from_scale: whether the mass is the scale's.
        constrained: the payload that can exist, where all ten are determined.
        judged: quantity by quantity.
        by_joints: the mass as groups of joints see it.
        repeats: with several recordings.
        agreement: other ways to the mass.
    """
    mass, k = model["M_L"], model.names.index("M_L")
    found = [against_all(f"mass: {judged['mass'].why}")] if judged["mass"].use == "not measured well enough" else []
    found += _sign(mass, float(model.sigma[k]), from_scale)
    found += _unexplained(unexplained)
    found += by_joints_reasons(_allowing(by_joints), mass)
    found += _conflicts(constrained)
    found += _ways(mass, agreement)
    found += _repeats(repeats)
    if judged["centre of mass"].use != "use":
        found.append(against_all(f"centre of mass: {judged['centre of mass'].use}; {judged['centre of mass'].why}"))
    if judged["inertia"].use != "use":
        found.append(against_inertia(f"inertia: {judged['inertia'].use}; {judged['inertia'].why}"))
    level: Level = "use"
    if found:
        level = "do_not_use" if any(one.against == "everything" for one in found) else "mass_and_com_only"
    told = sorted(found, key=lambda one: one.against != "everything")
    return Verdict(level, tuple(dict.fromkeys(one.text for one in told)))


def _unexplained(shares: Array) -> list[Reason]:
    """Torque that neither payload, friction nor the recording without payload explain."""
    joints = [j for j, share in enumerate(shares, 1) if share > JOINT_RESIDUAL]
    if not joints:
        return []
    return [
        against_all(
            f"up to {100 * np.nanmax(shares):.0f} % of the torque of joint {', '.join(map(str, joints))} is not "
            "explained: check its sign, unit and drive gain, and that both recordings are of one motion"
        )
    ]


def _allowing(by_joints: ByJoints) -> ByJoints:
    """Standard deviations from few blocks are uncertain themselves: widened as Student's t is."""
    freedom = min((one.degrees_of_freedom for one in by_joints.masses), default=float("inf"))
    factor = few_blocks(freedom)
    return ByJoints(
        tuple(replace(one, sigma=factor * one.sigma) for one in by_joints.masses),
        tuple(replace(one, sigma=factor * one.sigma) for one in by_joints.shares),
    )


def _sign(mass: float, sigma: float, from_scale: bool) -> list[Reason]:
    if from_scale or mass > SIGMAS * sigma:
        return []
    if mass < -SIGMAS * sigma:
        return [
            against_all(
                f"the mass is negative ({mass:.3g} kg): the recordings with and without payload look swapped, or "
                "the signs of torques or of gravity are wrong"
            )
        ]
    return [against_all(f"the mass does not differ from zero ({mass:.3g} ± {sigma:.2g} kg): is the payload on?")]


def _conflicts(payload: ConstrainedPayload | None) -> list[Reason]:
    """The scale and what else was known beforehand against the torques."""
    if payload is None:
        return []
    told = []
    for one in payload.weighings:
        if one.conflict:
            told.append(
                f"the torques show {one.identified:.4g} ± {one.identified_sigma:.2g} kg, the scale {one.mass:g} ± "
                f"{one.sigma:g} kg: {abs(one.z):.1f} sigma apart; check the drive gains and the scale"
            )
    told += [f"the torques contradict: {one.constraint.description}" for one in payload.conflicts]
    if not told and payload.conflict:
        told.append(f"what is known beforehand contradicts the torques (p {payload.p_value:.1g})")
    held = [one for one in payload.tested if not isinstance(one.constraint, PossibleBody) and not one.conflict]
    at = [
        against_inertia(f"the answer is held at a bound that was given: {one.constraint.description}")
        for one in held
    ]
    return [*map(against_all, told), *at]


def _ways(mass: float, agreement: "Sequence[Agreement]") -> list[Reason]:
    off = [
        way for way in agreement if way.name != "friction not freed" and abs(way.mass - mass) > _APART * abs(mass)
    ]
    return [against_all(f"by the {way.name} the mass is {way.mass:.4g} kg, not {mass:.4g} kg") for way in off]


def _repeats(repeats: Repeats | None) -> list[Reason]:
    if repeats is None or not repeats.drifts or repeats.drift is None:
        return []
    step, sigma = repeats.drift
    return [
        against_inertia(
            f"the mass drifts by {step:+.3g} ± {sigma:.2g} kg from recording to recording: warm the robot up first"
        )
    ]
