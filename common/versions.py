"""Versions of the packages that decide numbers and figures."""

import platform
from importlib.metadata import PackageNotFoundError, version

from .. import __version__

_PACKAGES = ("casadi", "clarabel", "cvxpy", "matplotlib", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Find the versions of dynident, Python, and the packages that decide numbers and figures."""
    by_package = {"dynident": __version__, "Python": platform.python_version()}
    for package in _PACKAGES:
        try:
            by_package[package] = version(package)
        except PackageNotFoundError:
            by_package[package] = "not installed"
    return by_package
