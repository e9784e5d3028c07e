"""A folder of equations: a file a recording, written whole or not at all, the same whoever reduced them."""

import csv
import hashlib
import io
import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np

from ...common.errors import InputError
from ...common.files import csv_table, made_folder, write_bytes, write_text
from ...common.schema import read_json, read_text
from ...estimation.equations.equations import Equations
from ...estimation.equations.leave_one_out import WithoutEach
from ...estimation.fit.drive_gains import Gains
from ...model import BaseParameters, Processing, Robot
from .catalog import KNOWN, Log

_Kind = TypeVar("_Kind")

_ABOUT, _INDEX, _REFUSED, _EQUATIONS = "store.json", "index.csv", "refused", "equations"
_COLUMNS, _REASONS = ("file", "sha256", *KNOWN, "key"), ("file", "reason")

_AGAIN = "delete it and run 'dynident fleet reduce' again, what is done is kept"


@dataclass(frozen=True)
class Recipe:
    """How equations are made from logs.

    Attributes:
        drive_gains: torque per current [N·m/A or N/A], if currents were read.
        gains: how sure they are; None where they are taken as exact.
        log_map: how logs were read, in words.
    """

    processing: Processing
    drive_gains: tuple[float, ...] | None = None
    gains: Gains | None = None
    log_map: str = ""

    @property
    def fingerprint(self) -> str:
        """Short text that differs between recipes."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Stored:
    """A recording of a store.

    Attributes:
        name: of the log.
        about: what is known of it: the arm's own name, day, temperature, told payload.
        whole: its equations in the robot's base parameters.
        blocks: the same cut in time.
    """

    name: str
    robot: Robot
    base: BaseParameters
    whole: Equations
    blocks: tuple[Equations, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)

    @staticmethod
    def of(
        name: str, robot: Robot, base: BaseParameters, equations: Equations, about: Mapping[str, str]
    ) -> "Stored":
        """A recording by its equations."""
        parts = equations.leave_one_out
        blocks = parts.blocks if isinstance(parts, WithoutEach) else ()
        return Stored(name, robot, base, replace(equations, leave_one_out=()), blocks, dict(about))

    @property
    def equations(self) -> Equations:
        """The equations, with those without each block of time."""
        return replace(self.whole, leave_one_out=WithoutEach(self.blocks)) if self.blocks else self.whole


def packed(value: Any) -> bytes:
    """Frozen values as bytes; the same for the same values."""
    return zlib.compress(msgspec.msgpack.encode(value, enc_hook=_plain), 1)


def unpacked(content: bytes, kind: type[_Kind]) -> _Kind:
    """The value that bytes hold.

    Raises:
        InputError: if they are not what was written.
    """
    try:
        return msgspec.msgpack.decode(zlib.decompress(content), type=kind, dec_hook=_made)
    except (zlib.error, ValueError, TypeError) as error:
        raise InputError(f"not as it was written, or by another version ({error}): reduce it again") from None


def _plain(value: Any) -> Any:
    """An array as its shape, its order in memory, which sums round by, and its bytes; a mapping as a plain one."""
    if isinstance(value, np.ndarray):
        turned = value.flags.f_contiguous and not value.flags.c_contiguous
        return [value.shape, "F" if turned else "C", np.asarray(value, "<f8").tobytes("F" if turned else "C")]
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} has no place in a store")


def _made(kind: Any, value: Any) -> Any:
    """An array of what ``_plain`` made of it."""
    shape, order, content = value
    return np.frombuffer(content, "<f8").reshape(shape, order=order)


@dataclass(frozen=True)
class Store:
    """A folder of reduced recordings of one type of robot, made by one recipe."""

    root: Path

    @staticmethod
    def made(root: str | Path, robot: Robot, recipe: Recipe) -> "Store":
        """The store at a place, made if there is none.

        Raises:
            InputError: if it is of another robot or recipe, or cannot be made.
        """
        labels = {"robot": robot.name, "fingerprint": robot.fingerprint, "recipe": recipe.fingerprint}
        store = Store(Path(root))
        path = store.root / _ABOUT
        if path.exists():
            there = read_json(path, dict[str, str], "give another folder")
            if there != labels:
                kind = "recipe" if there.get("fingerprint") == labels["fingerprint"] else "robot"
                raise InputError(f"{root}: a store of another {kind} ({there.get('robot')}): give another folder")
        elif store.root.is_dir() and any(store.root.iterdir()):
            raise InputError(f"{root}: is a folder of other things: give a new one")
        made_folder(store.root / _EQUATIONS)
        if not path.exists():
            write_text(path, json.dumps(labels, indent=1) + "\n")
        return store

    @staticmethod
    def opened(root: str | Path) -> "Store":
        """A store that is there.

        Raises:
            InputError: if none is, or it was never finished.
        """
        store = Store(Path(root))
        if not (store.root / _ABOUT).exists():
            raise InputError(f"{root}: no store: give the --store of 'dynident fleet reduce'")
        if not (store.root / _INDEX).exists():
            raise InputError(f"{root}: reduced in part: run 'dynident fleet reduce' again, what is done is kept")
        return store

    def path(self, key: str) -> Path:
        """Where a recording's equations are."""
        return self.root / _EQUATIONS / f"{key}.bin"

    def put(self, key: str, content: bytes) -> None:
        """Write a recording's equations.

        Raises:
            InputError: if it cannot be written.
        """
        write_bytes(self.path(key), content)

    def finish(self, logs: Iterable[Log], refused: Mapping[str, str]) -> None:
        """Write what is in it, by the logs' names, and what was refused, and why."""
        listed = [
            [log.file, log.sha256, *(log.about.get(name, "") for name in KNOWN), log.key]
            for log in sorted(logs, key=lambda log: log.file)
        ]
        write_text(self.root / _INDEX, csv_table(_COLUMNS, listed))
        reasons = [[file, reason] for file, reason in sorted(refused.items())]
        write_text(self.root / f"{_REFUSED}.csv", csv_table(_REASONS, reasons))
        write_parquet(self.root / f"{_REFUSED}.parquet", _REASONS, reasons)

    def logs(self) -> tuple[Log, ...]:
        """The recordings, in the order of their files; none as long as it was never finished."""
        return tuple(
            Log(row["file"], {name: row[name] for name in KNOWN if row[name]}, "", row["sha256"], row["key"])
            for row in _rows(self.root / _INDEX, _COLUMNS)
        )

    def refused(self) -> dict[str, str]:
        """Logs that were refused, and why."""
        return {row["file"]: row["reason"] for row in _rows(self.root / f"{_REFUSED}.csv", _REASONS)}

    def read(self, key: str) -> Stored:
        """A recording's equations.

        Raises:
            InputError: if they are not as they were written.
        """
        path = self.path(key)
        try:
            return unpacked(path.read_bytes(), Stored)
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
        except InputError as error:
            raise InputError(f"{path}: {error}") from None


