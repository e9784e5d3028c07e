"""Whether the loaded recordings fit those without payload: one scale of torques, no bursts of other ones."""

import numpy as np

from ..evidence import Evidence
from ..finding import Finding, error, note
from ..loaded_rows import JOINT_SCALE, JOINT_SCALE_Z, SCALE, SCALE_Z, Scale

MOVED = 0.025
"""Change of the mass without bursts, relative, above which it is reported and every interval reaches both."""


EITHER = 0.67
"""Share of the largest z from which on another scale of all torques, or of one joint's, explains them as well."""
HIDDEN, SENSITIVE = (0.01, 0.05), 0.03
"""Least and largest error of the loaded torques' scale that recordings are thought to hide, and the relative change
of the mass by what they do hide above which it is reported."""
TOLD = 1.96
"""Standard deviations of the scale that recordings hide, and to either end of a 95 % interval."""


def scale(evidence: Evidence) -> list[Finding]:
    """The loaded torques, all or those of one joint, on another scale: that which stands out most.

    Both are reported where the data hardly distinguish them; none where a pull at the flange stands out more.
    """
    off = sorted(filter(_is_off, evidence.scales), key=lambda scale: -abs(scale.z))
    if not off or (evidence.pull is not None and evidence.pull.z > abs(off[0].z)):
        return []
    worst = off[0]
    as_likely = [
        scale for scale in off if bool(scale.joint) != bool(worst.joint) and abs(scale.z) > EITHER * abs(worst.z)
    ]
    likely = sorted([worst, *as_likely[:1]])  # that of all torques, joint 0, first
    whose = f"joint {worst.joint}'s torques" if worst.joint else "the torques"
    if len(likely) > 1:
        whose = f"all torques, or joint {likely[1].joint}'s alone,"
    masses = " or ".join(f"{scale.mass:.3g}" for scale in likely)
    ratios = " or ".join(f"{scale.ratio:.3f} ± {scale.sigma:.2g}" for scale in likely)
    text = (
        f"{whose} with payload are on another scale: {ratios} times those without; on one scale the mass would be "
        f"{masses} kg: check units, drive gains and what changed in between"
    )
    return [error(text)]


def _is_off(scale: Scale) -> bool:
    """Whether torques stand out from those of one scale, in size and in sigmas."""
    size, z = (JOINT_SCALE, JOINT_SCALE_Z) if scale.joint else (SCALE, SCALE_Z)
    return abs(scale.ratio - 1.0) > size and abs(scale.z) > z


def sensitive(evidence: Evidence) -> list[Finding]:
    """A mass that an error of scale, too small for these recordings to show, takes out of its interval.

    None where something pulls at the flange, or the payload was weighed: its mass rests on that.
    """
    whole = next((scale for scale in evidence.scales if scale.joint == 0), None)
    if whole is None or evidence.spread is None or not evidence.mass > 0.0:
        return []
    if evidence.pull is not None or any(payload.weighings for payload in evidence.constrained):
        return []
    hidden = float(np.clip(TOLD * whole.sigma, *HIDDEN))
    change = hidden * abs(whole.effect)
    if not change > max(SENSITIVE * evidence.mass, TOLD * evidence.spread.mass):
        return []
    text = (
        f"torques with payload that are {100 * hidden:.2g} % too large or too small, which these recordings do not "
        f"show ({whole.ratio:.3f} ± {whole.sigma:.2g} times those without), move this mass by "
        f"{100 * change / evidence.mass:.1f} %, out of its interval"
    )
    if evidence.weighed is None:
        text += f": --scale-sigma {100 * hidden:.2g}% allows for that"
    return [note(text, "mass")]


def burst(evidence: Evidence) -> list[Finding]:
    """Short stretches that neither robot nor payload explain, and that move the mass."""
    bursts, mass = evidence.bursts, evidence.mass
    if bursts is None or abs(bursts.change[9]) <= MOVED * abs(mass):
        return []
    text = (
        f"{bursts.many} of {bursts.stretches} stretches of {bursts.length:.2g} s have outstanding residuals "
        f"(contact, a hose, a shock?): without them the mass is {mass + bursts.change[9]:.3g} kg; the intervals "
        "reach both"
    )
    return [note(text, "mass")]
