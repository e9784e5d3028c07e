"""A document as it is read back by a program that knows nothing of its types."""

from typing import Any

import msgspec
from dynident.common.schema import Document, json_text


def written(document: Document) -> dict[str, Any]:
    """Plain values, as in the file."""
    read: dict[str, Any] = msgspec.json.decode(json_text(document))
    return read


def names_below_of(axis: Any) -> list[str]:
    """Names that stand below a panel, from the left."""
    return [
        text.get_text() for text in axis.texts if text.get_rotation() == 90.0 and not isinstance(text.xycoords, str)
    ]
