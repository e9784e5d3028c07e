"""Options that several commands share: declared once, read once, handed on as frozen values."""

from .goals import GoalOptions, NoiseOptions
from .knowledge import FrictionOptions, GainOptions, KnowledgeOptions
from .limits import LimitOptions
from .motion_files import MotionFiles
from .outputs import EquationOptions, PageOptions, ResultOptions, ViewOptions, print_lines
from .reading import Options, add_command, in_si, option
from .recordings import EssentialOptions, FilterOptions, LogOptions, PairOptions, ProcessingOptions, Setup
from .robots import ArmOptions, FramedRobotOptions, HostOptions, RehearsedRobotOptions, RobotOptions
from .shapes import ShapeOptions

__all__ = [
    "ArmOptions",
    "EquationOptions",
    "EssentialOptions",
    "FilterOptions",
    "FramedRobotOptions",
    "FrictionOptions",
    "GainOptions",
    "GoalOptions",
    "HostOptions",
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
    "ViewOptions",
    "add_command",
    "in_si",
    "option",
    "print_lines",
]
