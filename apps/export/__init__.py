"""Results in the form of controllers and simulators, and motions in the form of controllers."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
