"""A robot whose parameters are known, under its controller, with what disturbs its recordings."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
