"""Which logs there are, and what is known of each: its arm, day, temperature and told payload."""

import csv
import re
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from difflib import get_close_matches
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from ...common.errors import InputError
from ...common.files import place_of
from ...common.schema import read_text

KNOWN = ("arm", "day", "temperature", "payload")
"""What may be known of a log: the arm's own name, ISO day or time, deg C, and kg that the controller was told."""
SUFFIXES = (".csv", ".csv.gz", ".tsv", ".tsv.gz", ".npz", ".mat", ".parquet")
"""Files of a folder that are taken for logs."""

_CLOCKS = (9.0e8, 4.1e9)  # s since 1970: 1998 to 2099
_NIGHT = 2.0  # days that a log's clock may be beside the day told: a day without time, zones, a night's two days


class Log(NamedTuple):
    """A log, by path or URL, and what is known of it; ``wrong``: why it cannot be used.

    ``sha256`` of its bytes and ``key``, the name of its equations in a store, once they are known.
    """

    file: str
    about: Mapping[str, str]
    wrong: str = ""
    sha256: str = ""
    key: str = ""


def found_logs(paths: Sequence[str]) -> tuple[str, ...]:
    """Logs by names, globs, folders and URLs, each once, in the order of their names.

    Raises:
        InputError: if one names nothing.
    """
    logs = set[str]()
    for path in paths:
        inside = list(_inside(path))
        if not inside:
            raise InputError(f"{path}: no log there")
        logs.update(inside)
    return tuple(sorted(logs))


def _inside(path: str) -> Iterator[str]:
    if "://" in path:
        with _remote(path) as (system, _):
            places = system.glob(path) if "*" in path else [path]
            yield from (place if "://" in place else system.unstrip_protocol(place) for place in places)
    elif Path(path).is_dir():
        yield from (str(file) for file in Path(path).rglob("*") if file.is_file() and file.name.endswith(SUFFIXES))
    elif Path(path).exists():
        yield path
    elif path:
        anchor = Path(path).anchor
        inside = Path(anchor).glob(str(Path(path).relative_to(anchor)))
        yield from (str(file) for file in inside if file.is_file())


@contextmanager
def _remote(url: str) -> Iterator[tuple[Any, str]]:
    """The file system of a URL and the place in it; what goes wrong within the block is told in a line."""
    try:
        import fsspec

        yield fsspec.core.url_to_fs(url)
    except ModuleNotFoundError:
        raise InputError(f"{url}: logs at a URL need fsspec: pip install 'dynident[fleet]'") from None
    except (ValueError, OSError, ImportError) as error:
        raise InputError(f"{url}: cannot be opened: {error}") from None


@contextmanager
def local(path: str) -> Iterator[str]:
    """A log as a file of this machine; one at a URL is copied for the time being.

    Raises:
        InputError: if it cannot be.
    """
    if "://" not in path:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = str(Path(folder) / PurePosixPath(path).name)
        with _remote(path) as (system, place):
            system.get_file(place, copy)
        yield copy


def catalog(logs: Sequence[str], pattern: str = "", table: str | None = None) -> tuple[Log, ...]:
    """What is known of each log, by its path or by a table; of a table all of its files.

    Args:
        logs: paths.
        pattern: the end of a path, "{arm}/{day}.csv": words of ``KNOWN`` in braces, ``*`` for anything else.
        table: CSV with the columns file, and of ``KNOWN``; files are relative to it.

    Raises:
        InputError: for a pattern that no path has, or a table that cannot be read.
    """
    if table is not None:
        return _of_table(table, logs)
    if not pattern:
        return tuple(Log(file, {}) for file in logs)
    form = _form(pattern)
    found = []
    for log in logs:
        match = form.search(Path(log).as_posix() if "://" not in log else log)
        about = match.groupdict() if match else {}
        found.append(Log(log, about, _wrong(about) if match else f"its path does not end in {pattern}"))
    if all(log.wrong for log in found):
        raise InputError(f"--pattern {pattern!r}: no log's path ends so; {logs[0]}: {found[0].wrong}")
    return tuple(found)


