"""Options that several commands share: declared once, read once, handed on as frozen values."""

from .goals import GoalOptions, NoiseOptions
from .limits import LimitOptions
from .motion_files import MotionFiles, ResultFiles
from .shapes import ShapeOptions

__all__ = ["GoalOptions", "LimitOptions", "MotionFiles", "NoiseOptions", "ResultFiles", "ShapeOptions"]
