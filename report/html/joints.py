"""The payload as each joint sees it."""

import numpy as np

from ...estimation import PayloadAnswer
from ...estimation.payload import ByJoints, JointsMass
from ..figures import Drawing, joints_figure
from ..numbers import with_interval
from .markup import joined, paragraph, table
from .page import Section


def joints_section(answer: PayloadAnswer) -> Section:
    """Mass by groups of joints, and each joint's share."""
    best = answer.recommended
    low, high = best.intervals.parameters[9]
    drawn = joints_figure(answer.by_joints, best.mass, (float(low), float(high)))
    return by_joints_section(answer.by_joints, (drawn,) if drawn else ())


def by_joints_section(found: ByJoints, drawings: tuple[Drawing, ...] = ()) -> Section:
    """The same for any payload; ``drawings``: its figure, unless it stands elsewhere."""
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
    return Section("joints", "The payload as each joint sees it", content, drawings)


def _mass(one: JointsMass) -> tuple[str, str]:
    if one.mass is None or one.interval95 is None:
        return "not visible", "-"
    return with_interval(one.mass, *one.interval95)
