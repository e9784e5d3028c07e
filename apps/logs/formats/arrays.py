"""Files of arrays or columns by name: NumPy archives, MATLAB files, Parquet."""

import struct
import warnings
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....common import Array, InputError
from ...extras import extra, reading
from ..columns import RawLog
from ..map import Layout

_HDF5 = b"\x89HDF\r\n\x1a\n"
_MATRIX, _COMPRESSED = 14, 15
_TAGS = {*range(1, 8), 9, *range(12, 19)}
"""Kinds of elements in a MAT file of version 5: numbers, a matrix, a compressed one, texts."""
_PLAIN = {"double", "single", "logical", "char", "cell", "struct", "function_handle", "canonical empty"}
_REMEDIES = {
    "table": "writetable({name}, 'log.csv')",
    "timetable": "T = timetable2table({name}); T.(1) = seconds(T.(1)); writetable(T, 'log.csv')",
}
_OTHERWISE = "put its numbers into arrays t, q and tau, then save('log.mat', 't', 'q', 'tau')"


def npz_log(path: Path, layout: Layout) -> RawLog:
    """Open an NPZ file; objects are never unpickled."""
    arrays: dict[str, Any] = {}
    with reading(path, "an NPZ file"), path.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
        for name in data.files:
            try:
                arrays[name] = data[name]
            except ValueError as error:
                if "allow_pickle" not in str(error):  # an array of objects is none of numbers
                    raise
        if other := next((name for name, array in arrays.items() if not isinstance(array, np.ndarray)), ""):
            raise ValueError(f"{other} is not an array")
    return _arrays_log(path, arrays, {})


def mat_log(path: Path, layout: Layout) -> RawLog:
    """Open a MAT file; fields of structures are named as in MATLAB, ``log.q``."""
    arrays, objects = dict[str, Any](), dict[str, str]()
    with path.open("rb") as stream:
        head = stream.read(1024)
    with reading(path, "a MAT file"):
        (_version_7 if _HDF5 in (head[:8], head[512:520]) else _version_5)(path, arrays, objects)
    return _arrays_log(path, arrays, objects)


