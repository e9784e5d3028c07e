"""An XML file as its author wrote it: some elements change in place, all else stays."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from ....common.errors import InputError


@dataclass(eq=False)
class Element:
    """One element: its tag and attributes, and where its first tag begins and ends, and where it ends [bytes]."""

    tag: str
    attributes: dict[str, str]
    start: int
    opened: int
    end: int = 0
    parent: "Element | None" = None
    children: "list[Element]" = field(default_factory=list)

    def walk(self) -> "Iterator[Element]":
        """The element and all below it."""
        yield self
        for child in self.children:
            yield from child.walk()

    def child(self, tag: str) -> "Element | None":
        """The first child of that tag."""
        return next((child for child in self.children if child.tag == tag), None)


class XmlText:
    """Text whose elements can be changed in place."""

    def __init__(self, content: bytes, source: str) -> None:
        """Find the elements.

        Raises:
            InputError: if it is no XML, or defines entities.
        """
        if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
            raise InputError(f"{source}: <!DOCTYPE and <!ENTITY are not accepted in a model: remove them")
        self._content, self._edits = content, list[tuple[int, int, bytes]]()
        self._open: list[Element] = []
        self._roots: list[Element] = []
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._started
        self._parser.EndElementHandler = self._ended
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            raise InputError(f"{source}: not valid XML: {error}") from None

    @property
    def root(self) -> Element:
        """The outermost element."""
        return self._roots[0]

    def _started(self, tag: str, attributes: dict[str, str]) -> None:
        start = self._parser.CurrentByteIndex
        tag_text = re.compile(rb"""<(?:[^>"']|"[^"]*"|'[^']*')*>""").match(self._content, start)
        opened = tag_text.end() if tag_text else start
        element = Element(tag, attributes, start, opened, parent=self._open[-1] if self._open else None)
        (element.parent.children if element.parent else self._roots).append(element)
        self._open.append(element)

    def _ended(self, _: str) -> None:
        element = self._open.pop()
        alone = self._content[element.opened - 2 : element.opened] == b"/>"
        place = self._parser.CurrentByteIndex
        element.end = element.opened if alone else self._content.index(b">", place) + 1

    def set_attributes(self, element: Element, values: Mapping[str, str]) -> None:
        """Change attributes of an element, and add those it lacks."""
        text = self._content[element.start : element.opened].decode()
        for name, value in values.items():
            written = f" {name}={quoteattr(value)}"
            there = re.search(rf"""\s{name}\s*=\s*("[^"]*"|'[^']*')""", text)
            begin, end = there.span() if there else [len(re.sub(r"\s*/?>$", "", text))] * 2
            text = text[:begin] + written + text[end:]
        self._edits.append((element.start, element.opened, text.encode()))

    def replace(self, element: Element, text: str) -> None:
        """Put text in the place of an element."""
        self._edits.append((element.start, element.end, text.encode()))

    def insert(self, parent: Element, lines: list[str], last: bool = False) -> None:
        """Add lines as the first or the last thing in an element."""
        at = parent.start
        line = self._content.rfind(b"\n", 0, at) + 1
        margin = re.match(rb"[ \t]*", self._content[line:at])
        indent = (margin[0].decode() if margin else "") + "  "
        body = "".join(f"\n{indent}{text}" for text in lines)
        if self._content[parent.opened - 2 : parent.opened] == b"/>":
            closing = f">{body}\n{indent[:-2]}</{parent.tag}>"
            self._edits.append((parent.opened - 2, parent.opened, closing.encode()))
        elif last:
            close = self._content.rindex(b"</", 0, parent.end)
            begin = len(self._content[:close].rstrip())
            self._edits.append((begin, begin, body.encode()))
        else:
            self._edits.append((parent.opened, parent.opened, body.encode()))

    def text(self) -> str:
        """The text with all changes."""
        content = self._content
        for start, end, new in sorted(self._edits, key=lambda edit: edit[:2], reverse=True):
            content = content[:start] + new + content[end:]
        return content.decode()
