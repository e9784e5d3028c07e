"""The payload by the four methods of the paper, behind one signature."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
