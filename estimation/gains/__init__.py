"""Drive gains, torque per motor current, from recordings of currents without and with a known payload."""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
