"""Robots that are running: recorded from over the network, and told what hangs on their flange."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