def _rows(path: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    """Rows of a table of the store; none where it was never written.

    Raises:
        InputError: if it is not as it was written.
    """
    if not path.exists():
        return []
    table = csv.DictReader(io.StringIO(read_text(path), newline=""))
    try:
        rows = list(table)
    except csv.Error as error:
        raise InputError(f"{path}: {error}: {_AGAIN}") from None
    if list(table.fieldnames or ()) != list(columns) or any(None in (*row, *row.values()) for row in rows):
        raise InputError(f"{path}: not as it was written: {_AGAIN}")
    return rows


def key_of(sha256: str, about: Mapping[str, str], recipe: Recipe) -> str:
    """Name of a recording's file: by the log's bytes, what is known of it, and the recipe."""
    identity = json.dumps([sha256, sorted(about.items()), recipe.fingerprint])
    return hashlib.sha256(identity.encode()).hexdigest()[:32]


def write_parquet(path: Path, names: Sequence[str], rows: Sequence[Sequence[str | float]]) -> bool:
    """Write a table as Parquet where pyarrow is there; whether it is.

    Raises:
        InputError: if it cannot be written.
    """
    try:
        import pyarrow.parquet
    except ModuleNotFoundError:
        return False
    kind = None if rows else pyarrow.string()
    columns = [pyarrow.array([row[k] for row in rows], kind) for k in range(len(names))]
    content = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(columns, names=list(names)), content)
    write_bytes(path, content.getvalue())
    return True
