"""Files of arrays or columns by name: NumPy archives, MATLAB files, Parquet."""

import math
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.lib import format as npy

from ...common.arrays import Array
from ...common.errors import InputError
from .matlab_objects import object_class, objects_of_version_5, refusal
from .table import Layout, RawLog, extra

_HDF5 = b"\x89HDF\r\n\x1a\n"
_MATRIX, _COMPRESSED = 14, 15
_TAGS = {*range(1, 8), 9, *range(12, 19)}
"""Kinds of elements in a MAT file of version 5: numbers, a matrix, a compressed one, texts."""
_REFERENCE = ("s0", "s1", "s2", "arr")
"""Fields of what scipy makes of a MATLAB object: its name, "MCOS", its class, and where its contents lie."""
_UNREADABLE = (
    OSError, ValueError, TypeError, LookupError, EOFError, RuntimeError, MemoryError, OverflowError,
    struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What readers of archives raise where a byte is wrong."""

Shape = tuple[int, ...]


@contextmanager
def _reading(path: Path, kind: str) -> Iterator[None]:
    """Turn whatever a library finds wrong with a file into one line."""
    try:
        yield
    except InputError:
        raise
    except _UNREADABLE as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: not {kind}, or a damaged one ({reason}): save or copy it again") from None


def npz_log(path: Path, layout: Layout) -> RawLog:
    """Open an NPZ file; objects are never unpickled.

    Raises:
        InputError: if it is none.
    """
    shapes: dict[str, Shape] = {}
    with _reading(path, "an NPZ file"), zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            with archive.open(entry) as stream:
                version = npy.read_magic(stream)
                read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                shape, _, kind = read(stream)
                left = entry.file_size - stream.tell()
            if kind.kind in "fiub":
                if min(shape, default=0) < 0 or math.prod(shape) * kind.itemsize > left:
                    raise ValueError(f"{entry.filename} ends before its {' x '.join(map(str, shape))} numbers do")
                shapes[entry.filename.removesuffix(".npy")] = shape

    def load(name: str) -> Array:
        with _reading(path, "an NPZ file"), np.load(path, allow_pickle=False) as data:
            return np.asarray(data[name], dtype=np.float64)

    return _arrays_log(path, shapes, load)


def mat_log(path: Path, layout: Layout) -> RawLog:
    """Open a MAT file; fields of structures are named as in MATLAB, ``log.q``.

    Raises:
        InputError: if it is none, or h5py is needed and not installed.
    """
    with path.open("rb") as stream:
        head = stream.read(1024)
    return _version_7(path) if _HDF5 in (head[:8], head[512:520]) else _version_5(path)


def _version_5(path: Path) -> RawLog:
    import scipy.io

    with _reading(path, "a MAT file"):
        content = path.read_bytes()
        _check_elements(content)
        objects = objects_of_version_5(content)
        try:
            data = scipy.io.loadmat(path, squeeze_me=False, struct_as_record=True)
        except scipy.io.matlab.MatReadError as error:
            raise ValueError(error) from None
    arrays = {name: value for key in data if key[0] != "_" for name, value in _fields(key, data[key])}

    def load(name: str) -> Array:
        with _reading(path, "a MAT file"):
            value = arrays[name]
            return np.asarray(value.toarray() if scipy.sparse.issparse(value) else value, dtype=np.float64)

    return _arrays_log(path, {name: tuple(value.shape) for name, value in arrays.items()}, load, objects)


def _check_elements(content: bytes) -> None:
    """Refuse a file of version 5 whose tags are wrong: scipy's reader would end the process there.

    Raises:
        ValueError: says where.
        struct.error: if the file ends within a tag.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is not None and 0 not in content[:4]:
        _check_tags(memoryview(content)[128:], order, 0)


def _check_tags(content: memoryview, order: str, depth: int) -> None:
    """Check a row of elements, matrices within each other up to a hundred deep."""
    at = 0
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        small = kind >> 16
        begin, size, kind = (at + 4, small, kind & 0xFFFF) if small else (at + 8, size, kind)
        if kind not in _TAGS or (small > 4) or begin + size > len(content) or depth > 100:
            raise ValueError(f"wrong element at byte {at}")
        if kind == _MATRIX:
            _check_tags(content[begin : begin + size], order, depth + 1)
        if kind == _COMPRESSED:
            _check_tags(memoryview(zlib.decompress(content[begin : begin + size])), order, depth + 1)
        at = at + 8 if small else begin + size + (0 if kind == _COMPRESSED else -size % 8)


def _fields(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Numeric arrays, sparse ones too, within a variable, by their full name; MATLAB's objects hold none."""
    if not hasattr(value, "dtype") or value.dtype.names == _REFERENCE:
        return
    if value.dtype.names and value.size == 1:
        for field in value.dtype.names:
            yield from _fields(f"{name}.{field}", value.reshape(-1)[0][field])
    elif value.dtype.kind in "fiub":
        yield name, value


def _version_7(path: Path) -> RawLog:
    h5py = extra("h5py", "a MAT file of version 7.3")
    shapes: dict[str, Shape] = {}
    objects: dict[str, str] = {}

    def visit(name: str, entry: Any) -> None:
        if name.startswith("#"):
            return
        if kind := object_class(entry.attrs):
            objects[name.replace("/", ".")] = kind
        elif isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiub":
            shapes[name.replace("/", ".")] = tuple(entry.shape)

    with _reading(path, "a MAT file"), h5py.File(path, "r") as data:
        data.visititems(visit)

    def load(name: str) -> Array:
        with _reading(path, "a MAT file"), h5py.File(path, "r") as data:
            return np.asarray(data[name.replace(".", "/")], dtype=np.float64)

    return _arrays_log(path, shapes, load, objects)


def _arrays_log(
    path: Path,
    shapes: Mapping[str, Shape],
    load: Callable[[str], Array],
    objects: Mapping[str, str] = MappingProxyType({}),
) -> RawLog:
    """A log of arrays: a vector ``t`` is the column t, a matrix ``q`` the columns q1, q2, ...

    Samples run along the axis that is as long as the longest of all arrays, which must be one and the same.

    Args:
        shapes: name -> shape of every numeric array.
        load: gives one array.
        objects: variables that only MATLAB can read -> their class.

    Raises:
        InputError: if there is no array of samples.
    """
    rows = max((max(shape, default=0) for shape in shapes.values()), default=0)
    places = _places(path, shapes, rows)
    if rows < 2 and objects:
        raise refusal(path, objects)
    if rows < 2:
        raise InputError(f"{path}: holds no arrays of samples: arrays by name are needed, as t, q and tau")

    def read(columns: Sequence[str]) -> Array:
        arrays = {name: load(name) for name in {places[column][0] for column in columns}}

        def column(name: str) -> Array:
            array, axis, k = places[name]
            if k < 0:
                return arrays[array].ravel()
            return arrays[array][:, k] if axis == 0 else arrays[array][k]

        return np.column_stack([column(name) for name in columns])

    return RawLog(path, tuple(places), read)


def _places(path: Path, shapes: Mapping[str, Shape], rows: int) -> dict[str, tuple[str, int, int]]:
    """Where columns of so many rows stand: their array, its axis of time, and the place along the other one or -1.

    Raises:
        InputError: if an array could be read either way.
    """
    places: dict[str, tuple[str, int, int]] = {}
    for name, shape in shapes.items():
        lengths = [size for size in shape if size != 1]
        if len(shape) > 2 or rows not in lengths:
            continue
        if len(lengths) == 1:
            places[name] = (name, 0, -1)
        elif lengths[0] == lengths[1]:
            raise InputError(f"{path}: array {name!r} is square ({rows} x {rows}): which axis is time is not known")
        else:
            axis = shape.index(rows)
            for k in range(shape[1 - axis]):
                places[f"{name}{k + 1}"] = (name, axis, k)
    return places


def parquet_log(path: Path, layout: Layout) -> RawLog:
    """Open a Parquet file.

    Raises:
        InputError: if it is none, or pyarrow is not installed.
    """
    parquet = extra("pyarrow.parquet", "a Parquet file")
    arrow = extra("pyarrow", "a Parquet file")
    with _reading(path, "a Parquet file"), parquet.ParquetFile(path) as data:
        schema = data.schema_arrow
    types = arrow.types

    def number(kind: Any) -> bool:
        return bool(types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind))

    def listing(kind: Any) -> bool:
        lists = types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)
        return bool(lists and number(kind.value_type))

    places: dict[str, tuple[str, int]] = {entry.name: (entry.name, -1) for entry in schema if number(entry.type)}
    lists = [entry.name for entry in schema if listing(entry.type)]
    for name, width in _list_widths(path, parquet, lists).items():
        places |= {f"{name}{k + 1}": (name, k) for k in range(width)}

    def read(columns: Sequence[str]) -> Array:
        needed = sorted({places[name][0] for name in columns})
        with _reading(path, "a Parquet file"), parquet.ParquetFile(path) as data:
            table = data.read(columns=needed)
            arrays = {name: _numbers(arrow, table, name) for name in needed}
        return np.column_stack(
            [arrays[name] if k < 0 else arrays[name][:, k] for name, k in map(places.__getitem__, columns)]
        )

    return RawLog(path, tuple(places), read)


def _list_widths(path: Path, parquet: Any, lists: Sequence[str]) -> dict[str, int]:
    """How many numbers each list of the first row holds."""
    with _reading(path, "a Parquet file"), parquet.ParquetFile(path) as data:
        first = next(data.iter_batches(batch_size=1, columns=list(lists)), None) if lists else None
        return {name: len(first.column(name)[0].as_py() or ()) for name in lists} if first is not None else {}


def _numbers(arrow: Any, table: Any, name: str) -> Array:
    """A column of a table, lists as rows of a matrix.

    Raises:
        ValueError: if the lists are not of one length.
    """
    column = table.column(name).combine_chunks()
    if not hasattr(column, "flatten") or not hasattr(column.type, "value_type"):
        return np.asarray(column.cast(arrow.float64()).to_numpy(zero_copy_only=False))
    flat = np.asarray(column.flatten().cast(arrow.float64()).to_numpy(zero_copy_only=False))
    if len(flat) % max(len(column), 1) or column.null_count:
        raise ValueError(f"lists of column {name} differ in length")
    return flat.reshape(len(column), -1)
