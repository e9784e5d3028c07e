"""Options as fields of frozen values: declared once, read once, from a command line or a file, handed on typed.

In a file (``--config``) a key is an option's name without its dashes, or the name of an argument without dashes.
What the command line says of an option takes the place of what the file says. Paths count from the working folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from inspect import signature
from itertools import chain
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import numpy as np

from .... import model
from ....common.arrays import Array
from ....common.errors import InputError
from ....common.files import is_device, keeping, place_of
from ....common.schema import TOML_BYTES, read_text, toml_data, toml_text
from .. import COMMANDS
from ..progress import Manner, finished, speaking

_HEAD = "# Options of a run, repeated by: dynident "
Writes = Literal["", "file", "folder", "stream"]
_NEEDED = {
    False: "not a file in a folder that exists: make the folder, or give another path",
    True: "is not a folder, nor can one be made there: give another path",
}


def option(
    name: str = "",
    *,
    group: str = "",
    either: str = "",
    reads: str = "",
    writes: Writes = "",
    rare: bool = False,
    **how: Any,
) -> Any:
    """Field of an option.

    Args:
        name: of an argument without dashes; options are called as their fields are.
        group: heading in the help, instead of the class's own.
        either: options with the same word here exclude each other; one is needed where the word ends in "!".
        reads: what the file is for that the option names; empty if it names none.
        writes: whether it names a file that is written, a folder, or a file or "-".
        rare: a setting for files of options (``--config``); the help of a command leaves it out.
    """
    if rare:
        how["help"] = argparse.SUPPRESS
    about = {"name": name, "group": group, "either": either, "reads": reads, "writes": writes}
    return field(default=None, metadata={"about": about, "how": how})


@dataclass(frozen=True)
class Options:
    """Some options of a command; fields are called as the options are.

    Attributes:
        GROUP, ABOUT: heading of the options in the help, and what is said below each heading.
        WITHOUT: options that a command leaves out; they read as None.
    """

    GROUP: ClassVar[str] = ""
    ABOUT: ClassVar[Mapping[str, str]] = {}
    WITHOUT: ClassVar[frozenset[str]] = frozenset()

    @classmethod
    def declare(cls, parser: argparse.ArgumentParser) -> None:
        """Add them to a command."""
        groups: dict[str, Any] = {"": parser}
        rivals: dict[str, Any] = {}
        for entry in fields(cls):
            if not entry.metadata or entry.name in cls.WITHOUT:
                continue
            about, how = entry.metadata["about"], entry.metadata["how"]
            heading, either = about["group"] or cls.GROUP, about["either"]
            if heading not in groups:
                groups[heading] = parser.add_argument_group(heading, cls.ABOUT.get(heading))
            place = groups[heading]
            if either:
                if either not in rivals:
                    rivals[either] = place.add_mutually_exclusive_group(required=either.endswith("!"))
                place = rivals[either]
            action = place.add_argument(about["name"] or f"--{entry.name.replace('_', '-')}", **how)
            action.reads, action.writes = about["reads"], about["writes"]

    @classmethod
    def of(cls, arguments: argparse.Namespace) -> Self:
        """Take them from the parsed command line."""
        values = {entry.name: getattr(arguments, entry.name, None) for entry in fields(cls)}
        return cls(**{name: tuple(value) if isinstance(value, list) else value for name, value in values.items()})

    def has(self, option: str) -> bool:
        """Whether an option was given; "joint_names" stands for --joint-names."""
        value = getattr(self, option)
        return value is not None and value is not False

    def refuse(self, option: str, because: str) -> None:
        """Refuse an option that would have no effect."""
        if self.has(option):
            raise InputError(f"--{option.replace('_', '-')} {because}")

    def named(self, kind: Literal["reads", "writes"]) -> Iterator[tuple[str, str, str]]:
        """Paths that options name: the option, what it names (its role, or "file" or "folder"), and the path."""
        for entry in fields(self):
            about, value = entry.metadata.get("about", {}), getattr(self, entry.name)
            if about.get(kind):
                shown = about["name"].upper() or f"--{entry.name.replace('_', '-')}"
                for path in (value,) if isinstance(value, str) else value or ():
                    if isinstance(path, str) and (path or kind == "writes"):
                        yield shown, about[kind], path


@dataclass(frozen=True)
class _Terminal(Options):
    """How much is said, and a file of options."""

    GROUP: ClassVar[str] = "terminal"

    config: str | None = option(
        reads="options",
        metavar="TOML",
        help="options from a file, as every report writes one; the command line goes before it",
    )
    quiet: bool = option(
        either="manner",
        action="store_true",
        help="print no screen and no notes: files and exit status tell; what is asked for as text is printed",
    )
    verbose: bool = option(either="manner", action="store_true", help="print every step with its time")

    @property
    def manner(self) -> Manner:
        """How much is said."""
        return "quiet" if self.quiet else "verbose" if self.verbose else "plain"


def add_command(commands: Any, name: str, run: Callable[..., int], **how: Any) -> None:
    """Declare a command by the options that ``run`` takes; files that they name are checked before it is called.

    Args:
        run: does it; returns the exit status.
        how: of argparse; the help of a command below another one.
    """
    parser = commands.add_parser(name, **({"help": COMMANDS[name]} | how if name in COMMANDS else how))
    parts = [parameter.annotation for parameter in signature(run, eval_str=True).parameters.values()]
    for part in (*parts, _Terminal):
        part.declare(parser)

    def called(arguments: argparse.Namespace) -> int:
        values, terminal = [part.of(arguments) for part in parts], _Terminal.of(arguments)
        check_targets([*values, terminal])
        read = [path for value in (*values, terminal) for _, _, path in value.named("reads")]
        with keeping(read), speaking(terminal.manner), finished(name):
            return run(*values)

    parser.set_defaults(run=called, parser=parser)


def check_targets(parts: Sequence[Options]) -> None:
    """Refuse what cannot be written, or would overwrite an input or another output, before any work is done."""
    # A shipped robot's name is no file; folders may hold what several options write.
    read = ((place_of(path), name) for part in parts for name, _, path in part.named("reads"))
    owners = {place: name for place, name in read if place.exists()}
    folders: dict[Path, str] = {}
    for name, kind, path in chain.from_iterable(part.named("writes") for part in parts):
        if (kind, path) == ("stream", "-"):
            continue
        place, is_folder = place_of(path), kind == "folder"
        if not path or not (_may_hold_files(place) if is_folder else _may_be_file(place)):
            raise InputError(f"{name} {path!r}: {_NEEDED[is_folder]}")
        rivals = owners if is_folder else owners | folders
        if place in rivals and not is_device(place):  # a pipe or a terminal may be named twice
            raise InputError(f"{name} {path!r}: {rivals[place]} names this file too: give another one")
        (folders if is_folder else owners)[place] = name


def _may_be_file(place: Path) -> bool:
    return not place.is_dir() and place.parent.is_dir()


def _may_hold_files(place: Path) -> bool:
    return next(above for above in (place, *place.parents) if above.exists()).is_dir()


@contextmanager
def about(*options: str) -> Iterator[None]:
    """Say of whatever is wrong within which options it is about.

    Raises:
        InputError: instead of what is raised within.
    """
    try:
        yield
    except ValueError as error:
        named = any(option in str(error) for option in options)
        raise InputError(str(error) if named else f"{', '.join(options)}: {error}") from None


def each_joint(values: tuple[float, ...], robot: model.Robot, option: str) -> tuple[float, ...]:
    """A number for each joint, where one may stand for all.

    Raises:
        InputError: for any other count; names the option.
    """
    if len(values) not in (1, robot.n):
        count = f"{len(values)} numbers for the {robot.n} joints of robot {robot.name!r}"
        raise InputError(f"{option}: {count}: give one for all, or one each")
    return values * robot.n if len(values) == 1 else values


def in_si(values: tuple[float, ...], robot: model.Robot) -> Array:
    """Degrees of turning joints in radians; metres of sliding ones as they are."""
    if len(values) != robot.n:
        raise InputError(f"{len(values)} numbers for the {robot.n} joints of robot {robot.name!r}: give one each")
    return np.array([np.radians(x) if joint.revolute else x for x, joint in zip(values, robot.joints, strict=True)])


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
