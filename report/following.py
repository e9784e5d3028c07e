"""What the controller missed before and after a payload was entered, as JSON."""

from typing import Any

from ..estimation.weigh import FollowingChange


def following_document(found: FollowingChange) -> dict[str, Any]:
    """What ``dynident verify --json`` writes."""
    return {
        "compared": found.kind,
        "tells": found.kind != "torque",
        "lag_s": found.lag,
        "joints": [one._asdict() | {"clear": one.clear} for one in found.joints],
        "all": found.total._asdict() | {"clear": found.total.clear},
    }
