"""What earlier runs left in files: robots, gains, information."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
