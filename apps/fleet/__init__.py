"""Many recordings: reduced in parallel, stored, compared."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
