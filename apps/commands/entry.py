"""The commands as one application: options are frozen values; what is being done is told on the error stream."""

from __future__ import annotations

import re
import sys
import time
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import Field, dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, dataclass_transform, get_args, get_origin, get_type_hints

from cyclopts import UNSET, App, Argument, CoercionError, CycloptsError, Group, Parameter, Token
from cyclopts import ArgumentCollection as Arguments
from cyclopts.exceptions import MissingArgumentError, UnknownOptionError, UnusedCliTokensError

from ...common.errors import InputError, one_line
from ...common.files import is_device, keeping, place_of
from ...common.progress import Progress, silent
from ...common.versions import versions
from . import ANSWERED, BAD_INPUT, COMMANDS, DO_NOT_USE
from .values import Named, Reads

GENERAL = Group("options", sort_key=-1)
MOTION = Group.create_ordered("motion")
GOAL = Group.create_ordered("what to learn")
KNOWN = Group.create_ordered("what is known beforehand", "Lengths in m, in the frame of the answer.")
LIMITS = Group.create_ordered("limits", "Positions and speeds stand in the robot's file.")
SEARCH = Group.create_ordered("search")
LOGS = Group.create_ordered("logs and drives", "CSV, TSV, NPZ, MAT, Parquet, ROS 2 bags; see docs/logs.md.")
CONTROLLER = Group.create_ordered("controller")
FILES = Group.create_ordered("files")
TERMINAL = Group.create_ordered("terminal")
"""Headings of options in the help, in their order."""
SETTING = Parameter(show=False)
"""A key of the settings file (``--config``): rarely changed, and no option; docs/settings.md has all."""

_manner: ContextVar[Literal["quiet", "plain", "verbose"]] = ContextVar("manner", default="plain")
_HEAD = "# Options of a run, repeated by: dynident "
_ASKING = {"--help", "-h", "--version"}

Rule = tuple[str, ...] | str | dict[str, tuple[str | None, ...]]
"""What other options say of one: a tuple of those of which one must be given for it to have an effect; the name of
one in whose place it stands, so that not both may be given; or the one that chooses, and the choices with which it
counts, where None stands for no choice."""


@dataclass(frozen=True)
class Call:
    """A command line that was read."""

    words: tuple[str, ...]  # as they were typed
    command: str  # its name, "robot show"
    arguments: Arguments  # every option, with the words that it was given

    @property
    def files(self) -> list[tuple[str, Named, str]]:
        """Files that are read or written: the option that names each, its mark, and the path."""
        files = list[tuple[str, Named, str]]()
        for argument in self.arguments:
            parts = [argument.field_info.annotation] if argument.tokens else []
            for part in parts:
                parts += get_args(part)  # looked at in their turn
                if isinstance(part, Named):
                    files += [(shown_name(argument), part, token.value) for token in argument.tokens]
        return files

    def settings(self, page: str) -> tuple[Path, str] | None:
        """A file for ``--config`` beside a report that repeats the run; None beside a pipe, or if made from it."""
        from ...common.schema import toml_text

        path = Path(page).with_suffix(".run.toml")
        own = any(place_of(config) == place_of(path) for _, mark, config in self.files if mark.role == "options")
        if own or is_device(Path(page)):
            return None
        table: dict[str, Any] = {"command": self.command}
        for argument in self.arguments:
            tokens = argument.tokens if argument.name != "--config" else []
            values = [token.value if token.implicit_value is UNSET else token.implicit_value for token in tokens]
            if values:
                table[argument.name.lstrip("-")] = values[0] if len(values) == 1 else values
        return path, f"{_HEAD}{self.command} --config THIS_FILE\n{toml_text(table)}"


CALL: ContextVar[Call] = ContextVar("call")
"""The command line that runs."""


def shown_name(argument: Argument) -> str:
    """An option as it is typed, or the key of a setting."""
    return argument.name if argument.show else argument.name.lstrip("-")


