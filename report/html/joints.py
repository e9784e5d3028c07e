"""The payload as each joint sees it."""

import numpy as np

from ...estimation import JointsMass, PayloadAnswer
from ..figures import joints_figure
from ..numbers import with_interval
from .markup import joined, paragraph, table
from .page import Section


def joints_section(answer: PayloadAnswer) -> Section:
    """Mass by groups of joints, and each joint's share."""
    best, found = answer.recommended, answer.by_joints
    low, high = best.intervals.parameters[9]
    drawn = joints_figure(found, best.mass, (float(low), float(high)))
    shares = {share.joint: share for share in found.shares}
    rows = []
    for one in found.masses:
        share = shares.get(one.joints[0]) if len(one.joints) == 1 else None
        told = "-"
        if share is not None and share.share is not None:
            told = f"{share.share:.2f} ± {share.sigma:.2f}" if np.isfinite(share.sigma) else f"{share.share:.2f}"
        rows.append((one.name, *_mass(one), told))
    names = ("", "mass [kg]", "95 % interval", "share of the others' payload")
    words = (
        "Each joint weighs the payload with its own torque: where they differ, a drive gain, a friction model or "
        "the robot's description is wrong."
    )
    content = joined(paragraph(words), table("Mass by groups of joints", names, rows))
    return Section("joints", "The payload as each joint sees it", content, (drawn,) if drawn else ())


def _mass(one: JointsMass) -> tuple[str, str]:
    if one.mass is None or one.interval95 is None:
        return "not visible", "-"
    return with_interval(one.mass, *one.interval95)
