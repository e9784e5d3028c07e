"""The JSON Schemas in the docs are those of the documents as they are written today."""

import json
from pathlib import Path

import pytest
from dynident.apps.report.documents import DOCUMENTS, schema_text

FOLDER = Path(__file__).parents[2] / "docs" / "schemas"


def test_each_document_has_one_and_the_page_links_it() -> None:
    assert {path.name for path in FOLDER.iterdir()} == {f"{name}.schema.json" for name in DOCUMENTS}
    page = (FOLDER.parent / "documents.md").read_text(encoding="utf-8")
    assert all(f"(schemas/{name}.schema.json)" in page for name in DOCUMENTS)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_it_is_current(name: str) -> None:
    """If not: python -m dynident.apps.report.documents."""
    assert json.loads((FOLDER / f"{name}.schema.json").read_bytes()) == json.loads(schema_text(name))
