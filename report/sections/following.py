"""What the controller missed before and after a payload was entered."""

from ...estimation.payload import FollowingChange
from ..blocks import Column, Notes, Screen, Table, columns

_UNITS = {"following error": ("mrad", 1e3), "unpredicted torque": ("N·m", 1.0), "torque": ("N·m", 1.0)}


def following_screen(change: FollowingChange) -> Screen:
    """What it means, and joint by joint."""
    unit, scale = _UNITS[change.kind]
    rows = []
    for joint in (*change.joints, change.total):
        numbers = [f"{scale * x:.3g}" for x in (joint.before, joint.after)]
        shares = [f"{100 * x:.1f}" for x in (joint.fall, *joint.interval)]
        rows.append((joint.name, *numbers, *shares, joint.clear))
    headings = (*columns(("",), ("before", "after", "fell by %", "95 %", "interval")), Column(""))
    title = f"Root mean square of the {change.kind} [{unit}; mm or N where a joint slides]"
    return Screen([Notes(_notes(change)), Table(title, headings, rows, style="tight")])


def _notes(change: FollowingChange) -> list[str]:
    total = change.total
    low, high = (100 * x for x in total.interval)
    if change.kind == "torque":
        return [
            "The logs hold neither qref1.. (positions commanded) nor tauref1.. (torque it expects): "
            "the torque itself is compared, which says nothing about the number entered, for the same motion needs "
            "the same torque. Log one of them to verify.",
            f"Torque changed by {-100 * total.fall:+.1f} % ({-high:+.1f} to {-low:+.1f} %).",
        ]
    meaning = {
        "fell": "the number entered helps",
        "rose": "the number entered does harm: check unit, frame and sign of what was typed in",
        "no clear change": "these recordings do not show whether it helps",
    }
    direction = "fell" if total.fall >= 0.0 else "rose"
    return [
        f"The {change.kind} {direction} by {100 * abs(total.fall):.1f} % (by {low:.1f} to {high:.1f} %): "
        f"{meaning[total.clear]}."
    ]
