"""Files of options: what a run was told, read again by ``--config``.

A key is an option's name without its dashes. What the command line says of an option takes the place of what the
file says. Paths count from the working folder.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import UNSET, App
from cyclopts.config import Dict

from ...common.errors import InputError
from ...common.schema import TOML_BYTES, read_text, toml_data, toml_text

if TYPE_CHECKING:
    from .entry import Call

_HEAD = "# Options of a run, repeated by: dynident "


def settings_text(call: Call) -> str:
    """A file for ``--config`` that repeats a command line."""
    table: dict[str, Any] = {"command": call.command}
    for argument in call.arguments:
        tokens = argument.tokens if argument.name != "--config" else []
        values = [token.value if token.implicit_value is UNSET else token.implicit_value for token in tokens]
        if values:
            table[argument.name.lstrip("-")] = values[0] if len(values) == 1 else values
    return f"{_HEAD}{call.command} --config THIS_FILE\n{toml_text(table)}"


def is_settings_file(path: Path) -> bool:
    """A file was written by a run, as ``settings_text`` gives it."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.readline().startswith(_HEAD)
    except OSError:
        return False


def read_settings(call: Call, path: str) -> None:
    """Add what the ``--config`` file says of options that are not typed."""
    table = toml_data(read_text(path, TOML_BYTES), f"--config {path}")
    meant = table.pop("command", call.command)
    if meant != call.command:
        raise InputError(
            f"--config {path}: is for 'dynident {meant}', not for 'dynident {call.command}': "
            f"give a file of {call.command!r}, or call {meant!r}"
        )
    if "config" in table:
        raise InputError(f"--config {path}: a file of options names no other one: leave its key config out")
    Dict(table, source=path, use_commands_as_keys=False)(App(), (), call.arguments)
