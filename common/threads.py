"""One thread of linear algebra for all estimation: small matrices wait for more, and sums round by their number."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module

from threadpoolctl import ThreadpoolController


@cache
def _libraries() -> ThreadpoolController:
    """Find the libraries of NumPy and SciPy, once: to look for them takes longer than a small problem."""
    for package in ("numpy.linalg", "scipy.linalg"):
        import_module(package)
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute with one thread of BLAS: numbers are the same on every machine with that library."""
    with _libraries().limit(limits=1, user_api="blas"):
        yield
