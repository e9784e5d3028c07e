"""One type for every format: its name, what it can hold, where it is documented, and the text that it becomes.

Elements of XML that several formats have.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from xml.etree.ElementTree import Element, indent, tostring

from ...common.errors import printable

if TYPE_CHECKING:
    from ...trajectories.motions.family import Plan

T = TypeVar("T")
_ASCII = str.maketrans({"±": "+-", "·": " ", "ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue"})
FIRST = '<?xml version="1.0" encoding="utf-8"?>'
DYNIDENT = "urn:dynident"  # namespace of the elements beside the standard ones


@dataclass(frozen=True)
class Format(Generic[T]):
    """A format that a payload, a robot or a motion (``T``) can be written in, by the function it decorates."""

    write: Callable[[T], "str | Element[Any]"]  # what stands below the head: a text, or the root of an XML file
    _: KW_ONLY
    title: str  # whose format it is
    source: str  # where it is documented
    # What must be said beside the numbers, a line each: alike for all formats of a kind.
    head: Callable[["Format[T]", T], Iterable[str]] = lambda form, value: form.remarks
    ready: Callable[[T], T] = lambda value: value  # what is written in a value's place; refuses what has no place
    holds: frozenset[str] = frozenset()  # what it has a place for beside what each format of its kind has
    remarks: tuple[str, ...] = ()  # what must be known of its numbers, a line each
    in_part: str = ""  # what it makes of a payload without inertia
    first_line: str = ""  # what must stand before the head
    comment: tuple[str, str] = ("# ", "")  # what goes before and after a line of the head; XML has its own
    beside: Callable[[T], Mapping[str, str]] = lambda value: {}  # further files that belong to the text, by name
    replay: Callable[[T], "Plan"] | None = None  # what a controller makes of a motion's file, by its interpolation
    replayed: tuple[str, str] = ("", "")  # that in words, and advice where it does not keep a limit

    def text(self, value: T) -> str:
        """The whole file."""
        value = self.ready(value)
        written = self.write(value)
        before, after = self.comment if isinstance(written, str) else ("<!-- ", " -->")
        head = (f"{before}{plain(line)}{after}" for line in self.head(self, value))
        text = written if isinstance(written, str) else xml_text(written)
        return "\n".join([*filter(None, [self.first_line]), *head, text.rstrip("\n")]) + "\n"


def plain(line: str) -> str:
    """A comment on one line of ASCII that ends no comment and continues no line."""
    text = printable(" ".join(line.split())).translate(_ASCII).encode("ascii", "replace").decode("ascii")
    return text.replace("--", "- -").replace("--", "- -").replace("*/", "* /").rstrip("\\")


def element(tag: str, values: Mapping[str, str] | None = None, *inside: "Element[Any] | str") -> Element:
    """An element, its attributes, and what stands in it: a text or elements."""
    made = Element(tag, dict(values or {}))
    made.text = "".join(part for part in inside if isinstance(part, str)) or None
    made.extend(part for part in inside if not isinstance(part, str))
    return made


def texts(values: Mapping[str, str]) -> list[Element]:
    """Elements that hold a text each, by their tags."""
    return [element(tag, {}, text) for tag, text in values.items()]


def xml_text(root: Element) -> str:
    """An element as text, indented."""
    indent(root)
    return tostring(root, encoding="unicode").replace(" />", "/>")
