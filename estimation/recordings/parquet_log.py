"""Parquet files."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...common.errors import InputError
from .extras import extra
from .layout import Layout
from .table import BLOCK, RawLog, Table


def parquet_log(path: Path, layout: Layout) -> RawLog:
    """Open a Parquet file.

    Raises:
        InputError: if it is none, or pyarrow is not installed.
    """
    parquet = extra("pyarrow.parquet", "a Parquet file")
    arrow = extra("pyarrow", "a Parquet file")
    try:
        with parquet.ParquetFile(path) as data:
            schema = data.schema_arrow
    except (arrow.ArrowException, OSError) as error:
        raise InputError(f"{path}: not a Parquet file ({error})") from None
    types = arrow.types
    numeric = [
        field.name
        for field in schema
        if types.is_integer(field.type) or types.is_floating(field.type) or types.is_decimal(field.type)
    ]

    def blocks(wanted: Sequence[str]) -> Iterator[Table]:
        with parquet.ParquetFile(path) as data:
            for batch in data.iter_batches(batch_size=BLOCK, columns=list(wanted)):
                columns = [batch.column(name).cast(arrow.float64()) for name in wanted]
                values = [column.to_numpy(zero_copy_only=False) for column in columns]
                yield Table(tuple(wanted), np.column_stack(values))

    return RawLog(path, tuple(numeric), blocks)
