"""Estimation of parameters from recordings. Imports only the model room."""

from ..common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
