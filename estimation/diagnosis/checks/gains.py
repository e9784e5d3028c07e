"""Whether drive gains are known, and whether the weights that they rest on go together."""

from itertools import combinations

import numpy as np

from ..evidence import KNOWN_WELL, Evidence, KnownWeight
from ..finding import Finding, error, warning
from ..loaded_rows import JOINT_SCALE, JOINT_SCALE_Z

APART, APART_SIGMAS = 0.03, 4.0
"""Difference of the weights' ratio from the one told, and its standard deviations, above which one is wrong."""

OWN_SCALE_Z = 3.3
"""Standard deviations of one motor's scale with payload, where over 5 % off, above which its gain is not kept."""


def known_gains(evidence: Evidence) -> list[Finding]:
    """Gains that the recordings do not show well."""
    if evidence.gained is None:
        return []
    sigma = evidence.gained.sigma
    vague = [(str(j), f"{100 * s:.2g}") for j, s in enumerate(sigma, 1) if not s <= KNOWN_WELL]
    if not vague:
        return []
    names, shares = (", ".join(column) for column in zip(*vague, strict=True))
    text = f"motor {names}: the gain is known to {shares} % only (1 sigma)"
    if len(vague) == len(sigma):
        return [error(f"{text}: take a heavier weight, off the flange's axis, and move faster, farther or longer")]
    return [warning(f"{text}: keep the maker's there", "gain")]


def motors_apart(evidence: Evidence) -> list[Finding]:
    """Motors whose currents with payload are on another scale than without, too little for all to be refused."""
    if evidence.gained is None:
        return []
    off = [
        scale
        for scale in evidence.scales
        if scale.joint and abs(scale.ratio - 1.0) > JOINT_SCALE and OWN_SCALE_Z < abs(scale.z) <= JOINT_SCALE_Z
    ]
    if not off:
        return []
    worst = max(off, key=lambda scale: abs(scale.z))
    text = (
        f"motor {worst.joint}: its currents with payload are {worst.ratio:.2f} ± {worst.sigma:.2g} times those "
        "without: keep the maker's gain there"
    )
    return [warning(text, "gain")]


def weights_apart(evidence: Evidence) -> list[Finding]:
    """Weights whose told masses contradict one another: each alone only sets the scale of all gains."""
    if evidence.gained is None:
        return []
    apart = []
    for weight, second in combinations(evidence.gained.weights, 2):
        ratio = (weight.mass / weight.told) / (second.mass / second.told)
        sigma = float(np.hypot(weight.sigma / weight.mass, second.sigma / second.mass))
        if abs(ratio - 1.0) > max(APART, APART_SIGMAS * sigma):
            apart.append((abs(ratio - 1.0) / sigma, weight, second))
    if not apart:
        return []
    _, weight, second = max(apart, key=lambda entry: entry[0])
    text = (
        f"the weights do not go together: with these gains {_told(weight)} and {_told(second)}: is one mass given "
        "wrongly, or are recordings of two mountings taken for one?"
    )
    return [error(text, "mass")]


def _told(weight: KnownWeight) -> str:
    return (
        f"mounting {weight.mounting} weighs {weight.mass:.4g} ± {weight.sigma:.2g} kg, given as {weight.told:g} kg"
    )
