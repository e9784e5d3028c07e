"""Kinds of motion, one a file: the value that runs, the shape to ask for, and the family to choose from."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
