"""Tables as Parquet, by pyarrow, which is an extra."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..common.errors import InputError
from ..common.files import opened


def pyarrow_for(purpose: str, advice: str) -> Any:
    """The package; where it is not installed, a refusal says what needs it and what to do."""
    try:
        import pyarrow.parquet
    except ImportError:
        raise InputError(f"{purpose} needs pyarrow: {advice}") from None
    return pyarrow


def parquet_bytes(columns: Mapping[str, Any]) -> bytes:
    """A table as the content of a file; the same for the same table."""
    pyarrow = pyarrow_for("Parquet", "pip install 'dynident[fleet]'")
    stream = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(dict(columns)), stream, compression="zstd")
    return bytes(stream.getvalue())


def parquet_rows(path: Path, columns: Sequence[str] | None = None) -> list[dict[str, Any]]:
    """Rows of a file's table; all its columns by default."""
    pyarrow = pyarrow_for("Parquet", "pip install 'dynident[fleet]'")
    try:
        with opened(path) as stream:
            table = pyarrow.parquet.read_table(pyarrow.BufferReader(stream.read()), columns=columns)
        rows: list[dict[str, Any]] = table.to_pylist()
    except (pyarrow.ArrowException, ValueError, OSError) as error:
        raise InputError(f"{path}: cannot be read as Parquet ({' '.join(str(error).split())})") from None
    return rows