def shown(option: str) -> str:
    """An option of the command that runs as it is typed, or the key of a setting, by the name of its field."""
    return shown_name(CALL.get().arguments[f"--{option.replace('_', '-')}"])


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, kw_only=True)
class Options:
    """Options as a frozen value, fields named as they are; a command inherits what it takes, and is called."""

    rules: ClassVar[Mapping[str, Rule]] = {"quiet": "verbose"}
    """Options, and what others say of them; those of the classes above hold too."""

    config: Annotated[str | None, Reads("options"), Parameter(metavar="TOML", group=TERMINAL)] = None
    """Options and rarer settings (docs/settings.md) from a file, as every report writes one; what is typed goes
    first."""
    quiet: Annotated[bool, Parameter(group=TERMINAL)] = False
    """Print no screen and no notes: files and exit status tell; what is asked for as text is printed."""
    verbose: Annotated[bool, SETTING] = False
    """Print every step with its time."""

    def __init_subclass__(cls, group: Group | None = None, without: Sequence[str] = ()) -> None:
        """Make the class a dataclass, the options that it adds a ``group`` of the help, others left out again."""
        own, hints = cls.__annotations__, get_type_hints(cls, include_extras=True)
        for name in own:
            kind, *marked = get_args(hints[name]) if get_origin(hints[name]) is Annotated else [hints[name]]
            grouped = group and kind is not ClassVar and not isinstance(vars(cls).get(name), Field)  # by position
            own[name] = Annotated[(kind, Parameter(group=group), *marked)] if grouped else hints[name]
        for name in without:
            own[name] = Annotated[None, Parameter(parse=False)]
            setattr(cls, name, None)
        cls.rules = ChainMap(*(vars(part).get("rules", {}) for part in cls.__mro__))
        dataclass(frozen=True, kw_only=True)(cls)

    def __call__(self) -> bool | None:
        """Run the command; False: do not use its answer."""
        raise NotImplementedError

    def check(self) -> None:
        """Refuse options that would have no effect, before any work is done."""
        for option in filter(self.has, self.rules):
            match self.rules[option]:
                case tuple(needed) if not any(map(self.has, needed)):
                    self.refuse(option, f"has no effect without {' or '.join(map(shown, needed))}")
                case str(other) if getattr(self, option) and getattr(self, other):
                    self.refuse(option, f"and {shown(other)}: give one of them")
                case dict(chosen):
                    ((chooser, choices),) = chosen.items()
                    if (choice := getattr(self, chooser)) not in choices:
                        known = " or ".join(filter(None, choices))
                        self.refuse(option, f"belongs to {shown(chooser)} {known}, not to {choice}")

    def tell(self, *lines: str) -> None:
        """Print lines no wider than the terminal, unless the run is quiet."""
        from ..report.blocks import Notes, Report, print_report

        if not self.quiet:
            print_report(Report("", [Notes(lines)]), details=True)

    def has(self, option: str) -> bool:
        """True for an option that was given."""
        argument = CALL.get().arguments.get(f"--{option.replace('_', '-')}", default=None)
        return argument is not None and bool(argument.tokens)

    def refuse(self, option: str, because: str) -> None:
        """Refuse an option that would have no effect."""
        if self.has(option):
            raise InputError(f"{shown(option)} {because}")


def application(words: Sequence[str] = ()) -> App:
    """All commands, each imported when it is called; ``words``: the command line that it will read."""

    def read(_: App, names: tuple[str, ...], arguments: Arguments) -> None:
        command = " ".join(names)
        CALL.set(Call(tuple(words), command, arguments))
        for argument in arguments:
            if argument.tokens and not argument.show:
                key = shown_name(argument)
                text = f"write {key} = .. into a file and give that by --config"
                raise InputError(f"{key} is a setting, not an option: {text}")
        # What files say of options that are not typed; paths are from the working folder.
        for path in [
            token.value for argument in arguments if argument.name == "--config" for token in argument.tokens
        ]:
            from cyclopts.config import Dict

            from ...common.schema import TOML_BYTES, read_text, toml_data  # which --help does without

            table = toml_data(read_text(path, TOML_BYTES), f"--config {path}")
            meant = table.pop("command", command)
            if meant != command:
                raise InputError(
                    f"--config {path}: is for 'dynident {meant}', not for 'dynident {command}': "
                    f"give a file of {command!r}, or call {meant!r}"
                )
            if "config" in table:
                raise InputError(
                    f"--config {path}: a file of options cannot name another one: remove its key config"
                )
            Dict(table, source=path, use_commands_as_keys=False)(App(), (), arguments)

    app = App(
        name="dynident",
        help="Identifies the payload of a robot arm, and the arm itself, from joint recordings.",
        version=lambda: "\n".join(f"{name.lower()} {number}" for name, number in versions().items()),
        help_format="markdown",  # whose texts may stand in several lines of the source
        version_format="plaintext",
        default_parameter=Parameter(negative=(), show_default=False, allow_repeating=True),
        group_parameters=GENERAL,
        group_arguments=Group("arguments", sort_key=-2),
        config=read,
    )
    for place, (name, (where, about)) in enumerate(COMMANDS.items()):
        above, _, last = name.rpartition(" ")
        if where:
            (app[above] if above else app).command(f"{__package__}.{where}", name=last, help=about, sort_key=place)
        else:
            app.command(App(name=name, help=about, sort_key=place))
    app.register_install_completion_command(help="Complete words of dynident in your shell.")
    return app


