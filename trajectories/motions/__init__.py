"""Kinds of motion, one a file: the value that runs, the shape to ask for, and the family to choose from."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
