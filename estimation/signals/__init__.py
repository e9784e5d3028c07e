"""Recordings filtered, resampled, aligned and thinned, as the equations need them."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
