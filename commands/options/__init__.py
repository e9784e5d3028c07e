"""Options that several commands share: declared once, read once, handed on as frozen values."""

from .goals import GoalOptions, NoiseOptions
from .knowledge import FrictionOptions, GainOptions, KnowledgeOptions
from .limits import LimitOptions
from .motion_files import MotionFiles
from .outputs import PageOptions, ResultOptions, TableOptions
from .reading import Options, add_command, in_si, option
from .recordings import EssentialOptions, LogOptions, PairOptions, ProcessingOptions, Setup
from .robots import ArmOptions, FramedRobotOptions, RehearsedRobotOptions, RobotOptions
from .shapes import ShapeOptions

__all__ = [
    "ArmOptions",
    "EssentialOptions",
    "FramedRobotOptions",
    "FrictionOptions",
    "GainOptions",
    "GoalOptions",
    "KnowledgeOptions",
    "LimitOptions",
    "LogOptions",
    "MotionFiles",
    "NoiseOptions",
    "Options",
    "PageOptions",
    "PairOptions",
    "ProcessingOptions",
    "RehearsedRobotOptions",
    "ResultOptions",
    "RobotOptions",
    "Setup",
    "ShapeOptions",
    "TableOptions",
    "add_command",
    "in_si",
    "option",
]