def _version_5(path: Path, arrays: dict[str, Any], objects: dict[str, str]) -> None:
    import scipy.io

    def visit(name: str, value: Any) -> None:
        """Take numeric arrays within a variable, sparse ones too, by their full name."""
        if scipy.sparse.issparse(value):
            value = value.toarray()
        if not isinstance(value, np.ndarray):
            return
        fields = value.dtype.names
        if isinstance(value, scipy.io.matlab.MatlabOpaque):
            # Its name, before SciPy 1.18 alone, "MCOS", its class, and where its contents lie.
            texts = [x if isinstance(x, str) else x.decode("latin-1") for x in list(value.reshape(-1)[0])[:-1]]
            objects[name if len(texts) == 2 else texts[0]] = texts[-1]
        elif fields and value.size == 1:
            for field in fields:
                visit(f"{name}.{field}", value.reshape(-1)[0][field])
        else:
            arrays[name] = value

    content = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is not None and 0 not in content[:4]:
        _check_tags(memoryview(content)[128:], order, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # several objects have one and the same name
        for name, value in scipy.io.loadmat(path, squeeze_me=False, struct_as_record=True).items():
            visit(name, value)


def _check_tags(content: memoryview, order: str, depth: int) -> None:
    """Check elements, matrices within each other up to a hundred deep: a wrong one makes scipy end the process."""
    at = 0
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        small = kind >> 16
        begin, size, kind = (at + 4, small, kind & 0xFFFF) if small else (at + 8, size, kind)
        if kind not in _TAGS or (small > 4) or begin + size > len(content) or depth > 100:
            raise ValueError(f"wrong element at byte {at}")
        inside = content[begin : begin + size]
        if kind in (_MATRIX, _COMPRESSED):
            _check_tags(inside if kind == _MATRIX else memoryview(zlib.decompress(inside)), order, depth + 1)
        at = at + 8 if small else begin + size + (0 if kind == _COMPRESSED else -size % 8)


def _version_7(path: Path, arrays: dict[str, Any], objects: dict[str, str]) -> None:
    h5py = extra("h5py", "reading a MAT file of version 7.3 needs h5py: install dynident[logs]")

    def visit(name: str, entry: Any) -> None:
        label = entry.attrs.get("MATLAB_class", b"")
        kind = label.decode("latin-1") if isinstance(label, bytes) else str(label)
        if name.startswith("#"):
            return
        if kind and kind not in _PLAIN and not kind.startswith(("int", "uint")):
            objects[name.replace("/", ".")] = kind
        elif isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiub" and len(entry.shape) <= 2:
            arrays[name.replace("/", ".")] = np.asarray(entry)

    with h5py.File(path, "r") as data:
        data.visititems(visit)


def parquet_log(path: Path, layout: Layout) -> RawLog:
    """Open a Parquet file; a list of numbers is a column for each of them."""
    needed = "reading a Parquet file needs pyarrow: install dynident[logs]"
    arrow, parquet = extra("pyarrow", needed), extra("pyarrow.parquet", needed)
    types = arrow.types

    def is_list(kind: Any) -> bool:
        return bool(types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind))

    columns: dict[str, Array] = {}
    with reading(path, "a Parquet file"), parquet.ParquetFile(path) as data:
        kinds = [(one.name, one.type.value_type if is_list(one.type) else one.type) for one in data.schema_arrow]
        numeric = types.is_integer, types.is_floating, types.is_decimal
        names = [name for name, kind in kinds if any(is_kind(kind) for is_kind in numeric)]
        table = data.read(columns=names)
        for name in names:
            column = table.column(name).combine_chunks()
            flat = column.flatten() if is_list(column.type) else column
            numbers = np.asarray(flat.cast(arrow.float64()).to_numpy(zero_copy_only=False))
            if not is_list(column.type):
                columns[name] = numbers
            elif not column.null_count and len(numbers) % max(len(column), 1) == 0:
                columns |= {f"{name}{k}": own for k, own in enumerate(numbers.reshape(len(column), -1).T, 1)}
            # Lists of several lengths hold no signal.
    return RawLog(path, tuple(columns), lambda names: np.column_stack([columns[name] for name in names]))


def _arrays_log(path: Path, arrays: Mapping[str, Any], objects: Mapping[str, str]) -> RawLog:
    """A log of arrays: a vector ``t`` is the column t, a matrix ``q`` the columns q1, q2, ...

    Samples run along the axis that is as long as the longest of all arrays, which must be one and the same. Arrays
    that are not numeric are passed over; ``objects``: variables that only MATLAB can read, and their class.
    """
    numeric = {name: array for name, array in arrays.items() if array.dtype.kind in "fiub"}
    rows = max((max(array.shape, default=0) for array in numeric.values()), default=0)
    if rows < 2:
        fault = "has no arrays of samples: give arrays named t, q, tau and so on"
        if objects:
            name, kind = next(iter(objects.items()))
            remedy = _REMEDIES.get(kind, _OTHERWISE).format(name=name)
            fault = f"variable {name} is a MATLAB {kind}, which only MATLAB reads: there write {remedy}"
        raise InputError(f"{path}: {fault}")
    columns: dict[str, Array] = {}
    for name, array in numeric.items():
        lengths = [size for size in array.shape if size != 1]
        if array.ndim > 2 or rows not in lengths:
            continue
        if len(lengths) == 1:
            columns[name] = np.asarray(array, dtype=np.float64).ravel()
        elif lengths[0] == lengths[1]:
            raise InputError(f"{path}: array {name!r} is square ({rows} x {rows}): which axis is time is not known")
        else:
            signals = np.asarray(array.T if len(array) == rows else array, dtype=np.float64)
            columns |= {f"{name}{k}": signal for k, signal in enumerate(signals, 1)}
    return RawLog(path, tuple(columns), lambda names: np.column_stack([columns[name] for name in names]))


READERS = {".npz": npz_log, ".mat": mat_log, ".parquet": parquet_log}
