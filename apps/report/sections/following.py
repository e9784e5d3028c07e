"""What the controller missed before and after a payload was entered."""

from ....model import Robot
from ...logs.following import FollowingChange
from ..blocks import Banner, Block, Column, Notes, Page, Screen, Section, Table, columns
from ..figures.following import following_figure
from ..provenance import Provenance
from .data import report_page

_LEVELS = {"fell": "use", "rose": "do_not_use", "no clear change": "mass_and_com_only"}
"""Colour of the banner."""
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
    first: list[Block] = [Notes(_notes(change)), Table(title, headings, rows, style="tight")]
    return Screen(first, [Notes(_compared(change))], "how both recordings were compared")


def following_page(change: FollowingChange, robot: Robot, provenance: Provenance) -> Page:
    """Whether the number entered helps, joint by joint, and how both recordings were compared.

    Args:
        robot: whose recordings they are.
    """
    screen = following_screen(change)
    words, *others = _notes(change)
    level = _LEVELS[change.total.clear] if change.tells else "mass_and_com_only"
    lead: list[Block] = [Banner(level, words), Notes(others)]
    unit, scale = _UNITS[change.kind]
    blocks: list[Block] = [*screen.first[1:], following_figure(change, unit, scale), *screen.details]
    sections = [Section("joints", "Joint by joint", blocks)]
    title = f"Before and after a payload was entered: {robot.title or robot.name}"
    return report_page(title, provenance.day, lead, sections, (), provenance)


def _compared(change: FollowingChange) -> list[str]:
    """What the numbers rest on."""
    return [
        f"The second recording's clock shows {1e3 * change.lag:+.3g} ms more; samples of one place on the motion "
        "are compared.",
        "The 95 % intervals rest on the spread over blocks of 1 s, each left out in its turn; a change is clear if "
        "the interval does not hold 0.",
    ]


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
