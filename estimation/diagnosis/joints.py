"""Agreement of the joints on one payload: the test of drive gains and friction."""

from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from ...common import Array
from ..fit.covariance import NORMAL95, few_blocks
from ..payload.by_joints import ByJoints
from .evidence import Evidence
from .finding import Finding, error, note, warning

NOTABLE, NOTABLE_SIGMAS = 0.03, 3.3
"""Relative difference of the mass between two joints that is reported, and its standard deviations."""
WRONG, SHARE = 0.10, 0.15
"""Relative difference of one joint's mass from the answer, and of its payload ratio from 1: real ones have 0.1."""
SIGMAS = 4.5  # standard deviations beyond which a difference is none by chance
CHANCE = (0.1, 0.01)
"""Probabilities that joints which agree disagree as much by chance: below the first intervals widen, below the
second by all of the disagreement."""
TOGETHER = 2.5  # factor by which all payload ratios together widen the intervals, above which it is reported
USEFUL = 0.10
"""Relative half-width of the mass's 95 % interval, grown by the joints' disagreement, above which it is useless."""


def joints(evidence: Evidence) -> list[Finding]:
    """Joints that measure different payloads, because of drive gains or friction.

    A ratio off by {SHARE:.0%}, a mass by {WRONG:.0%} (and {SIGMAS:g} sigma), two masses apart by {NOTABLE:.0%} and
    {NOTABLE_SIGMAS:g} sigma. Every interval grows by the disagreement (Birge). Do not use if that of the mass is
    then over {USEFUL:.0%}, or if leaving the joint out moves the mass out of it; else not the inertia. A note if
    the intervals grow by more than {TOGETHER:g}.
    """
    view, mass, factor = evidence.diagnosis.by_joints, evidence.mass, evidence.diagnosis.disagreement
    # Standard deviations from few blocks, which are uncertain themselves, are wider, as Student's t is.
    wider = 1.0 if evidence.weighed is None else few_blocks(view.degrees_of_freedom)
    odd, text, serious = _odd(view, wider, mass, factor)
    if not odd:
        return []
    own = float(evidence.best.estimate.larger_sigma[9]) if evidence.best is not None else np.inf
    # Of drive gains nothing has widened the estimate yet.
    half = NORMAL95 * (evidence.spread.mass if evidence.spread is not None else factor * own)
    spoilt, advice = list[str](), "check its drive gain and friction"
    if not half <= USEFUL * abs(mass):
        spoilt.append(f"an interval that covers all joints is ± {100 * half / max(abs(mass), 1e-300):.0f} %")
    for joint in odd:
        without = next((reading for reading in view.without if joint not in reading.joints), None)
        if without is None or without.mass is None:
            spoilt += [f"without joint {joint} the mass is unknown"] if serious else []
        elif abs(without.mass - mass) > half + NORMAL95 * wider * without.sigma:
            spoilt.append(f"without joint {joint} the mass is {without.mass:.3g} ± {wider * without.sigma:.2g} kg")
    if spoilt:
        return [error(f"{text}; {spoilt[0]}: {advice}")]
    grown = f"every interval is {factor:.1f} times wider to allow for it"
    return [(warning if serious else note)(f"{text}; {grown}: {advice}")]


def _odd(view: ByJoints, wider: float, mass: float, factor: float) -> tuple[tuple[int, ...], str, bool]:
    """Find joints that do not go with the answer, the worst first, and whether that is more than worth knowing."""
    ratios = [(joint, ratio, wider * sigma) for joint, ratio, sigma in view.ratios]
    off = [each for each in ratios if abs(each[1] - 1.0) > max(SHARE, SIGMAS * each[2])]
    if off:  # what it spoils in the others is its doing too
        joint, ratio, sigma = max(off, key=lambda each: abs(np.log(max(each[1], 0.05))))
        text = f"joint {joint} measures {ratio:.2f} ± {sigma:.2g} times the payload that the other joints measure"
        return (joint,), text, True
    single = [
        (r.mass, wider * r.sigma, r.joints[0]) for r in view.masses if not r.joints[1:] and r.mass is not None
    ]
    apart = [each for each in single if abs(each[0] - mass) > max(WRONG * abs(mass), SIGMAS * each[1])]
    if not apart:
        pairs = [
            (abs(a[0] - b[0]) / np.hypot(a[1], b[1]), [a, b])
            for a, b in combinations(single, 2)
            if abs(a[0] - b[0]) > NOTABLE * abs(mass)
        ]
        z, pair = max(pairs, key=lambda entry: entry[0], default=(0.0, []))
        apart = pair if z >= NOTABLE_SIGMAS else []
    if apart:
        texts = ", ".join(f"joint {joint} {m:.3g} ± {s:.2g} kg" for m, s, joint in apart)
        worst_first = sorted(apart, key=lambda each: -abs(each[0] - mass) / each[1])
        return tuple(joint for *_, joint in worst_first), f"the joints measure different masses ({texts})", True
    if factor <= TOGETHER or not ratios:
        return (), "", False
    worst, *_ = max(ratios, key=lambda each: abs(each[1] - 1.0) / each[2])
    text = f"the joints disagree about the payload by {factor:.1f} times their errors, joint {worst} most of all"
    return (worst,), text, False


def disagreement(by_joints: ByJoints, gains: Array, few: bool = False) -> float:
    """Birge ratio of the joints' payload ratios: how much farther they lie from 1 than their errors let them.

    Joints that disagree prove an error of some gain, friction or description, of which no residual knows. What
    chance brings about widens nothing (F test).

    Args:
        gains: covariance of the gains' stated relative errors, n x n; what all joints have in common does not
            count.
        few: whether the standard deviations come from few blocks of time.
    """
    ratios, wider = by_joints.ratios, few_blocks(by_joints.degrees_of_freedom) if few else 1.0
    k = len(ratios)
    if k < 2:
        return 1.0
    index = [joint - 1 for joint, *_ in ratios]
    apart = (np.eye(k) * k - 1.0) / (k - 1)  # each less the others' mean
    variance = np.diag(apart @ gains[np.ix_(index, index)] @ apart.T)
    rows = zip(ratios, variance, strict=True)
    square = sum((ratio - 1.0) ** 2 / ((wider * sigma) ** 2 + own) for (_, ratio, sigma), own in rows)
    freedom = float("inf") if few else by_joints.degrees_of_freedom
    first, last = CHANCE
    proven = np.clip((first - fdtrc(k, min(freedom, 1e9), square / k)) / (first - last), 0.0, 1.0)
    return 1.0 + float(proven) * (float(np.sqrt(max(1.0, square / (k - 1)))) - 1.0)


def worst_joint(by_joints: ByJoints, mass: float) -> Finding | None:
    """Find the joint that agrees least with the answer's mass [kg] or with the others; None where none can tell."""
    readings = [
        (
            abs(ratio - 1.0) / sigma,
            joint,
            f"joint {joint} measures {ratio:.3f} ± {sigma:.2g} times the torque that the other joints predict",
        )
        for joint, ratio, sigma in by_joints.ratios
    ]
    readings += [
        (abs(r.mass - mass) / r.sigma, r.joints[0], f"{r.name} alone measures {r.mass:.4g} ± {r.sigma:.2g} kg")
        for r in by_joints.masses
        if len(r.joints) == 1 and r.mass is not None
    ]
    if not readings:
        return None
    _, joint, text = max(readings)
    return Finding("note", f"joint {joint}", text)
