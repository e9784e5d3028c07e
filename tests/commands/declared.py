"""The commands and their options as the application knows them, and command lines read without being run."""

from collections.abc import Sequence
from typing import Any

from cyclopts.argument import Argument
from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import Call, application, marks
from dynident.apps.commands.values import Writes

NAMES = [name for name, (where, _) in COMMANDS.items() if where]
"""Every command that runs."""


def arguments(name: str) -> list[Argument]:
    """Each option of a command."""
    app = application([], ())
    for word in name.split():
        app = app[word]
    return [argument for argument in app.assemble_argument_collection() if argument.parse and not argument.children]


def options(name: str) -> list[str]:
    """Names of a command's options."""
    return [argument.name for argument in arguments(name)]


def written(name: str) -> list[tuple[str, str]]:
    """Options of a command that name a file or a folder to write, and which."""
    return [
        (argument.name, mark.kind)
        for argument in arguments(name)
        for mark in marks(argument.field_info.annotation)
        if isinstance(mark, Writes)
    ]


def parsed(words: Sequence[str]) -> tuple[dict[str, Any], Call]:
    """Options of a command line by the names of their parts, and the call."""
    calls: list[Call] = []
    _, bound, _ = application(calls, words).parse_args(words, exit_on_error=False, print_error=False)
    bound.apply_defaults()
    return bound.arguments, calls[-1]
