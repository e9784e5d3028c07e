"""The payload as each joint sees it, as a table."""

from rich.table import Table

from ..estimation.payload import ByJoints
from .tables import empty_table


def by_joints_table(found: ByJoints) -> Table:
    """The mass by groups of joints with intervals, and each joint's share of the payload that the others show."""
    title = "The mass as each joint sees it, and its torque over what the other joints' payload demands"
    table = empty_table(title, ("", "unit"), ("mass", "95 %", "interval", "share"))
    shares = {share.joint: share for share in found.shares}
    for one in found.masses:
        cells = ["not visible", "", ""]
        if one.mass is not None and one.interval95 is not None:
            cells = [f"{x:.4g}" for x in (one.mass, *one.interval95)]
        share = shares.get(one.joints[0]) if len(one.joints) == 1 else None
        told = f"{share.share:.3f}±{share.sigma:.2g}" if share is not None and share.share is not None else ""
        table.add_row(one.name, "kg", *cells, told)
    return table
