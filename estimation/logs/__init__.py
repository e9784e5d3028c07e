"""Logs of many formats as recordings: one reader a file, raw tables, then one mapping step."""

from .columns import reference_columns
from .flags import with_flags
from .layout import Layout
from .map_file import read_log_map
from .mapping import FilePart, LogMap, Quantity
from .opening import open_log
from .pose_columns import ToolColumns
from .recording import Samples, holds_currents_only, holds_torques, read_recording, stream_samples
from .table import RawLog, Table
from .tool_pose import ToolPoses, read_tool_poses
from .trajectory import TrajectoryTable, read_trajectory

__all__ = [
    "FilePart",
    "Layout",
    "LogMap",
    "Quantity",
    "RawLog",
    "Samples",
    "Table",
    "ToolColumns",
    "ToolPoses",
    "TrajectoryTable",
    "holds_currents_only",
    "holds_torques",
    "open_log",
    "read_log_map",
    "read_recording",
    "read_tool_poses",
    "read_trajectory",
    "reference_columns",
    "stream_samples",
    "with_flags",
]
