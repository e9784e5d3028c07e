"""``--config``: options of a command from a TOML file, and the file that repeats a command line.

A key is an option's name without its dashes, or the name of an argument without dashes. What the command line says
of an option takes the place of what the file says. Paths count from the working folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.schema import TOML_BYTES, read_text, toml_data, toml_text

_HEAD = "# Options of a run, repeated by: dynident "


def settings_words(parser: argparse.ArgumentParser, typed: Mapping[str, Sequence[str]]) -> list[str]:
    """What the ``--config`` file of a command line says, as it would be typed, but for options that are typed.

    Args:
        typed: values of the options that the command line holds, by destination.

    Raises:
        InputError: if the file cannot be read, or holds what the command does not know.
    """
    path, command = typed["config"][-1], _name(parser)
    table = toml_data(read_text(path, TOML_BYTES), f"--config {path}")
    meant = table.pop("command", command)
    if meant != command:
        raise InputError(
            f"--config {path}: is for 'dynident {meant}', not for 'dynident {command}': "
            f"give a file of {command!r}, or call {meant!r}"
        )
    actions, words = {_key(action): action for action in parser._actions}, list[str]()
    for key, value in table.items():
        if key not in actions or key in ("help", "config"):
            near = get_close_matches(key, actions, 1)
            known = ", ".join(name for name in actions if name not in ("help", "config"))
            hint = f": did you mean {near[0]}?" if near else f"; it has {known}"
            raise InputError(f"--config {path}: there is no option {key!r} in {parser.prog!r}{hint}")
        if actions[key].dest not in typed:
            words += _words(actions[key], value, f"{path}: {key}")
    return words


def settings_text(parser: argparse.ArgumentParser, typed: Mapping[str, Sequence[str]]) -> str:
    """A file for ``--config`` that repeats a command line."""
    table: dict[str, Any] = {"command": _name(parser)}
    for action in parser._actions:
        if action.dest in typed and action.dest != "config":
            values = list(typed[action.dest])
            alone = len(values) == 1 and not several(action)
            table[_key(action)] = True if action.nargs == 0 else values[0] if alone else values
    return f"{_HEAD}{table['command']} --config THIS_FILE\n{toml_text(table)}"


def unknown_option(parser: argparse.ArgumentParser, word: str) -> str:
    """What to say of a word that a command does not know, with the option that may be meant."""
    name = word.partition("=")[0]
    close = get_close_matches(name, parser._option_string_actions, 1) if name.startswith("-") else []
    kind, hint = "option" if name.startswith("-") else "argument", f": did you mean {close[0]}?" if close else ""
    return f"'{parser.prog}' has no {kind} {name}{hint}"


def is_settings_file(path: Path) -> bool:
    """Whether a file was written by a run, as ``settings_text`` gives it."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.readline().startswith(_HEAD)
    except OSError:
        return False


def several(action: argparse.Action) -> bool:
    """Whether an option holds a list of values."""
    many = action.nargs in ("+", "*") or (isinstance(action.nargs, int) and action.nargs > 1)
    return isinstance(action, argparse._AppendAction) or many


def _name(parser: argparse.ArgumentParser) -> str:
    return parser.prog.removeprefix("dynident ")


def _key(action: argparse.Action) -> str:
    return action.option_strings[-1].lstrip("-") if action.option_strings else action.dest


def _words(action: argparse.Action, value: Any, where: str) -> list[str]:
    """A value as it would be typed."""
    if action.nargs == 0:
        if not isinstance(value, bool):
            raise InputError(f"{where}: give true or false")
        return [action.option_strings[0]] if value else []
    values = value if isinstance(value, list) else [value]
    if not values or not all(isinstance(part, str | int | float) for part in values):
        raise InputError(f"{where}: give a text, a number, or a list of them")
    texts = [str(part).lower() if isinstance(part, bool) else str(part) for part in values]
    if not action.option_strings:
        return texts
    option = action.option_strings[0]
    if isinstance(action.nargs, int):
        return [option, *texts]
    if isinstance(action, argparse._AppendAction):
        return [f"{option}={text}" for text in texts]
    return [f"{option}={','.join(texts)}"]
