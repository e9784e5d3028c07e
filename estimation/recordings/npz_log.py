"""NumPy archives."""

import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from ...common.arrays import Array
from ...common.errors import InputError
from .arrays_log import Shape, arrays_log
from .layout import Layout
from .table import RawLog


def npz_log(path: Path, layout: Layout) -> RawLog:
    """Open an NPZ file; objects are never unpickled.

    Raises:
        InputError: if it is none.
    """
    shapes: dict[str, Shape] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.namelist():
                with archive.open(entry) as stream:
                    version = npy.read_magic(stream)
                    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                    shape, _, kind = read(stream)
                if kind.kind in "fiub":
                    shapes[entry.removesuffix(".npy")] = shape
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not an NPZ file ({error})") from None

    def load(name: str) -> Array:
        with np.load(path, allow_pickle=False) as data:
            return np.asarray(data[name], dtype=np.float64)

    return arrays_log(path, shapes, load)