def run(words: Sequence[str]) -> int:
    """Find the command of a command line and call it."""
    try:
        try:
            called, bound, _ = application(words).parse_args(words, exit_on_error=False, print_error=False)
        except CycloptsError as error:
            name = " ".join(["dynident", *(error.command_chain or ())])
            raise InputError(f"{_text(error)} (see {name} --help)") from None
        bound.apply_defaults()
        options = called(*bound.args, **bound.kwargs)
        if not isinstance(options, Options):  # a text that was asked for, or the help for want of a command
            return ANSWERED if CALL.get(None) or not _ASKING.isdisjoint(words) else BAD_INPUT
        check_paths(call := CALL.get())
        options.check()
        _manner.set("quiet" if options.quiet else "verbose" if options.verbose else "plain")
        begin = time.monotonic()
        with keeping([path for _, mark, path in call.files if mark.kind == "input"]):
            status = DO_NOT_USE if options() is False else ANSWERED
        if options.verbose:
            print(f"dynident: {time.monotonic() - begin:6.1f} s  {call.command}: done", file=sys.stderr)
        return status
    except InputError as error:  # the settings file is named of whose key it speaks first
        given = CALL.get(None)
        for argument in (argument for argument in given.arguments if argument.tokens) if given else ():
            source, key = argument.tokens[0].source, re.escape(shown_name(argument))
            if source != "cli" and re.match(rf"{key}(?![\w-])", str(error)):
                raise InputError(f"{source}: {error}") from None
        raise


def _text(error: CycloptsError) -> str:
    """Tell what is wrong with the words of a command line, as a user knows them."""
    argument, call = error.argument, CALL.get(None)
    if call and isinstance(error, MissingArgumentError):  # a misspelt option often is the one that is missing
        known = {name for one in call.arguments for name in one.names} | _ASKING
        options = (word.partition("=")[0] for word in call.words if word.startswith("--"))
        if (unknown := next((option for option in options if option not in known), None)) is not None:
            token = Token(keyword=unknown, source="cli")
            error = UnknownOptionError(token=token, argument_collection=call.arguments, verbose=False)
    match error:
        case UnknownOptionError() if error.token.source != "cli":
            key = ".".join(re.findall(r"\[(.*?)\]", error.token.keyword or ""))
            keys = [one.name.lstrip("-") for one in error.argument_collection if one.parse]
            close = get_close_matches(key, keys, 1, 0.5)
            text = f"did you mean {close[0]}?" if close else "docs/settings.md has all of them"
            return f"{error.token.source}: there is no key {key}: {text}"
        case UnknownOptionError():  # a setting is none that could be meant
            error.argument_collection = error.argument_collection.filter_by(show=True)
        case CoercionError() if error.msg is not None and argument is not None:
            return f"{shown_name(argument)}: {error.msg}"
        case MissingArgumentError() if argument is not None:
            metavar = argument.parameter.metavar or ""
            value = metavar if " " in metavar else "a value"
            return f"give {argument.name}" if error.keyword is None else f"{error.keyword} needs {value}"
        case UnusedCliTokensError() if error.unused_tokens:
            return f"{error.unused_tokens[0]!r} is one word too many"
    return str(error)


