"""``dynident`` as somebody types it: how lines end, and the commands and options as the application knows them."""

import contextlib
import io
import json
import os
import re
from collections.abc import Sequence
from contextvars import copy_context
from typing import Any, NamedTuple

from dynident.apps.commands.entry import CALL, Call, application, shown_name
from dynident.cli import main
from dynident.tests.frozen.freeze import settings
from dynident.tests.frozen.inputs import arguments, filed


class Ended(NamedTuple):
    """End of a line: exit status, output, errors."""

    status: int
    out: str
    err: str

    @property
    def text(self) -> str:
        """The output, in one line."""
        return " ".join(self.out.split())

    @property
    def errors(self) -> list[str]:
        """Lines of errors, without the notes."""
        return [line for line in self.err.splitlines() if not line.startswith("dynident: note:")]


class Answer(NamedTuple):
    """The document that a line wrote, and what it showed, in one line."""

    document: dict[str, Any]
    text: str


def typed(line: str | Sequence[str], *more: str) -> Ended:
    """Run a line, ``key=value`` of a setting in a file; ``more``: words that may hold blanks."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), settings():
        status = _ended([*(line.split() if isinstance(line, str) else line), *more])
    return Ended(status, out.getvalue(), err.getvalue())


def answered(line: str | Sequence[str], *more: str, status: Sequence[int] = (0,)) -> Answer:
    """Run a line that has to answer, and take all that it tells."""
    ended = typed(line, *more, "--details", "--json", "-")
    assert ended.status in status, ended.err
    return Answer(json.loads(ended.out), " ".join(ended.err.split()))


def refused(line: str | Sequence[str], *more: str) -> str:
    """Run a line that cannot be used: exit status 2, and one line that says why."""
    ended = typed(line, *more)
    assert (ended.status, ended.out, len(ended.errors)) == (2, "", 1), ended
    return ended.errors[0]


def unread(line: Sequence[str]) -> int:
    """Status of a command whose output goes to a pipe that nobody reads any more."""
    read, write = os.pipe()
    os.close(read)
    with (
        os.fdopen(write, "w") as gone,
        contextlib.redirect_stdout(gone),
        contextlib.redirect_stderr(io.StringIO()),
        settings(),
    ):
        return main(filed(line))


def _ended(words: Sequence[str]) -> int:
    try:
        return main(filed(words))
    except SystemExit as stop:
        return int(stop.code or 0)


def options(name: str) -> list[str]:
    """Names of a command's options, and keys of its settings."""
    return [shown_name(argument) for argument in arguments(name)]


def written(name: str) -> list[tuple[str, str]]:
    """Options of a command that name a file or a folder to write, and which."""
    return [
        (shown_name(argument), kind)
        for argument in arguments(name)
        for kind in re.findall(r"Named\(kind='(file|folder|stream)'", str(argument.field_info.annotation))
    ]


def parsed(words: Sequence[str]) -> tuple[dict[str, Any], Call]:
    """Options of a command line by their names, and the call."""
    words = filed(words)
    context, read = copy_context(), application(words).parse_args
    _, bound, _ = context.run(read, words, exit_on_error=False, print_error=False)
    bound.apply_defaults()
    return bound.arguments, context[CALL]
