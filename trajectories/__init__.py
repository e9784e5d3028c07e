"""Motions that excite the parameters, designs of them, and recordings simulated on them.

Floors: ``motions`` (kinds of motion) below ``design`` (the most informative one) and ``simulation`` (recordings of
one); these two do not know each other.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
