"""Results that earlier runs left in files: robots, gains, payloads, information."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
