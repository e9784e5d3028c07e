"""What most likely went wrong: wrong assumptions are undone one by one, and the fit is watched."""

from .search import Cause, likely_causes
from .source import Source

__all__ = ["Cause", "Source", "likely_causes"]
