"""The mass as each joint sees it, as a line and as JSON."""

from ..estimation.payload import ByJoints


def mass_by_joints_note(found: ByJoints) -> str:
    """One line below the payload's tables."""
    seen = ", ".join(f"{one.name} {one.mass:.4g} ± {one.sigma:.2g}" for one in found.masses if one.mass is not None)
    hidden = ", ".join(one.name for one in found.masses if one.mass is None)
    if not seen:
        return "Mass: no joint sees it alone."
    return f"Mass [kg] by the torques of {seen}" + (f"; not visible to {hidden}." if hidden else ".")
