"""Services that know nothing of robots: errors, locked arrays, whole files, long arrays, progress."""

from .lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
