"""Whether the loaded recordings fit those without payload: one scale of torques, no bursts of other ones."""

from ..evidence import Evidence
from ..finding import Finding, error, note
from ..loaded_rows import JOINT_SCALE, JOINT_SCALE_Z, SCALE, SCALE_Z

MOVED = 0.025
"""Change of the mass without bursts, relative, above which it is told and every interval reaches both."""


def scale(evidence: Evidence) -> list[Finding]:
    """The loaded torques, all or those of one joint, on another scale: that which stands out most."""
    off = [
        one
        for one in evidence.scales
        if abs(one.ratio - 1.0) > (JOINT_SCALE if one.joint else SCALE)
        and abs(one.z) > (JOINT_SCALE_Z if one.joint else SCALE_Z)
    ]
    if not off:
        return []
    worst = max(off, key=lambda one: abs(one.z))
    whose = f"joint {worst.joint}'s torques" if worst.joint else "the torques"
    text = (
        f"{whose} with payload are on another scale: {worst.ratio:.3f} ± {worst.sigma:.2g} times those without; on "
        f"one scale the mass would be {worst.mass:.3g} kg: check units, drive gains and what changed in between"
    )
    return [error(text)]


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
