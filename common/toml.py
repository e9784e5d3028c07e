"""Plain mappings from TOML, where no text stalls or breaks the parser, and as TOML, which Python does not write."""

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError

_DEEP = re.compile(r"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){20}""")


def toml_data(text: str, source: str | Path) -> dict[str, Any]:
    """What a TOML text says, whatever it is.

    Raises:
        InputError: names the source, if it is no TOML, or would stall or break the parser.
    """
    # The parser would need a time that grows with the square of a key's parts.
    if deep := _DEEP.search(text):
        raise InputError(f"{source}: a key of twenty parts or more ({deep[0][:20]}...): no table is as deep")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{source}: not valid TOML here: nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: not valid TOML: {error}") from None
    except ValueError:
        raise InputError(f"{source}: holds a number of thousands of digits: shorten it") from None


def toml_text(data: Mapping[str, Any]) -> str:
    """A plain mapping as TOML: lists on one line, whole numbers without a point."""
    return "\n".join(_toml_lines(data, "")) + "\n"


def _toml_lines(data: Mapping[str, Any], above: str) -> Iterator[str]:
    tables: list[str] = []
    for key, value in data.items():
        rows = [value] if isinstance(value, Mapping) else value if isinstance(value, list) else []
        if not rows or not all(isinstance(row, Mapping) for row in rows):
            yield f"{_toml_key(key)} = {_toml_value(value)}"
            continue
        name, (left, right) = f"{above}{_toml_key(key)}", ("[[", "]]") if rows is value else ("[", "]")
        for row in rows:
            tables += ["", f"{left}{name}{right}", *_toml_lines(row, f"{name}.")]
    yield from tables


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml_value(key)


def _toml_value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    if isinstance(value, float):
        return repr(int(value)) if value == int(value) else repr(value)
    # JSON's texts, numbers and truth values are TOML's too, but for the one control character JSON leaves as it is.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
