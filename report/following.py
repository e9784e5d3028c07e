"""What the controller missed before and after a payload was entered, as a table, words and JSON."""

from rich.table import Table

from ..estimation.weigh import FollowingChange
from .tables import empty_table

_UNITS = {"following error": ("mrad", 1e3), "unpredicted torque": ("N·m", 1.0), "torque": ("N·m", 1.0)}


def following_table(found: FollowingChange) -> Table:
    """Joint by joint."""
    unit, scale = _UNITS[found.kind]
    title = f"Root mean square of the {found.kind} [{unit}; mm or N where a joint slides]"
    table = empty_table(title, ("",), ("before", "after", "fell by %", "95 %", "interval"))
    table.add_column("", no_wrap=True)
    for one in (*found.joints, found.total):
        numbers = [f"{scale * x:.3g}" for x in (one.before, one.after)]
        shares = [f"{100 * x:.1f}" for x in (one.fall, *one.interval)]
        table.add_row(one.name, *numbers, *shares, one.clear)
    return table


def following_notes(found: FollowingChange) -> list[str]:
    """What it means."""
    total = found.total
    low, high = (100 * x for x in total.interval)
    if found.kind == "torque":
        return [
            "The logs hold neither qref1.. (positions commanded) nor tauref1.. (torque it expects): "
            "the torque itself is compared, which says nothing about the number entered, for the same motion needs "
            "the same torque. Log one of them to verify.",
            f"Torque changed by {-100 * total.fall:+.1f} % ({-high:+.1f} to {-low:+.1f} %).",
        ]
    told = {
        "fell": "the number entered helps",
        "rose": "the number entered does harm: check unit, frame and sign of what was typed in",
        "no clear change": "these recordings do not show whether it helps",
    }
    direction = "fell" if total.fall >= 0.0 else "rose"
    return [
        f"The {found.kind} {direction} by {100 * abs(total.fall):.1f} % (by {low:.1f} to {high:.1f} %): "
        f"{told[total.clear]}."
    ]
