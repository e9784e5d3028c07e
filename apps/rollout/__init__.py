"""Motions predicted from measured torques by a robot's parameters, compared with what was measured."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
