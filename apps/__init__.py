"""Whatever reads logs, prints, draws, talks or runs in parallel; hands values from room to room."""

from ..common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
