"""What speaks against recordings and results: mistakes in logs, causes, checks, the verdict."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
