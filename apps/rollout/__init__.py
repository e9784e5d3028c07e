"""How far a robot's parameters carry: motions predicted from measured torques, compared with what was measured."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
