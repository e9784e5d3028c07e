"""What became of a fleet's recordings."""

from pathlib import PurePath

from ...fleet.reduction import Reduced
from ..blocks import Block, Notes, Remarks, Screen, Table, columns


def reduced_screen(reduced: Reduced) -> Screen:
    """How many are in the store; what was refused, and why."""
    total, refused = reduced.new + reduced.known, sorted(reduced.refused.items())
    lines = [
        f"{total} recordings in {reduced.store.root}: {reduced.new} reduced now, {reduced.known} there before.",
        f"{len(refused)} logs refused{':' if refused else '.'}",
    ]
    first: list[Block] = [Notes(lines), Remarks([f"{PurePath(file).name}: {reason}" for file, reason in refused])]
    details: list[Block] = [Table("Refused", columns(("log",), (), ("why",)), refused)] if refused else []
    return Screen(first, details, "all that was refused")
