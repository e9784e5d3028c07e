"""Tables as CSV, for a spreadsheet: one line of headings, the name of its table in front of every row.

A number with its standard deviation becomes two cells, the second under the heading with " sigma" after it. The
numbers are those printed; all digits stand in the JSON document.
"""

from collections.abc import Sequence

from ....common.files import csv_table
from ..blocks import Spread, Table

_TABLE, _NAME = "table", "name"
_Key = tuple[str, bool]
"""Heading, and whether it is the sigma beside it."""


def csv_tables(tables: Sequence[Table]) -> str:
    """All tables as one CSV text; columns that a table does not have stay empty."""
    records = [record for table in tables for record in _records(table)]
    keys = _keys(records)
    names = [f"{heading} sigma" if sigma else heading for heading, sigma in keys]
    return csv_table(names, ([record.get(key, "") for key in keys] for record in records))


def _keys(records: Sequence[dict[_Key, str]]) -> list[_Key]:
    """Columns of the file: headings as they come first, a sigma beside its value."""
    filled = dict.fromkeys(key for record in records for key in record)
    headings = dict.fromkeys(heading for heading, _ in filled)
    return [key for heading in headings for key in ((heading, False), (heading, True)) if key in filled]


def _records(table: Table) -> list[dict[_Key, str]]:
    headings = _distinct([column.heading or _NAME for column in table.columns])
    records = []
    for row in table.rows:
        record = {(_TABLE, False): table.title}
        for heading, cell in zip(headings, row, strict=True):
            if isinstance(cell, Spread):
                record[heading, False], record[heading, True] = cell
            else:
                record[heading, False] = cell
        records.append(record)
    return records


def _distinct(headings: Sequence[str]) -> list[str]:
    """A heading that comes again gets a number: a row has one value under each."""
    return [
        heading if headings.index(heading) == k else f"{heading} ({headings[: k + 1].count(heading)})"
        for k, heading in enumerate(headings)
    ]
