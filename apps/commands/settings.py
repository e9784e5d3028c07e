"""``--config``: options of a command from a TOML file, and the file that repeats a command line.

A key is an option's name without its dashes, or the name of an argument without dashes. What the command line says
of an option takes the place of what the file says. Paths count from the working folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.schema import TOML_BYTES, read_text, toml_data

_OPTION = "--config"
_HEAD = "# Options of a run, repeated by: dynident "
_Values = dict[str, list[str]]
"""Destination of an option -> the words of its values."""


def with_settings(parser: argparse.ArgumentParser, words: Sequence[str]) -> tuple[str, ...]:
    """The command line with the options of its ``--config`` file written out.

    Raises:
        InputError: if the file cannot be read, or holds what the command does not know.
    """
    command, below, depth = _command(parser, words)
    values = _given(below, words[depth:])
    if not values.get("config"):  # argparse refuses one that names no file
        return tuple(words)
    path = values["config"][-1]
    added: list[str] = []
    for key, value in _read(path, command).items():
        action = _action(below, key, path)
        if action.dest not in values:
            added += _words(action, value, f"{path}: {key}")
    return (*words[:depth], *added, *words[depth:])


def settings_text(parser: argparse.ArgumentParser, words: Sequence[str]) -> str:
    """A file for ``--config`` that repeats a command line."""
    command, below, depth = _command(parser, words)
    actions = {action.dest: action for action in below._actions}
    lines = [f"{_HEAD}{command} --config THIS_FILE", f"command = {_quoted(command)}"]
    for name, values in _given(below, words[depth:]).items():
        action = actions[name]
        if name == "config":
            continue
        key = action.option_strings[0].lstrip("-") if action.option_strings else name
        if action.nargs == 0:
            on = values != ["false"]
            lines.append(f"{key} = {'true' if on else 'false'}")
        elif len(values) == 1 and not _repeats(action):
            lines.append(f"{key} = {_quoted(values[0])}")
        else:
            lines.append(f"{key} = [{', '.join(map(_quoted, values))}]")
    return "\n".join(lines) + "\n"


def unknown_option(parser: argparse.ArgumentParser, words: Sequence[str], word: str) -> str:
    """What to say of a word that a command does not know, with the option that may be meant."""
    command, below, _ = _command(parser, words)
    name = word.partition("=")[0]
    close = get_close_matches(name, below._option_string_actions, 1) if name.startswith("-") else []
    kind, hint = "option" if name.startswith("-") else "argument", f": did you mean {close[0]}?" if close else ""
    return f"'dynident {command}' has no {kind} {name}{hint}"


def is_settings_file(path: Path) -> bool:
    """Whether a file was written by a run, as ``settings_text`` gives it."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.readline().startswith(_HEAD)
    except OSError:
        return False


def _command(parser: argparse.ArgumentParser, words: Sequence[str]) -> tuple[str, argparse.ArgumentParser, int]:
    """Which command is called, its parser, and how many words name it."""
    names: list[str] = []
    for word in words:
        deeper = next((a for a in parser._actions if isinstance(a, argparse._SubParsersAction)), None)
        if deeper is None or word not in deeper.choices:
            break
        names.append(word)
        parser = deeper.choices[word]
    return " ".join(names), parser, len(names)


def _given(parser: argparse.ArgumentParser, words: Sequence[str]) -> _Values:
    """Values of the options on a command line, by destination, as they were typed."""
    free = [action for action in parser._actions if not action.option_strings]
    values: _Values = {}
    rest = list(words)
    while rest:
        word = rest.pop(0)
        name, equals, value = word.partition("=")
        action = _named(parser, name) if name.startswith("-") and not _number(word) else None
        if action is not None:
            entries = _switch(action, name) if action.nargs == 0 else [value] if equals else _taken(rest, action)
            values[action.dest] = [*values.get(action.dest, []), *entries] if _repeats(action) else entries
        elif free:
            values.setdefault(free[0].dest, []).append(word)
    return values


def _switch(action: argparse.Action, name: str) -> list[str]:
    """What an option without a value says."""
    return ["false"] if name.startswith("--no-") and len(action.option_strings) > 1 else ["true"]


def _named(parser: argparse.ArgumentParser, name: str) -> argparse.Action | None:
    """The option of a name, or of the only name that begins so."""
    known = parser._option_string_actions
    fitting = [option for option in known if option.startswith(name)] if name not in known else [name]
    return known[fitting[0]] if len(fitting) == 1 else None


def _taken(rest: list[str], action: argparse.Action) -> list[str]:
    """Take an option's values off the words that follow it."""
    count = action.nargs if isinstance(action.nargs, int) else 1
    return [rest.pop(0) for _ in range(min(count, len(rest)))]


def _number(word: str) -> bool:
    return word[1:2].isdigit() or word[1:2] == "."


def _repeats(action: argparse.Action) -> bool:
    """Whether its values come one after the other."""
    several = action.nargs in ("+", "*") or (isinstance(action.nargs, int) and action.nargs > 1)
    return isinstance(action, argparse._AppendAction) or several


def _read(path: str, command: str) -> dict[str, Any]:
    table = toml_data(read_text(path, TOML_BYTES), f"{_OPTION} {path}")
    meant = table.pop("command", command)
    if meant != command:
        raise InputError(
            f"{_OPTION} {path}: is for 'dynident {meant}', not for 'dynident {command}': "
            f"give a file of {command!r}, or call {meant!r}"
        )
    return table


def _action(parser: argparse.ArgumentParser, key: str, path: str) -> argparse.Action:
    """The option that a key names."""
    actions = {name: action for action in parser._actions for name in _keys(action)}
    if key in actions:
        return actions[key]
    near = get_close_matches(key, actions, 1)
    hint = f": did you mean {near[0]}?" if near else f"; it has {', '.join(actions)}"
    raise InputError(f"{_OPTION} {path}: there is no option {key!r} in {parser.prog!r}{hint}")


def _keys(action: argparse.Action) -> Iterator[str]:
    if isinstance(action, argparse._HelpAction) or action.dest == "config":
        return
    names = [option.removeprefix("--") for option in action.option_strings]
    yield from [name for name in names if not (name.startswith("no-") and len(names) > 1)] or [action.dest]


def _words(action: argparse.Action, value: Any, where: str) -> list[str]:
    """A value as it would be typed."""
    if action.nargs == 0:
        if not isinstance(value, bool):
            raise InputError(f"{where}: give true or false")
        switched_off = [option for option in action.option_strings if option.startswith("--no-")]
        return [action.option_strings[0]] if value else switched_off[:1]
    texts = _texts(value, where)
    if not action.option_strings:
        return texts
    option = action.option_strings[0]
    if isinstance(action.nargs, int):
        return [option, *texts]
    if isinstance(action, argparse._AppendAction):
        return [f"{option}={text}" for text in texts]
    return [f"{option}={','.join(texts)}"]


def _texts(value: Any, where: str) -> list[str]:
    """A value or those of a list as texts."""
    values = value if isinstance(value, list) else [value]
    if not values or not all(isinstance(part, str | int | float) and not isinstance(part, bool) for part in values):
        raise InputError(f"{where}: give a text, a number, or a list of them")
    return [str(part) for part in values]


def _quoted(text: str) -> str:
    """A TOML string."""
    special = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return '"' + "".join(special.get(c, c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}") for c in text) + '"'
