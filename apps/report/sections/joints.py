"""The payload as each joint sees it."""

from collections.abc import Iterator, Sequence

import numpy as np

from ....estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from ...numbers import with_interval
from ..blocks import Block, Cell, Section, Spread, Table, Text, columns


def by_joints_table(by_joints: ByJoints) -> Table:
    """The mass by groups of joints with intervals, and each joint's share of the payload that the others show."""
    rows: list[tuple[Cell, ...]] = []
    for group, share in _with_shares(by_joints):
        cells = ["not visible", "", ""]
        if group.mass is not None and group.interval95 is not None:
            cells = [f"{x:.4g}" for x in (group.mass, *group.interval95)]
        last = Spread(f"{share.share:.3f}", f"{share.sigma:.2g}") if share and share.share is not None else ""
        rows.append((group.name, "kg", *cells, last))
    title = "The mass as each joint sees it, and its torque over what the other joints' payload demands"
    return Table(title, columns(("", "unit"), ("mass", "95 %", "interval", "share")), rows)


def mass_by_joints_note(by_joints: ByJoints) -> str:
    """One line below the payload's tables."""
    visible = [group for group in by_joints.masses if group.mass is not None]
    hidden = ", ".join(group.name for group in by_joints.masses if group.mass is None)
    if not visible:
        return "Mass: no joint sees it alone."
    masses = ", ".join(f"{group.name} {group.mass:.4g} ± {group.sigma:.2g}" for group in visible)
    return f"Mass [kg] by the torques of {masses}" + (f"; not visible to {hidden}." if hidden else ".")


def joints_section(by_joints: ByJoints, drawings: Sequence[Block] = ()) -> Section:
    """Mass by groups of joints, and each joint's share; ``drawings``: its figure, unless it stands elsewhere."""
    rows = []
    for group, share in _with_shares(by_joints):
        mass = ("not visible", "-")
        if group.mass is not None and group.interval95 is not None:
            mass = with_interval(group.mass, *group.interval95)
        rows.append((group.name, *mass, _share(share)))
    headings = columns(("",), ("mass [kg]", "95 % interval", "share of the others' payload"))
    words = (
        "Each joint weighs the payload with its own torque: where they differ, a drive gain, a friction model or "
        "the robot's description is wrong."
    )
    blocks = [Text(words), Table("Mass by groups of joints", headings, rows), *drawings]
    return Section("joints", "The payload as each joint sees it", blocks)


def _with_shares(by_joints: ByJoints) -> Iterator[tuple[JointsMass, JointShare | None]]:
    """Each group of joints; a single joint with its share."""
    shares = {share.joint: share for share in by_joints.shares}
    for group in by_joints.masses:
        yield group, shares.get(group.joints[0]) if len(group.joints) == 1 else None


def _share(share: JointShare | None) -> str:
    if share is None or share.share is None:
        return "-"
    return f"{share.share:.2f} ± {share.sigma:.2f}" if np.isfinite(share.sigma) else f"{share.share:.2f}"
