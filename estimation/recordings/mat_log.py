"""MATLAB files: version 5 by SciPy, version 7.3 (HDF5) by h5py."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .arrays_log import Shape, arrays_log
from .extras import extra
from .layout import Layout
from .table import RawLog

_HDF5 = b"\x89HDF\r\n\x1a\n"


def mat_log(path: Path, layout: Layout) -> RawLog:
    """Open a MAT file; fields of structures are named as in MATLAB, ``log.q``.

    Raises:
        InputError: if it is none, or h5py is needed and not installed.
    """
    with path.open("rb") as stream:
        head = stream.read(1024)
    return _version_7(path) if _HDF5 in (head[:8], head[512:520]) else _version_5(path)


def _version_5(path: Path) -> RawLog:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        data = loadmat(path, squeeze_me=False, struct_as_record=True)
    except (MatReadError, ValueError, OSError, TypeError, NotImplementedError) as error:
        raise InputError(f"{path}: not a MAT file ({error})") from None
    arrays = {name: value for key in data if key[0] != "_" for name, value in _fields(key, data[key])}
    shapes = {name: array.shape for name, array in arrays.items()}
    return arrays_log(path, shapes, lambda name: np.asarray(arrays[name], dtype=np.float64))


def _fields(name: str, value: Any) -> Iterator[tuple[str, Array]]:
    """Numeric arrays within a variable, by their full name."""
    if value.dtype.names and value.size == 1:
        for field in value.dtype.names:
            yield from _fields(f"{name}.{field}", value.reshape(-1)[0][field])
    elif value.dtype.kind in "fiub":
        yield name, value


def _version_7(path: Path) -> RawLog:
    h5py = extra("h5py", "a MAT file of version 7.3")
    shapes: dict[str, Shape] = {}

    def visit(name: str, entry: Any) -> None:
        if isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiub" and not name.startswith("#"):
            shapes[name.replace("/", ".")] = tuple(entry.shape)

    try:
        with h5py.File(path, "r") as data:
            data.visititems(visit)
    except OSError as error:
        raise InputError(f"{path}: not a MAT file ({error})") from None

    def load(name: str) -> Array:
        with h5py.File(path, "r") as data:
            return np.asarray(data[name.replace(".", "/")], dtype=np.float64)

    return arrays_log(path, shapes, load)
