"""Versions of the packages that decide numbers and figures."""

import platform
from importlib.metadata import distributions

from .. import __version__

_PACKAGES = ("casadi", "clarabel", "cvxpy", "matplotlib", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Find the versions of dynident, Python, and the packages that decide numbers and figures."""
    found = {name: next((one.version for one in distributions(name=name)), "not installed") for name in _PACKAGES}
    return {"dynident": __version__, "Python": platform.python_version(), **found}
