"""Whole answers, one function a question; the only place that calls several floors."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
