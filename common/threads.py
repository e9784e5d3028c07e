"""One thread of linear algebra for all estimation: small matrices wait for more, and sums round by their number."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def one_thread(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """Let a function run with one thread of BLAS: its numbers are the same on every machine with that library."""

    @wraps(function)
    def limited(*arguments: _Arguments.args, **options: _Arguments.kwargs) -> _Result:
        with threadpool_limits(1, "blas"):
            return function(*arguments, **options)

    return limited
