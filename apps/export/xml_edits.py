"""A user's XML of which some elements change: all else stays, byte for byte."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import unescape
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from ...common.errors import InputError
from ...common.schema import read_text

_TOKEN = re.compile(
    r"<!--.*?-->|<\?.*?\?>|<!\[CDATA\[.*?\]\]>|"
    r"<(?P<close>/?)(?P<tag>[^\s/>!?]+)(?P<values>(?:[^\"'>]|\"[^\"]*\"|'[^']*')*?)(?P<alone>/?)>",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"""([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")


@dataclass(eq=False)
class Spot:
    """An element of a text: its place, from its first tag, over what is inside, to its end."""

    tag: str
    values: Mapping[str, str]
    above: "Spot | None"
    begin: int
    inside: int
    end: int


class XmlEdits:
    """Elements of a text, and what is to stand in their places.

    Attributes:
        spots: the elements, in the order of their first tags.
    """

    def __init__(self, path: str) -> None:
        """Read a file, which must be XML without entities of its own."""
        text = read_text(path)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(f"{path}: <!DOCTYPE and <!ENTITY are not accepted in a model: remove them")
        try:
            ElementTree.fromstring(text)
        except ElementTree.ParseError as error:
            raise InputError(f"{path}: not valid XML: {error}") from None
        self._path, self._text, self._changes = path, text, list[tuple[int, int, str]]()
        self.spots: list[Spot] = []
        opened: list[Spot] = []
        for found in _TOKEN.finditer(text):
            if found["close"]:
                opened.pop().end = found.end()
            elif found["tag"]:
                values = {name: unescape(value[1:-1]) for name, value in _ATTRIBUTE.findall(found["values"])}
                above = opened[-1] if opened else None
                self.spots.append(Spot(found["tag"], values, above, found.start(), found.end(), found.end()))
                opened += [] if found["alone"] else self.spots[-1:]

    def named(self, tag: str, name: str) -> Spot:
        """The element of a tag and a name, which must stand in the file."""
        found = next((spot for spot in self.spots if spot.tag == tag and spot.values.get("name") == name), None)
        if found is None:
            fault = f"{tag} {name!r} does not stand in this file: give the file that it is included from"
            raise InputError(f"{self._path}: {fault}")
        return found

    def within(self, above: Spot, tag: str) -> Spot | None:
        """The first element of a tag straight in another one."""
        return next((spot for spot in self.spots if spot.above is above and spot.tag == tag), None)

    def set(self, spot: Spot, values: Mapping[str, str]) -> None:
        """Give an element attributes, in the place of those of the same names."""
        tag = self._text[spot.begin : spot.inside]
        there, end = {found[1]: found.span() for found in _ATTRIBUTE.finditer(tag)}, len(tag.rstrip("/> \t\r\n"))
        # From the last one on, so that the places before it stay.
        for (start, stop), name in sorted(((there.get(name, (end, end)), name) for name in values), reverse=True):
            blank = "" if name in there else " "
            tag = f"{tag[:start]}{blank}{name}={quoteattr(values[name])}{tag[stop:]}"
        self._changes.append((spot.begin, spot.inside, tag))

    def put(self, above: Spot, elements: "Sequence[ElementTree.Element[Any]]", old: Spot | None = None) -> None:
        """Put elements into another one: in the place of one in it, or first."""
        lines = self._lines(above, elements)
        if old is not None:
            self._changes.append((old.begin, old.end, "".join(lines).lstrip()))
        elif above.inside < above.end:
            self._changes.append((above.inside, above.inside, "".join(lines)))
        else:
            self._changes.append((above.inside - 2, above.inside, f">{''.join(lines)}</{above.tag}>"))

    def add(self, above: Spot, elements: "Sequence[ElementTree.Element[Any]]") -> None:
        """Put elements last into one that is not empty."""
        position = len(self._text[: self._text.rindex("<", above.begin, above.end)].rstrip())
        self._changes.append((position, position, "".join(self._lines(above, elements))))

    def _lines(self, above: Spot, elements: "Sequence[ElementTree.Element[Any]]") -> list[str]:
        """Elements as texts, each on lines of its own, as far in as they are to stand."""
        before = self._text[: above.begin].rpartition("\n")[2]
        margin = f"\n{before if before.isspace() else ''}  "
        for each in elements:
            ElementTree.indent(each)
        texts = (ElementTree.tostring(each, encoding="unicode").replace(" />", "/>") for each in elements)
        return [margin + text.replace("\n", margin) for text in texts]

    def text(self) -> str:
        """The text with all changes."""
        text = self._text
        for begin, end, new in sorted(self._changes, key=lambda change: -change[0]):
            text = text[:begin] + new + text[end:]
        return text
