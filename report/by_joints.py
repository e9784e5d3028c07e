"""The mass as each joint sees it, as a line and as JSON."""

from typing import Any

from ..estimation.payload import ByJoints, JointShare, JointsMass


def mass_by_joints_note(found: ByJoints) -> str:
    """One line below the payload's tables."""
    seen = ", ".join(f"{one.name} {one.mass:.4g} ± {one.sigma:.2g}" for one in found.masses if one.mass is not None)
    hidden = ", ".join(one.name for one in found.masses if one.mass is None)
    if not seen:
        return "Mass: no joint sees it alone."
    return f"Mass [kg] by the torques of {seen}" + (f"; not visible to {hidden}." if hidden else ".")


def mass_by_joints_document(found: ByJoints) -> list[dict[str, Any]]:
    """For JSON; ``mass`` is null where the joints do not see it."""
    shares = {share.joint: share for share in found.shares}
    return [_document(one) | _share(one, shares) for one in found.masses]


def _document(one: JointsMass) -> dict[str, Any]:
    return {
        "joints": list(one.joints),
        "visible": one.mass is not None,
        "mass": one.mass,
        "sigma": one.sigma,
        "interval95": list(one.interval95) if one.interval95 is not None else None,
    }


def _share(one: JointsMass, shares: dict[int, JointShare]) -> dict[str, Any]:
    """A single joint's factor on the payload that the others show."""
    if len(one.joints) != 1:
        return {}
    share = shares[one.joints[0]]
    return {"share": share.share, "share_sigma": share.sigma if share.share is not None else None}
