"""Robots and bodies read and written: TOML files, URDF, other frames."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