def check_paths(call: Call) -> None:
    """Refuse what cannot be written, or would overwrite an input or another output, before any work is done."""
    named = call.files
    for page in [path for name, _, path in named if name == "--report" and Path(path).name]:
        if (settings := call.settings(page)) is not None:
            beside = settings[0]
            if beside.is_file() and not beside.read_bytes().startswith(_HEAD.encode()):
                raise InputError(
                    f"--report {page!r}: {beside} beside it would be overwritten, which holds no options of a "
                    "run: move it, or give the report another name"
                )
            named.append(("--report's options", Named("file"), str(beside)))
    read = ((place_of(path), name) for name, mark, path in named if mark.kind == "input" and path)
    # A shipped robot's name is no file; folders may hold what several options write.
    files, folders = {place: name for place, name in read if place.exists()}, dict[Path, str]()
    for name, mark, path in named:
        if mark.kind == "input" or (mark.kind, path) == ("stream", "-"):
            continue
        place = place_of(path)
        if mark.kind == "folder":
            good = next(above for above in (place, *place.parents) if above.exists()).is_dir()
            why = "is a file, not a folder" if place.is_file() else "a folder cannot be made there"
            needed, rivals, own = f"{why}: give another path", files, folders
        else:
            good = not place.is_dir() and place.parent.is_dir()
            needed = "no file can be written there: make the folder, or give another path"
            rivals, own = files | folders, files
        if not path or not good:
            raise InputError(f"{name} {path!r}: {needed}")
        if place in rivals and not is_device(place):  # a pipe or a terminal may be named twice
            raise InputError(f"{name} {path!r}: {rivals[place]} names this file too: give another one")
        if mark.endings and not path.lower().endswith(mark.endings):
            raise InputError(f"{name} {path!r}: its name ends in {' or '.join(mark.endings)}")
        own[place] = name


@contextmanager
def about(*options: str, fault: type[Exception] = ValueError) -> Iterator[None]:
    """Say of whatever is wrong within which options it is about, if any; a ``fault`` is the user's to mend."""
    try:
        yield
    except fault as error:
        named = not options or any(option in str(error) for option in options)
        raise InputError(str(error) if named else f"{', '.join(options)}: {error}") from None


def note(text: str) -> None:
    """Print a line that is worth knowing."""
    if _manner.get() != "quiet":
        print(f"dynident: note: {one_line(text)}", file=sys.stderr)


def withheld(done: str, why: str) -> bool:
    """Say that what was asked for is not done, and why, for its numbers must not be used; gives that."""
    print(one_line(f"dynident: not {done}: {why}"), file=sys.stderr)
    return False


@contextmanager
def status(label: str) -> Iterator[Progress]:
    """Show what is being done; gives a function that changes the words and tells the share, where it is known."""
    if (manner := _manner.get()) == "quiet":
        yield silent
        return
    # A line that goes when the work is done; where no share is known its bar only moves. Names hold brackets.
    from rich import progress as rich
    from rich.console import Console

    words, console = rich.TextColumn("{task.description}", markup=False), Console(stderr=True)
    columns = (rich.SpinnerColumn(), words, rich.BarColumn(), rich.TaskProgressColumn(), rich.TimeRemainingColumn())
    hidden = manner == "verbose" or not console.is_terminal  # elsewhere it would leave an empty line
    with rich.Progress(*columns, console=console, transient=True, disable=hidden) as shown:
        task, begin, told = shown.add_task(label, total=None), time.monotonic(), ""
        last: float | None = None

        def progress(words: str, share: float | None = None, /) -> None:
            nonlocal task, told, last
            if manner == "verbose" and words != told:
                print(f"dynident: {time.monotonic() - begin:6.1f} s  {one_line(words)}", file=sys.stderr)
            if (share is None) != (last is None) or (share or 0.0) < (last or 0.0):  # other work: its own time left
                shown.remove_task(task)
                task = shown.add_task(words, total=None if share is None else 1.0)
            told, last = words, share
            shown.update(task, description=words, completed=share)

        progress(label)
        yield progress
