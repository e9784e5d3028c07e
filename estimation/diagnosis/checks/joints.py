"""Whether all joints show the same payload: the test of drive gains and friction."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from ....common.arrays import Array
from ...fit.robust import few_blocks
from ...payload.by_joints import ByJoints, JointShare, JointsMass
from ..evidence import Evidence
from ..finding import Finding, error, note, warning

NOTABLE = 0.03
"""Relative difference of the mass between two joints that is reported."""
NOTABLE_SIGMAS = 3.3
"""Standard deviations it must exceed as well."""
WRONG = 0.10
"""Relative difference of one joint's mass from the answer above which nothing should be used."""
SHARE = 0.15
"""Difference of a joint's share from 1 above which nothing should be used: real joints lie within 0.1."""
CHANCE = (0.1, 0.01)
"""Probabilities that joints which agree disagree as much by chance: below the first intervals widen, below the
second by all of the disagreement."""
TOGETHER = 2.5
"""Factor by which all shares together widen the intervals, above which it is reported."""
TOO_FAR = 2.83
"""Factor above which nothing should be used, if a joint that carries the mass is off as well."""
CARRIERS, CARRIED = (2, 3), 0.05
"""Joints that show the mass on arms of this kind, and the difference of their share from 1 that counts then."""
SIGMAS = 4.5
"""Standard deviations beyond which a difference is none by chance."""


def joints(evidence: Evidence) -> list[Finding]:
    """Against a mass that single joints contradict."""
    view = evidence.by_joints if evidence.weighed is None else _allowing(evidence.by_joints)
    return [*_shares(view.shares), *_masses(_alone(view), evidence)]


def disagreement(by_joints: ByJoints, gains: Array, few: bool = False) -> float:
    """Factor on every interval: how much farther the joints' shares lie from 1 than their errors let them.

    Joints that disagree prove an error of some gain, friction or description, of which no residual knows. What
    chance alone brings about widens nothing.

    Args:
        gains: covariance of the gains' stated relative errors, n x n; only what joints do not share counts.
        few: whether the standard deviations come from few blocks of time.
    """
    shares = (_allowing(by_joints) if few else by_joints).shares
    readings = [
        (reading.joint - 1, reading.share, reading.sigma) for reading in shares if reading.share is not None
    ]
    if len(readings) < 2:
        return 1.0
    joints = [joint for joint, *_ in readings]
    apart = np.eye(len(readings)) * len(readings) / (len(readings) - 1) - 1.0 / (
        len(readings) - 1
    )  # each less the others' mean
    variance = np.diag(apart @ gains[np.ix_(joints, joints)] @ apart.T)
    squares = [
        (share - 1.0) ** 2 / (sigma**2 + own) for (_, share, sigma), own in zip(readings, variance, strict=True)
    ]
    freedom = min((reading.degrees_of_freedom for reading in by_joints.masses), default=float("inf"))
    proven = _beyond_chance(sum(squares) / len(readings), len(readings), float("inf") if few else freedom)
    return 1.0 + proven * (float(np.sqrt(max(1.0, sum(squares) / (len(readings) - 1)))) - 1.0)


def _beyond_chance(square: float, joints: int, freedom: float) -> float:
    """Whether a mean square of so many joints' disagreement is more than chance, from 0 to 1 (F test)."""
    first, last = CHANCE
    return float(np.clip((first - fdtrc(joints, min(freedom, 1e9), square)) / (first - last), 0.0, 1.0))


def shares_together(evidence: Evidence) -> list[Finding]:
    """Shares that disagree as a whole, although each alone may pass."""
    factor = evidence.disagreement
    if factor <= TOGETHER:
        return []
    text = (
        f"the joints do not show one payload: their shares lie {factor:.1f} times farther apart than their errors"
    )
    off = [
        reading.joint
        for reading in evidence.by_joints.shares
        if reading.joint in CARRIERS and reading.share is not None and abs(reading.share - 1.0) > CARRIED
    ]
    if factor <= TOO_FAR or not off:
        return [note(f"{text}; every interval is widened by this factor")]
    names = ", ".join(map(str, off))
    return [error(f"{text}, that of joint {names} over {100 * CARRIED:.0f} % off: check drive gains and friction")]


