"""The most informative motion: what is to be learnt, within which limits, searched for and judged."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
