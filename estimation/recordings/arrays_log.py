"""Arrays by name, as NPZ and MAT files hold them, as named columns."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from ...common.arrays import Array
from ...common.errors import InputError
from .table import RawLog, Table, sliced

Shape = tuple[int, ...]


def arrays_log(path: Path, shapes: Mapping[str, Shape], load: Callable[[str], Array]) -> RawLog:
    """A log of arrays: a vector ``t`` is the column t, a matrix ``q`` the columns q1, q2, ...

    Samples run along the axis that is as long as the longest of all arrays, which must be one and the same.

    Args:
        path: the file.
        shapes: name -> shape of every numeric array.
        load: gives one array.

    Raises:
        InputError: if there is no array of samples.
    """
    rows = max((max(shape, default=0) for shape in shapes.values()), default=0)
    places: dict[str, tuple[str, int, int]] = {}
    for name, shape in shapes.items():
        lengths = [size for size in shape if size != 1]
        if len(shape) > 2 or rows not in lengths:
            continue
        if len(lengths) == 1:
            places[name] = (name, 0, -1)
        elif lengths[0] == lengths[1]:
            raise InputError(
                f"{path}: array {name!r} is square ({rows} x {rows}): which axis is time cannot be told"
            )
        else:
            axis = shape.index(rows)
            for k in range(shape[1 - axis]):
                places[f"{name}{k + 1}"] = (name, axis, k)
    if rows < 2:
        raise InputError(f"{path}: holds no arrays of samples: arrays by name are needed, as t, q and tau")

    def blocks(wanted: Sequence[str]) -> Iterator[Table]:
        held: dict[str, Array] = {}

        def column(name: str) -> Array:
            array, axis, k = places[name]
            if array not in held:
                held[array] = load(array)
            if k < 0:
                return held[array].ravel()
            return held[array][:, k] if axis == 0 else held[array][k]

        return sliced(wanted, column, rows)

    return RawLog(path, tuple(places), blocks)
