"""Versions of the packages that decide numbers and figures."""

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from .. import __version__

_PACKAGES = ("casadi", "clarabel", "matplotlib", "numpy", "scipy")


def versions(packages: Sequence[str] = _PACKAGES) -> dict[str, str]:
    """Find the versions of dynident, Python, and packages; by default those that decide numbers and figures."""
    by_package = {"dynident": __version__, "Python": platform.python_version()}
    for package in packages:
        try:
            by_package[package] = version(package)
        except PackageNotFoundError:
            by_package[package] = "not installed"
    return by_package
