"""Motions that excite the parameters, designs of them, and recordings simulated on them.

Floors: ``motions`` (kinds of motion) below ``design`` (the most informative one) and ``simulation`` of recordings.
"""

from ..common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
