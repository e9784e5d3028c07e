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
        for option, rule in self.rules.items():
            match rule:
                case tuple() if not any(map(self.has, rule)):
                    self.refuse(option, f"has no effect without {' or '.join(map(shown, rule))}")
                case str() if getattr(self, option) and getattr(self, rule):
                    self.refuse(option, f"and {shown(rule)}: give one of them")
                case dict():
                    ((chooser, choices),) = rule.items()
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
        return bool(CALL.get().given(option))

    def refuse(self, option: str, because: str) -> None:
        """Refuse an option that would have no effect."""
        if self.has(option):
            raise InputError(f"{shown(option)} {because}")


@dataclass(frozen=True)
class Call:
    """A command line that was read."""

    words: tuple[str, ...]  # as they were typed
    command: str  # its name, "robot show"
    arguments: Arguments  # every option, with the words that it was given

    def named(self, *, reads: bool) -> Iterator[tuple[str, Named, str]]:
        """Paths of inputs, or of what is written: the option that names it, its mark, and the path."""
        for argument in self.arguments:
            for mark in marks(argument.field_info.annotation):
                if isinstance(mark, Named) and (mark.kind == "input") is reads:
                    for token in argument.tokens:
                        yield shown_name(argument), mark, token.value

    def given(self, option: str) -> tuple[str, ...]:
        """Words that were given for an option; "joint_names" stands for --joint-names."""
        argument = self.arguments.get(f"--{option.replace('_', '-')}", default=None)
        return tuple(token.value for token in argument.tokens) if argument is not None else ()

    def settings_file(self, page: str) -> Path | None:
        """The file beside a report that repeats the run; None beside a pipe, or if it was made from that file."""
        path = Path(page).with_suffix(".run.toml")
        own = any(place_of(config) == place_of(path) for config in self.given("config"))
        return None if own or is_device(Path(page)) else path

    def settings_text(self) -> str:
        """A file for ``--config`` that repeats this line: each option by its name without dashes."""
        from ...common.schema import toml_text

        table: dict[str, Any] = {"command": self.command}
        for argument in self.arguments:
            tokens = argument.tokens if argument.name != "--config" else []
            values = [token.value if token.implicit_value is UNSET else token.implicit_value for token in tokens]
            if values:
                table[argument.name.lstrip("-")] = values[0] if len(values) == 1 else values
        return f"{_HEAD}{self.command} --config THIS_FILE\n{toml_text(table)}"


CALL: ContextVar[Call] = ContextVar("call")
"""The command line that runs."""


