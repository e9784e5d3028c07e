"""Logs of many formats as recordings: one reader a file, raw tables, then one mapping step."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
