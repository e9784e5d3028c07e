"""Logs of many formats as recordings: one reader a file, raw tables, then one mapping step."""

from .flags import with_flags
from .layout import Layout
from .map_file import read_log_map
from .mapping import FilePart, LogMap, Quantity
from .opening import open_log
from .recording import Samples, holds_currents_only, read_recording, stream_samples
from .table import RawLog, Table
from .trajectory import TrajectoryTable, read_trajectory

__all__ = [
    "FilePart",
    "Layout",
    "LogMap",
    "Quantity",
    "RawLog",
    "Samples",
    "Table",
    "TrajectoryTable",
    "holds_currents_only",
    "open_log",
    "read_log_map",
    "read_recording",
    "read_trajectory",
    "stream_samples",
    "with_flags",
]
