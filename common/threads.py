"""One thread of linear algebra for all estimation: small matrices wait for more, and sums round by their number."""

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute with one thread of BLAS: numbers are the same on every machine with that library."""
    with threadpool_limits(1, "blas"):
        yield
