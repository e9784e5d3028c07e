"""Packages that only some formats need, and tables as Parquet, by one of them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from ..common.errors import InputError
from ..common.files import opened

_PARQUET = "Parquet needs pyarrow: pip install 'dynident[fleet]'"


def extra(module: str, refusal: str) -> Any:
    """Import a module; where its package is not installed, the refusal says what needs it and what to do."""
    try:
        return import_module(module)
    except ImportError:
        raise InputError(refusal) from None


def modules(package: str, folders: Iterable[str]) -> dict[str, Any]:
    """Modules of a package by name, for what is one file each; ``folders``: the package's ``__path__``."""
    names = sorted(module.name for module in iter_modules(folders))
    return {name: import_module(f"{package}.{name}") for name in names}


@contextmanager
def reading(path: Path, kind: str, remedy: str = "save or copy it again") -> Iterator[None]:
    """Turn whatever a library finds wrong with a file of this kind into one line."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # of the library, of databases and of archives within, where a byte is wrong
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: not {kind}, or a damaged one ({reason}): {remedy}") from None


def mujoco_model(path: str | Path) -> tuple[Any, Any]:
    """The package MuJoCo, and a model by MJCF or URDF."""
    mujoco = extra("mujoco", f"{path}: reading it needs MuJoCo: pip install 'dynident[simulators]'")
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    try:
        return mujoco, mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None


def parquet_bytes(columns: Mapping[str, Any]) -> bytes:
    """A table as the content of a file; the same for the same table."""
    pyarrow, parquet = extra("pyarrow", _PARQUET), extra("pyarrow.parquet", _PARQUET)
    stream = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(dict(columns)), stream, compression="zstd")
    return bytes(stream.getvalue())


def parquet_rows(path: Path, remedy: str, columns: Sequence[str] | None = None) -> list[dict[str, Any]]:
    """Rows of a file's table, all its columns by default; ``remedy``: what to do with one that cannot be read."""
    pyarrow, parquet = extra("pyarrow", _PARQUET), extra("pyarrow.parquet", _PARQUET)
    with reading(path, "a Parquet file", remedy), opened(path) as stream:
        file = parquet.ParquetFile(pyarrow.BufferReader(stream.read()))
        # Threads that still live when Python ends may abort it.
        rows: list[dict[str, Any]] = file.read(columns, use_threads=False).to_pylist()
    return rows
