"""The page on the method shows pieces of the example that it runs, in the example's order and word for word."""

from dynident.tests.docs.pages import ROOT, blocks


def test_pieces_are_the_example() -> None:
    example = (ROOT / "examples/the_method.py").read_text(encoding="utf-8")
    pieces = [block for block in blocks(ROOT / "docs/the-method.md") if block.language == "python"]
    assert len(pieces) == 8
    at = 0
    for piece in pieces:
        assert piece.text in example[at:], f"the-method.md:{piece.line}: not in the example, or not there"
        at = example.index(piece.text, at) + len(piece.text)


def test_the_package_enters_at_the_end_alone() -> None:
    """What the example computes before is its own."""
    own, _, _ = (ROOT / "examples/the_method.py").read_text(encoding="utf-8").partition("\ndef compare")
    assert "import dynident" not in own
    assert "from dynident" not in own
