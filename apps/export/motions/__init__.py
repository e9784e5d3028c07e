"""A designed motion for a controller: one file a format, each with a head that says what the motion is."""

from .replays import Rates, controller_replays
from .ros2 import check_joint_names, ros2_text
from .urscript import CONTROLLER_RATE, check_urscript, urscript_text
from .val3 import check_val3, val3_files, val3_replay
from .written import WrittenMotion, csv_text, design_head

__all__ = [
    "CONTROLLER_RATE",
    "Rates",
    "WrittenMotion",
    "check_joint_names",
    "check_urscript",
    "check_val3",
    "controller_replays",
    "csv_text",
    "design_head",
    "ros2_text",
    "urscript_text",
    "val3_files",
    "val3_replay",
]
