"""Draws and writes what the other rooms computed. Imported by the command line alone."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
