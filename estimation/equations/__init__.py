"""The equations Y = W chi + rho of (14), row by row and reduced to triangular factors."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