def _allowing(by_joints: ByJoints) -> ByJoints:
    """Standard deviations from few blocks are uncertain themselves: widened as Student's t is."""
    freedom = min((reading.degrees_of_freedom for reading in by_joints.masses), default=float("inf"))
    factor = few_blocks(freedom)
    return ByJoints(
        tuple(replace(reading, sigma=factor * reading.sigma) for reading in by_joints.masses),
        tuple(replace(reading, sigma=factor * reading.sigma) for reading in by_joints.shares),
    )


def worst_joint(by_joints: ByJoints, mass: float) -> Finding | None:
    """The joint that agrees least with the answer's mass [kg] or with the others; None where none can tell."""
    readings = [
        (
            abs(reading.share - 1.0) / reading.sigma,
            reading.joint,
            f"joint {reading.joint} shows {reading.share:.3f} ± {reading.sigma:.2g} times what the others demand "
            "there",
        )
        for reading in by_joints.shares
        if reading.share is not None
    ]
    readings += [
        (
            abs(alone - mass) / reading.sigma,
            reading.joints[0],
            f"{reading.name} alone weighs {alone:.4g} ± {reading.sigma:.2g} kg",
        )
        for alone, reading in _alone(by_joints)
    ]
    if not readings:
        return None
    _, joint, text = max(readings, key=lambda reading: reading[0])
    return Finding("note", f"joint {joint}", text)


def _alone(by_joints: ByJoints) -> list[tuple[float, JointsMass]]:
    """The masses that single joints show [kg]."""
    return [
        (reading.mass, reading)
        for reading in by_joints.masses
        if len(reading.joints) == 1 and reading.mass is not None
    ]


def _masses(alone: Sequence[tuple[float, JointsMass]], evidence: Evidence) -> list[Finding]:
    mass = evidence.mass
    off = [reading for own, reading in alone if abs(own - mass) > max(WRONG * abs(mass), SIGMAS * reading.sigma)]
    if off:
        return [error(_told(sorted(off, key=lambda reading: reading.joints)))]
    pairs = [
        (abs(a - b) / np.hypot(first.sigma, second.sigma), [first, second])
        for (a, first), (b, second) in combinations(alone, 2)
        if abs(a - b) > NOTABLE * abs(mass)
    ]
    z, pair = max(pairs, key=lambda entry: entry[0], default=(0.0, []))
    if z < NOTABLE_SIGMAS:
        return []
    half = 1.96 * evidence.spread.mass if evidence.spread is not None else 0.0
    if any(abs(own - mass) > half + SIGMAS * reading.sigma for own, reading in alone if reading in pair):
        return [error(_told(pair), "mass")]
    return [warning(f"{_told(pair)}; each alone differs from the mass by no more than chance")]


def _told(joints: Sequence[JointsMass]) -> str:
    masses = ", ".join(f"{reading.name} {reading.mass:.3g} ± {reading.sigma:.2g} kg" for reading in joints)
    return f"the joints do not weigh the same ({masses}): check drive gains and friction there"


def _shares(shares: Sequence[JointShare]) -> list[Finding]:
    """The joint that stands out most; what it spoils in the others is its doing too."""
    off = [
        (abs(np.log(max(reading.share, 0.05))), reading.share, reading)
        for reading in shares
        if reading.share is not None and abs(reading.share - 1.0) > max(SHARE, SIGMAS * reading.sigma)
    ]
    if not off:
        return []
    _, share, worst = max(off, key=lambda entry: entry[0])
    text = (
        f"joint {worst.joint} shows {share:.2f} ± {worst.sigma:.2g} times the payload that the other joints show: "
        "check its drive gain, unit and sign"
    )
    return [error(text)]
