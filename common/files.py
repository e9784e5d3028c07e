"""Writes files so that a killed run leaves no half one; tables as text."""

import hashlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from io import BufferedReader
from pathlib import Path

from .errors import InputError

_kept: ContextVar[set[Path] | None] = ContextVar("kept", default=None)
"""Files that this run has read or written; None outside a run."""


@contextmanager
def keeping(inputs: Iterable[str | Path]) -> Iterator[None]:
    """Protect ``inputs``, and what is written within, from being overwritten within this block."""
    token = _kept.set({place_of(path) for path in inputs})
    try:
        yield
    finally:
        _kept.reset(token)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file (UTF-8, lines end in a line feed everywhere) in one step; see ``write_bytes``.

    A letter that no encoding has, as names of files may hold, becomes a question mark.
    """
    write_bytes(path, text.encode("utf-8", errors="replace"))


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write a file in one step: under another name in its folder, then renamed.

    A link stays a link, its target is written; what is no regular file (a pipe) is written straight to. A file
    that is there keeps its mode, a new one gets what the umask leaves. InputError names a file that cannot be
    written, or was read or written in this run already.
    """
    target, pending = place_of(path), _kept.get()
    try:
        if is_device(target):
            target.write_bytes(content)
            return
        if pending is not None and target in pending:
            raise InputError(f"{path}: this run has read or written it already: give another name or folder")
        if pending is not None:
            pending.add(target)
        os.umask(umask := os.umask(0o077))
        mode = target.stat().st_mode & 0o7777 if target.exists() else 0o666 & ~umask
        descriptor, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:50]}.")
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(content)
            Path(name).chmod(mode)
            Path(name).replace(target)
        finally:
            Path(name).unlink(missing_ok=True)
    except BrokenPipeError:  # whoever reads has seen enough
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


def place_of(path: str | Path) -> Path:
    """Resolve a path, through whatever links."""
    try:
        return Path(path).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, a NUL in a name
        raise InputError(f"{path}: leads nowhere ({error}): give another path") from None


def opened(path: str | Path) -> BufferedReader:
    """Open a file that ends: nobody knows when a pipe or a device does.

    Raises InputError, which names it, for what is no file, OSError if it cannot be opened.
    """
    if is_device(Path(path)) and not Path(path).is_dir():
        raise InputError(f"{path}: is a pipe or a device, not a file: write its content into a file and give that")
    return Path(path).open("rb")


def checksum(path: str | Path) -> str:
    """SHA-256 of a file's bytes; of a folder, of its files' names and bytes in the order of their names."""
    target = Path(path)
    if not target.is_dir():
        with opened(target) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    inside = sorted(file for file in target.rglob("*") if file.is_file())
    listed = "".join(f"{file.relative_to(target).as_posix()} {checksum(file)}\n" for file in inside)
    return hashlib.sha256(listed.encode()).hexdigest()


def is_device(path: Path) -> bool:
    """True for a pipe, a terminal or the like: what is written there overwrites nothing."""
    return path.exists() and not path.is_file()


def made_folder(path: str | Path) -> Path:
    """Make a folder, and those above it, if missing."""
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made: {error.strerror or error}") from None
    return Path(path)