def _form(pattern: str) -> re.Pattern[str]:
    parts = []
    for word in re.split(r"(\{\w+\}|\*)", pattern):
        name = word.strip("{}")
        if word.startswith("{"):
            if name not in KNOWN:
                raise InputError(f"--pattern {pattern!r}: {word} is not known; known: {', '.join(KNOWN)}")
            parts.append(f"(?P<{name}>[^/]+?)")
        else:
            parts.append("[^/]*" if word == "*" else re.escape(word))
    try:
        return re.compile("(?:^|/)" + "".join(parts) + "$")
    except re.error as error:
        raise InputError(f"--pattern {pattern!r}: {error}") from None


def _of_table(table: str, logs: Sequence[str]) -> tuple[Log, ...]:
    rows = list(csv.DictReader(read_text(table).splitlines()))
    names = list(rows[0]) if rows else []
    if not {"file", "arm"} <= set(names):
        raise InputError(f"{table}: needs the columns file and arm, and may have {', '.join(KNOWN[1:])}")
    for name in names:
        if name not in ("file", *KNOWN):
            near = get_close_matches(str(name), KNOWN, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise InputError(f"{table}: column {name!r} is not known{hint}")
    listed: dict[str, Log] = {}
    counted = Counter(row["file"] for row in rows)
    for row in rows:
        file, about = row["file"] or "", {name: row[name].strip() for name in KNOWN if row.get(name)}
        twice = f"{table} names it more than once: which row is right?" if counted[file] > 1 else ""
        path = file if "://" in file or Path(file).is_absolute() else str(Path(table).parent / file)
        listed[path] = Log(path, about, twice or _wrong(about))
    named = set(map(_place, listed))
    beside = [Log(log, {}, f"{table} does not name it") for log in logs if _place(log) not in named]
    return tuple(sorted([*listed.values(), *beside], key=lambda log: log.file))


def _place(path: str) -> str:
    return path if "://" in path else str(place_of(path))


def _wrong(about: Mapping[str, str]) -> str:
    """What is wrong with what is known of a log."""
    if not about.get("arm", "-"):
        return "no arm is named"
    try:
        datetime.fromisoformat(about.get("day", "2000-01-01"))
    except ValueError:
        return f"day {about['day']!r} is no date: write 2026-01-31 or 2026-01-31T02:00"
    for name in ("temperature", "payload"):
        try:
            float(about.get(name, "0"))
        except ValueError:
            return f"{name} {about[name]!r} is no number"
    return ""


def other_day(about: Mapping[str, str], start: float) -> str:
    """What is wrong with a log whose own clock tells another day than it is said to be of; empty if nothing is.

    Only times since 1970 tell a day: a log that counts from its own start, or by a clock that was never set, has
    none.

    Args:
        about: what is known of the log.
        start: its first time [s].
    """
    if "day" not in about or not _CLOCKS[0] <= start <= _CLOCKS[1]:
        return ""
    stated = datetime.fromisoformat(about["day"])
    own = datetime.fromtimestamp(start, UTC)
    days = abs((stated.replace(tzinfo=stated.tzinfo or UTC) - own).total_seconds()) / 86400.0
    if days < _NIGHT:
        return ""
    return (
        f"its own clock begins on {own:%Y-%m-%d}, it is said to be of {about['day']}: mend the table or "
        "path, or the log's times (from 0 on, they tell no day)"
    )


def same_time(logs: Iterable[Log]) -> dict[str, str]:
    """Logs of one arm at one time: path -> what is wrong with it."""
    owners: dict[tuple[str, str], str] = {}
    wrong = {}
    for log in logs:
        if not log.wrong and {"arm", "day"} <= set(log.about):
            arm, day = log.about["arm"], log.about["day"]
            if owner := owners.get((arm, day)):
                wrong[log.file] = f"{owner} is of arm {arm!r} at {day} too: give times, or another name"
            owners.setdefault((arm, day), log.file)
    return wrong
