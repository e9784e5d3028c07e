"""Documents of answers, as ``--json`` writes them; each key is declared once, with the type it is read by."""

from ....common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
