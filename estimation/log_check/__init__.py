"""What a log holds, and what looks wrong with it."""

from .check import Excited, LogCheck, check_log
from .finding import Finding
from .signals import JointFacts, TimeFacts

__all__ = ["Excited", "Finding", "JointFacts", "LogCheck", "TimeFacts", "check_log"]
