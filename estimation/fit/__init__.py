"""Weighted least squares (17) to (21), its covariances, and what is essential."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
