"""The robot and its dynamics: what torque a motion needs, and which parameters the torque shows.

Imports no other room.
"""

from ..common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
