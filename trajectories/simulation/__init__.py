"""A robot whose parameters are known, under its controller, with what disturbs its recordings."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
