"""MATLAB's objects in MAT files: tables, timetables, timeseries; their numbers only MATLAB can read."""

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

from ...common.errors import InputError

_MATRIX, _COMPRESSED = 14, 15
_OPAQUE = 17
"""Class of an array whose contents are an object's."""
_PLAIN = {"double", "single", "logical", "char", "cell", "struct", "function_handle", "canonical empty"}
_REMEDIES = {
    "table": "writetable({name}, 'log.csv')",
    "timetable": "T = timetable2table({name}); T.(1) = seconds(T.(1)); writetable(T, 'log.csv')",
}
_OTHERWISE = "put its numbers into arrays t, q and tau, then save('log.mat', 't', 'q', 'tau')"


def refusal(path: Path, objects: Mapping[str, str]) -> InputError:
    """What to do with a file that holds objects and no arrays of samples; objects: variable -> its class."""
    name, kind = next(iter(objects.items()))
    remedy = _REMEDIES.get(kind, _OTHERWISE).format(name=name)
    return InputError(
        f"{path}: variable {name} is a MATLAB {kind}, which only MATLAB can read: there write {remedy}"
    )


def objects_of_version_5(content: bytes) -> dict[str, str]:
    """Objects among the variables of a MAT file of version 5: name -> class.

    Args:
        content: of the file, whose tags were checked.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        return {}
    objects, at = {}, 128
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        element = content[at + 8 : at + 8 + size]
        if kind == _COMPRESSED:
            inner = zlib.decompress(element)
            kind, element = struct.unpack_from(f"{order}I", inner)[0], inner[8:]
        flags = struct.unpack_from(f"{order}I", element, 8)[0] if kind == _MATRIX and len(element) >= 16 else 0
        if flags & 0xFF == _OPAQUE:
            name, _, class_name = _texts(element[16:], order, 3)
            objects[name] = class_name
        at += 8 + size
    return objects


def _texts(content: bytes, order: str, count: int) -> list[str]:
    """The first texts of an element's contents."""
    texts, at = [], 0
    for _ in range(count):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        small = kind >> 16
        begin, size = (at + 4, small) if small else (at + 8, size)
        texts.append(content[begin : begin + size].decode("latin-1"))
        at = at + 8 if small else begin + size + -size % 8
    return texts


def object_class(attributes: Mapping[str, object]) -> str:
    """Class of the object that a data set of version 7.3 stands for; empty for plain arrays."""
    name = attributes.get("MATLAB_class", b"")
    text = name.decode("latin-1") if isinstance(name, bytes) else str(name)
    return "" if text in _PLAIN or text.startswith(("int", "uint")) else text
