"""Recordings of a fleet: their logs, what is known of each, and the folder that holds their equations."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ...common.errors import InputError
from ...common.files import made_folder, write_bytes
from ...common.schema import Document, convert, naming, read_json, write_json
from ...estimation.equations.equations import Equations
from ...estimation.fit.estimate import Estimate, Gains
from ...model import BaseParameters, Processing, Robot
from ..extras import parquet_bytes, parquet_rows
from ..logs.map import LogMap
from ..logs.read import SUFFIXES

KNOWN = ("arm", "day", "payload")
"""Facts that may be known of a log: the arm's own name, ISO day or time, and kg that the controller was told."""
_CLOCKS = (9.0e8, 4.1e9)  # s since 1970: 1998 to 2099
_YEARS = (1970, 2100)
_NIGHT = 2.0  # days that a log's clock may be beside the day told: a day without time, zones, a night's two days
_AGAIN = "run 'dynident fleet reduce' again, what is done is kept"
_REMEDY = f"delete it and {_AGAIN}"


class Log(Document, frozen=True, omit_defaults=True):
    """A log and what is known of it; ``reason``: why it is refused, if it is.

    ``sha256`` of its bytes and ``key``, the name of its equations in a store, once they are known.
    """

    file: str
    arm: str | None = None
    day: str | None = None
    payload: str | None = None
    reason: str = ""
    sha256: str = ""
    key: str = ""

    def other_day(self, start: float) -> str:
        """Fault of a log whose clock, at ``start`` [s], tells another day than it is said to be of; empty if none.

        Only times since 1970 tell a day: a log that counts from its own start, or by a clock that was never set,
        has none.
        """
        if self.day is None or not _CLOCKS[0] <= start <= _CLOCKS[1]:
            return ""
        stated, own = datetime.fromisoformat(self.day), datetime.fromtimestamp(start, UTC)
        apart = abs(stated.replace(tzinfo=stated.tzinfo or UTC) - own)
        if apart < timedelta(days=_NIGHT):
            return ""
        fault = f"its clock starts on {own:%Y-%m-%d} but it is said to be of {self.day}"
        return f"{fault}: correct the path, or the log's times (from 0 on, they state no day)"


def found_logs(paths: Sequence[str]) -> tuple[str, ...]:
    """Find logs by names, globs and folders, none of them in vain: each log once, in the order of their names."""
    logs = set[str]()
    for path in paths:
        place, anchor = Path(path), Path(path).anchor
        inside = [place] if place.exists() else Path(anchor).glob(str(place.relative_to(anchor)))
        if place.is_dir():
            inside = (file for file in place.rglob("*") if file.name.endswith(SUFFIXES))
        found = {str(file) for file in inside if file == place or file.is_file()}
        logs |= found
        if not found:
            raise InputError(f"{path}: no log there")
    return tuple(sorted(logs))


def catalog(logs: Sequence[str], pattern: str = "") -> tuple[Log, ...]:
    """Tell by each log's path what is known of it; a pattern that no path has is refused.

    ``pattern`` is the end of a path, "{arm}/{day}.csv": words of ``KNOWN`` in braces, ``*`` for anything else.
    """
    if not pattern:
        return tuple(map(Log, logs))
    if unknown := [word for word in re.findall(r"\{(\w+)\}", pattern) if word not in KNOWN]:
        raise InputError(f"--pattern {pattern!r}: {{{unknown[0]}}} is not known; known: {', '.join(KNOWN)}")
    form = re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>[^/]+?)", re.escape(pattern).replace(r"\*", "[^/]*"))
    try:
        ending = re.compile(f"(?:^|/){form}$")
    except re.error as error:
        raise InputError(f"--pattern {pattern!r}: {error}") from None
    found = []
    for path in logs:
        match = ending.search(Path(path).as_posix())
        log = Log(path, **(match.groupdict() if match else {}))
        wrong = f"day {log.day!r} is no date: write 2026-01-31 or 2026-01-31T02:00"
        with suppress(ValueError):
            year = datetime.fromisoformat(log.day or "2000-01-01").year
            wrong = f"payload {log.payload!r} is no number"
            float(log.payload or 0.0)
            wrong = "no arm is named" if log.arm == "" else ""
            if not _YEARS[0] <= year <= _YEARS[1]:
                wrong = f"day {log.day!r} is of no recording: years {_YEARS[0]} to {_YEARS[1]} are"
        wrong = wrong if match else f"its path does not end in {pattern}"
        found.append(msgspec.structs.replace(log, reason=wrong))
    if all(log.reason for log in found):
        raise InputError(f"--pattern {pattern!r}: no log's path ends so; {logs[0]}: {found[0].reason}")
    return tuple(found)


def same_time(logs: Iterable[Log]) -> dict[str, str]:
    """Find logs of one arm at one time: path -> what is wrong with it."""
    owners, wrong = dict[object, str](), dict[str, str]()
    for log in logs:
        known = not log.reason and log.arm is not None and log.day is not None
        if known and (owner := owners.setdefault((log.arm, log.day), log.file)) != log.file:
            wrong[log.file] = f"{owner} is of arm {log.arm!r} at {log.day} too: give times, or another name"
    return wrong


