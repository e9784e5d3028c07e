"""Bodies and robots that can exist: constraints, the nearest one, intervals."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
