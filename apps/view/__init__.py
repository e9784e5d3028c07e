"""Three dimensions: an arm in motion as plain values (``moving``), and one HTML file."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
