"""One type for every format: its name, what it can hold, where it is documented, and the text that it becomes."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ...common.errors import printable

if TYPE_CHECKING:
    from ...trajectories.motions.family import Plan

T = TypeVar("T")
_ASCII = str.maketrans({"±": "+-", "·": " ", "ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue"})


@dataclass(frozen=True, kw_only=True)
class Format(Generic[T]):
    """A format that a payload, a robot or a motion (``T``) can be written in.

    Attributes:
        title: whose format it is.
        source: where it is documented.
        head: what must be said beside the numbers, a line each.
        write: the text below the head.
        ready: what is written in the place of a value, such as one with fewer digits; refuses what has no place.
        holds: what it has a place for beside what each format of its kind has.
        remarks: what must be known of its numbers, a line each.
        in_part: what it makes of a payload without inertia.
        first_line: what must stand before the head.
        comment: what goes before and after a line of the head.
        beside: further files that belong to the text, by name.
        replay: what a controller makes of a motion's file, by its own interpolation.
        replayed: that in words, and advice where it does not keep a limit.
    """

    title: str
    source: str
    head: Callable[["Format[T]", T], Iterable[str]]
    write: Callable[[T], str]
    ready: Callable[[T], T] = lambda value: value
    holds: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
    in_part: str = ""
    first_line: str = ""
    comment: tuple[str, str] = ("# ", "")
    beside: Callable[[T], Mapping[str, str]] = lambda value: {}
    replay: Callable[[T], "Plan"] | None = None
    replayed: tuple[str, str] = ("", "")
    name: str = ""

    def text(self, value: T) -> str:
        """The whole file."""
        value = self.ready(value)
        before, after = self.comment
        head = (f"{before}{plain(line)}{after}" for line in self.head(self, value))
        return "\n".join([*filter(None, [self.first_line]), *head, self.write(value).rstrip("\n")]) + "\n"


def plain(line: str) -> str:
    """A comment on one line of ASCII that ends no comment and continues no line."""
    text = printable(" ".join(line.split())).translate(_ASCII).encode("ascii", "replace").decode("ascii")
    return text.replace("--", "- -").replace("--", "- -").replace("*/", "* /").rstrip("\\")


def formats(package: str, folders: Iterable[str]) -> dict[str, Format[Any]]:
    """Formats by name: each is the ``FORMAT`` of one file of a package, whose ``__path__`` is given."""
    names = sorted(module.name for module in iter_modules(folders))
    return {name: replace(import_module(f"{package}.{name}").FORMAT, name=name) for name in names}
