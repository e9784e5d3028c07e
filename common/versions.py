"""Versions of what decides numbers and figures."""

import platform
from importlib.metadata import PackageNotFoundError, version

from .. import __version__

_PACKAGES = ("casadi", "clarabel", "matplotlib", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Versions of dynident, Python, and the packages that decide numbers and figures."""
    found = {"dynident": __version__, "Python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
