"""Questions on the terminal: asked again until the answer can be read."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from ...common.errors import InputError

_UNKNOWN = ("", "unknown", "?")


def ask(question: str, read: Callable[[str], Any], optional: bool = False) -> Any:
    """The answer to a question, None where it is not known.

    Args:
        question: without the colon.
        read: makes a value of the answer; what it raises is printed, and the question comes again.
        optional: whether nothing, "unknown" and "?" are answers.

    Raises:
        InputError: if the input ends.
    """
    hint = " [unknown]" if optional else ""
    while True:
        try:
            text = input(f"{question}{hint}: ").strip()
        except EOFError:
            raise InputError(f"no answer to: {question}") from None
        if optional and text.lower() in _UNKNOWN:
            return None
        try:
            if not text:
                raise ValueError("an answer is needed")
            return read(text)
        except (ValueError, argparse.ArgumentTypeError) as error:
            print(f"  {error}. Once more, please.")
