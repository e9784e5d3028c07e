"""The most informative motion: what is to be learnt, within which limits, searched for and judged."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
