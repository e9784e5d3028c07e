"""A payload from a short motion of a few joints near a pose."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
