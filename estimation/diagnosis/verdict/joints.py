"""Whether all joints show the same payload: the test of drive gains and friction."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...payload.by_joints import ByJoints, JointShare, JointsMass
from .reasons import Evidence, Reason, against_all, against_inertia

NOTABLE = 0.03
"""Relative difference of the mass between two joints that is told."""
NOTABLE_SIGMAS = 3.3
"""Standard deviations it must exceed as well."""
WRONG = 0.10
"""Relative difference of one joint's mass from the answer above which nothing should be used."""
SHARE = 0.15
"""Difference of a joint's share from 1 that is told: real joints lie within 0.1."""
WRONG_SHARE = 0.3
"""Difference above which nothing should be used."""
SIGMAS = 4.5
"""Standard deviations beyond which a difference is none by chance."""


def joint_reasons(evidence: Evidence) -> list[Reason]:
    """Against numbers on which the joints do not agree."""
    return by_joints_reasons(evidence.by_joints, evidence.best.mass)


class JointReading(NamedTuple):
    """How one joint agrees with the others: by how many standard deviations it is off, and in words."""

    joint: int
    sigmas: float
    text: str


def worst_joint(found: ByJoints, mass: float) -> JointReading | None:
    """The joint that agrees least with the answer's mass [kg] or with the others; None where none can tell."""
    readings = [
        JointReading(
            one.joint,
            abs(one.share - 1.0) / one.sigma,
            f"joint {one.joint} shows {one.share:.3f} ± {one.sigma:.2g} times what the others demand there",
        )
        for one in found.shares
        if one.share is not None
    ]
    readings += [
        JointReading(
            one.joints[0],
            abs(one.mass - mass) / one.sigma,
            f"{one.name} alone weighs {one.mass:.4g} ± {one.sigma:.2g} kg",
        )
        for one in found.masses
        if len(one.joints) == 1 and one.mass is not None
    ]
    return max(readings, key=lambda reading: reading.sigmas, default=None)


def by_joints_reasons(found: ByJoints, mass: float) -> list[Reason]:
    """Against a mass [kg] that single joints contradict."""
    alone = [one for one in found.masses if len(one.joints) == 1 and one.mass is not None]
    return [*_shares(found.shares), *_masses(alone, mass)]


def _masses(alone: list[JointsMass], mass: float) -> list[Reason]:
    off = [
        (abs(one.mass - mass) / one.sigma, one)
        for one in alone
        if one.mass is not None and abs(one.mass - mass) > max(WRONG * abs(mass), SIGMAS * one.sigma)
    ]
    if off:
        return [against_all(_told(sorted((one for _, one in off), key=lambda one: one.joints)))]
    pairs = [
        (abs(a.mass - b.mass) / np.hypot(a.sigma, b.sigma), a, b)
        for a, b in combinations(alone, 2)
        if a.mass is not None and b.mass is not None and abs(a.mass - b.mass) > NOTABLE * abs(mass)
    ]
    z, a, b = max(pairs, key=lambda pair: pair[0], default=(0.0, None, None))
    if a is None or b is None or z < NOTABLE_SIGMAS:
        return []
    return [against_inertia(_told([a, b]))]


def _told(joints: list[JointsMass]) -> str:
    seen = ", ".join(f"{one.name} {one.mass:.3g} ± {one.sigma:.2g} kg" for one in joints)
    return f"the joints do not weigh the same ({seen}): check drive gains and friction there"


def _shares(shares: tuple[JointShare, ...]) -> list[Reason]:
    """The joint that stands out most; what it spoils in the others is its doing too."""
    off = [
        (abs(np.log(max(one.share, 0.05))), one)
        for one in shares
        if one.share is not None and abs(one.share - 1.0) > max(SHARE, SIGMAS * one.sigma)
    ]
    if not off:
        return []
    _, worst = max(off, key=lambda pair: pair[0])
    assert worst.share is not None
    text = (
        f"joint {worst.joint} shows {worst.share:.2f} ± {worst.sigma:.2g} times the payload that the other joints "
        "show: check its drive gain, unit and sign"
    )
    wrong = abs(worst.share - 1.0) > max(WRONG_SHARE, SIGMAS * worst.sigma)
    return [against_all(text) if wrong else against_inertia(text)]
