"""The robot's own base parameters from recordings without payload."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
