"""The one error a user can mend, and texts that a terminal can show, without letters that move it."""

from collections.abc import Sequence


class InputError(ValueError):
    """An input that cannot be used. The message is one line: what, where, what to do.

    >>> load_robot("rx9")
    Traceback (most recent call last):
    dynident.common.errors.InputError: ...
    """


_LONGEST = 1000
_END = 300


def printable(text: str) -> str:
    """Write what is no letter of a text as an escape; its lines and blanks stay."""
    if text.isprintable():
        return text
    shown = (x.isprintable() or (x.isspace() and (x in "\n\t" or x >= "\xa0")) for x in text)
    return "".join(x if seen else x.encode("unicode_escape").decode() for x, seen in zip(text, shown, strict=True))


def one_line(text: str) -> str:
    """Write a message in one line; of one too long to be read the middle is left out."""
    line = printable(" ".join(text.split()))
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST - _END]} .. {line[-_END:]}"


def listed(names: Sequence[str], most: int = 6) -> str:
    """Write the first of some names with commas, and whether there are more."""
    return ", ".join(names[:most]) + (" and more" if len(names) > most else "")


def encodable(text: str) -> str:
    """Write letters that no encoding has, as names of files may hold, as escapes."""
    return text.encode(errors="backslashreplace").decode()
