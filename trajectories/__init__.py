"""Motions that excite the parameters, designs of them, and recordings simulated on them.

Floors: ``motions`` (kinds of motion) below ``design`` (the most informative one) and ``simulation`` (recordings of
one); these two do not know each other.
"""

from ..common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