def application(calls: list[Call], words: Sequence[str]) -> App:
    """All commands, each imported when it is called; ``calls`` gets the command line ``words`` when it was read."""

    def read(_: App, names: tuple[str, ...], arguments: Arguments) -> None:
        calls.append(call := Call(tuple(words), " ".join(names), arguments))
        for argument in arguments:
            if argument.tokens and not argument.show:
                key = shown_name(argument)
                text = f"write {key} = .. into a file and give that by --config"
                raise InputError(f"{key} is a setting, not an option: {text}")
        for path in call.given("config"):  # what it says of options that are not typed; paths are from the folder
            from cyclopts.config import Dict

            from ...common.schema import TOML_BYTES, read_text, toml_data  # which --help does without

            table = toml_data(read_text(path, TOML_BYTES), f"--config {path}")
            meant = table.pop("command", call.command)
            if meant != call.command:
                raise InputError(
                    f"--config {path}: is for 'dynident {meant}', not for 'dynident {call.command}': "
                    f"give a file of {call.command!r}, or call {meant!r}"
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
    calls: list[Call] = []
    try:
        called, bound, _ = application(calls, words).parse_args(words, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        name = " ".join(["dynident", *(error.command_chain or ())])
        if calls and isinstance(error, MissingArgumentError):  # a misspelt option often is the one that is missing
            known = {name for argument in calls[-1].arguments for name in argument.names} | _ASKING
            options = (word.partition("=")[0] for word in words if word.startswith("--"))
            if (unknown := next((option for option in options if option not in known), None)) is not None:
                token, found = Token(keyword=unknown, source="cli"), calls[-1].arguments
                error = UnknownOptionError(token=token, argument_collection=found, verbose=False)
        raise InputError(f"{_text(error)} (see {name} --help)") from None
    bound.apply_defaults()
    try:
        options = called(*bound.args, **bound.kwargs)
        if not isinstance(options, Options):  # a text that was asked for, or the help for want of a command
            return ANSWERED if calls or not _ASKING.isdisjoint(words) else BAD_INPUT
        call = calls[-1]
        CALL.set(call)
        check_paths(call)
        options.check()
        _manner.set("quiet" if options.quiet else "verbose" if options.verbose else "plain")
        begin = time.monotonic()
        with keeping([path for _, _, path in call.named(reads=True)]):
            status = DO_NOT_USE if options() is False else ANSWERED
        if options.verbose:
            print(f"dynident: {time.monotonic() - begin:6.1f} s  {call.command}: done", file=sys.stderr)
        return status
    except InputError as error:  # the settings file is named of whose key it speaks first
        for argument in (argument for call in calls for argument in call.arguments if argument.tokens):
            source, key = argument.tokens[0].source, re.escape(shown_name(argument))
            if source != "cli" and re.match(rf"{key}(?![\w-])", str(error)):
                raise InputError(f"{source}: {error}") from None
        raise


def shown_name(argument: Argument) -> str:
    """An option as it is typed, or the key of a setting."""
    return argument.name if argument.show else argument.name.lstrip("-")


def shown(option: str) -> str:
    """An option of the command that runs as it is typed, or the key of a setting, by the name of its field."""
    return shown_name(CALL.get().arguments[f"--{option.replace('_', '-')}"])


def check_paths(call: Call) -> None:
    """Refuse what cannot be written, or would overwrite an input or another output, before any work is done."""
    # A shipped robot's name is no file; folders may hold what several options write.
    read = ((place_of(path), name) for name, _, path in call.named(reads=True) if path)
    owners = {place: name for place, name in read if place.exists()}
    folders: dict[Path, str] = {}
    written = list(call.named(reads=False))
    for page in call.given("report"):
        if not Path(page).name or (beside := call.settings_file(page)) is None:
            continue
        if beside.is_file() and not beside.read_bytes().startswith(_HEAD.encode()):
            raise InputError(
                f"--report {page!r}: {beside} beside it would be overwritten, which holds no options of a "
                "run: move it, or give the report another name"
            )
        written.append(("--report's options", Named("file"), str(beside)))
    for name, mark, path in written:
        if (mark.kind, path) == ("stream", "-"):
            continue
        place = place_of(path)
        if mark.kind == "folder":
            possible = next(above for above in (place, *place.parents) if above.exists()).is_dir()
            why = "is a file, not a folder" if place.is_file() else "a folder cannot be made there"
            needed, rivals, own = f"{why}: give another path", owners, folders
        else:
            possible = not place.is_dir() and place.parent.is_dir()
            needed = "no file can be written there: make the folder, or give another path"
            rivals, own = owners | folders, owners
        if not path or not possible:
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


def marks(hint: Any) -> Iterator[Any]:
    """Marks of a type and its parts beside the types themselves."""
    yield from getattr(hint, "__metadata__", ())
    for part in get_args(hint):
        yield from marks(part)


def _text(error: CycloptsError) -> str:
    """Tell what is wrong with the words of a command line, as a user knows them."""
    if isinstance(error, UnknownOptionError) and error.token.source != "cli":
        key = ".".join(re.findall(r"\[(.*?)\]", error.token.keyword or ""))
        keys = [argument.name.lstrip("-") for argument in error.argument_collection if argument.parse]
        close = get_close_matches(key, keys, 1, 0.5)
        text = f"did you mean {close[0]}?" if close else "docs/settings.md has all of them"
        return f"{error.token.source}: there is no key {key}: {text}"
    if isinstance(error, UnknownOptionError):  # a setting is none that could be meant
        error.argument_collection = error.argument_collection.filter_by(show=True)
    if isinstance(error, CoercionError) and error.msg is not None and error.argument is not None:
        source = error.token.source if error.token else "cli"
        return f"{'' if source == 'cli' else f'{source}: '}{shown_name(error.argument)}: {error.msg}"
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        several = " " in ((error.argument.parameter.metavar or "") if error.argument.parameter else "")
        value = error.argument.parameter.metavar if several else "a value"
        return f"give {error.argument.name}" if error.keyword is None else f"{error.keyword} needs {value}"
    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        return f"{error.unused_tokens[0]!r} is one word too many"
    return str(error)


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
    if manner == "verbose":
        begin, told = time.monotonic(), ""

        def step(words: str, _share: float | None = None, /) -> None:
            nonlocal told
            if words != told:
                print(f"dynident: {time.monotonic() - begin:6.1f} s  {one_line(words)}", file=sys.stderr)
            told = words

        step(label)
        yield step
        return
    # A line that goes when the work is done; where no share is known its bar only moves. Names hold brackets.
    from rich import progress as rich
    from rich.console import Console

    words, console = rich.TextColumn("{task.description}", markup=False), Console(stderr=True)
    columns = (rich.SpinnerColumn(), words, rich.BarColumn(), rich.TaskProgressColumn(), rich.TimeRemainingColumn())
    hidden = not console.is_terminal  # elsewhere it would leave an empty line
    with rich.Progress(*columns, console=console, transient=True, disable=hidden) as shown:
        task = shown.add_task(label, total=None)
        last: float | None = None

        def progress(words: str, share: float | None = None, /) -> None:
            nonlocal task, last
            if (share is None) != (last is None) or (share or 0.0) < (last or 0.0):  # other work: its own time left
                shown.remove_task(task)
                task = shown.add_task(words, total=None if share is None else 1.0)
            last = share
            shown.update(task, description=words, completed=share)

        yield progress