@dataclass(frozen=True)
class Recipe:
    """Settings that make equations of logs."""

    processing: Processing
    drive_gains: tuple[float, ...] | None = None  # [N·m/A or N/A], if currents were read
    gains: Gains | None = None  # unless these are taken as exact
    log_map: LogMap = field(default_factory=LogMap)

    @property
    def fingerprint(self) -> str:
        """Short text that differs between recipes; what a log map is called counts for nothing."""
        unnamed = replace(self, log_map=msgspec.structs.replace(self.log_map, source=""))
        return hashlib.sha256(packed(unnamed)).hexdigest()[:16]

    def key(self, log: Log) -> str:
        """Name of a recording's file: by the log's bytes, what is known of it, and the recipe."""
        identity = packed([log.sha256, log.arm, log.day, log.payload, self.fingerprint])
        return hashlib.sha256(identity).hexdigest()[:32]


@dataclass(frozen=True)
class Stored:
    """A recording of a store: its log, and equations in the robot's base parameters, in blocks of time."""

    log: Log
    robot: Robot
    base: BaseParameters
    equations: Equations

    def parquet(self, estimate: Estimate) -> bytes:
        """A table of one row: the log, the parameters identified by it alone, and the equations, packed."""
        row = {fact: getattr(self.log, fact) for fact in ("file", *KNOWN)} | {"equations": packed(self)}
        row |= {"parameters": estimate.names, "values": estimate.values, "sigma": estimate.sigma}
        return parquet_bytes({name: [value] for name, value in row.items()})


def packed(value: Any) -> bytes:
    """Frozen values as bytes; the same for the same values."""
    return msgspec.msgpack.encode(value, enc_hook=_plain)


def _plain(value: Any) -> Any:
    """An array as its shape, its order in memory, which sums round by, and its bytes; a mapping as a plain one."""
    if isinstance(value, np.ndarray):
        turned = value.flags.f_contiguous and not value.flags.c_contiguous
        return [value.shape, "F" if turned else "C", np.asarray(value, "<f8").tobytes("F" if turned else "C")]
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} has no place in a store")


def _made(kind: Any, value: Any) -> Any:
    shape, order, content = value
    return np.frombuffer(content, "<f8").reshape(shape, order=order)


@dataclass(frozen=True)
class Store:
    """A folder of reduced recordings of one type of robot, made by one recipe; each file is written in one step."""

    root: Path

    @staticmethod
    def made(root: str | Path, robot: Robot, recipe: Recipe) -> "Store":
        """Open the store at a place, made if there is none; one of another robot or recipe is refused."""
        labels = {"robot": robot.name, "fingerprint": robot.fingerprint, "recipe": recipe.fingerprint}
        store = Store(Path(root))
        path = store.root / "store.json"
        if path.exists():
            there = read_json(path, dict[str, str], "give another folder")
            if there != labels:
                kind = "recipe" if there.get("fingerprint") == labels["fingerprint"] else "robot"
                raise InputError(f"{root}: a store of another {kind} ({there.get('robot')}): give another folder")
        elif store.root.is_dir() and any(store.root.iterdir()):
            raise InputError(f"{root}: is a folder of other things: give a new one")
        made_folder(store.root / "recordings")
        if not path.exists():
            write_json(path, labels)
        return store

    @staticmethod
    def opened(root: str | Path) -> "Store":
        """Open a store that is there and was finished once."""
        store = Store(Path(root))
        if not (store.root / "store.json").exists():
            raise InputError(f"{root}: no store: give the --store of 'dynident fleet reduce'")
        if not store.index.exists():
            raise InputError(f"{root}: reduced in part: {_AGAIN}")
        return store

    @property
    def index(self) -> Path:
        """Table of the logs, of those that were refused too."""
        return self.root / "logs.parquet"

    def path(self, key: str) -> Path:
        """Place of a recording's equations."""
        return self.root / "recordings" / f"{key}.parquet"

    def logs(self) -> tuple[Log, ...]:
        """The logs, by name, with a ``reason`` where refused; none as long as the store was never finished."""
        if not self.index.exists():
            return ()
        with naming(self.index, _REMEDY):
            return convert(parquet_rows(self.index, _REMEDY), tuple[Log, ...])

    def finish(self, logs: Iterable[Log]) -> None:
        """Write what is in it, and what was refused, and why."""
        ordered = sorted(logs, key=lambda log: log.file)
        columns = {name: [getattr(log, name) for log in ordered] for name in Log.__struct_fields__}
        write_bytes(self.index, parquet_bytes(columns))

    def read(self, key: str) -> Stored:
        """Read a recording's equations."""
        path = self.path(key)
        rows = parquet_rows(path, _REMEDY, ["equations"])
        try:
            return msgspec.msgpack.decode(rows[0]["equations"], type=Stored, dec_hook=_made)
        except (LookupError, ValueError, TypeError) as error:
            fault = f"not as it was written, or by another version ({error})"
            raise InputError(f"{path}: {fault}: reduce it again") from None
