"""The file of a passport: NPZ without pickles, closed by a checksum of every byte before it."""

import hashlib
import io
import json
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...common.files import write_bytes
from .codec import Decoder, Encoder
from .passport import Passport

FORMAT = 1
"""Version of the file's form."""
_SEAL = 64  # bytes: the digest in hexadecimals, as the comment that ends a ZIP archive
_LARGEST = 200_000_000
_UNREADABLE = (
    LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RuntimeError, MemoryError, EOFError,
    struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What a tree or an archive raises that is none of this version."""


def passport_bytes(passport: Passport) -> bytes:
    """The file of a passport; the same for the same passport.

    Members of the archive: ``tree`` (JSON), ``numbers`` and ``places``, see ``codec``.
    """
    return packed(passport, robot=passport.robot_fingerprint, recipe=passport.recipe.fingerprint)


def packed(value: Any, **labels: str) -> bytes:
    """A value of ``codec.KINDS``, or several, as bytes; ``labels``: what stands beside it for other programs."""
    encoder = Encoder()
    tree = {"format": FORMAT, **labels, "value": encoder.tree(value)}
    numbers, places = encoder.numbers()
    text = json.dumps(tree, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    content = io.BytesIO()
    np.savez(content, tree=np.frombuffer(text, np.uint8), numbers=numbers.astype("<f8"), places=places)
    archive = content.getvalue()[:-2] + struct.pack("<H", _SEAL)
    return archive + hashlib.sha256(archive).hexdigest().encode()


def write_passport(path: str | Path, passport: Passport) -> None:
    """Write a passport in one step.

    Raises:
        InputError: if it cannot be written.
    """
    write_bytes(path, passport_bytes(passport))


def read_passport(path: str | Path) -> Passport:
    """Read a passport, every byte checked.

    Raises:
        InputError: names the file, and whether it is none, is damaged, or is of another version.
    """
    try:
        if Path(path).stat().st_size > _LARGEST:
            raise InputError(f"{path}: larger than {_LARGEST // 1_000_000} MB: no passport")
        content = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        return passport_of(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def passport_of(content: bytes) -> Passport:
    """The passport that a file's bytes hold.

    Raises:
        InputError: if they are not what was written.
    """
    passport = unpacked(content)
    if not isinstance(passport, Passport):
        raise InputError("no passport: give a file that --passport or 'dynident fleet reduce' wrote")
    return passport


def unpacked(content: bytes) -> Any:
    """The value that bytes hold.

    Raises:
        InputError: if they are not what was written.
    """
    if not content.startswith(b"PK"):
        raise InputError("no passport: give a file that --passport or 'dynident fleet reduce' wrote")
    archive, seal = content[:-_SEAL], content[-_SEAL:]
    if hashlib.sha256(archive).hexdigest().encode() != seal:
        raise InputError("not as it was written: bytes were changed or are missing, or it is no passport")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as data:
            tree: Any = json.loads(data["tree"].tobytes())
            if tree["format"] != FORMAT:
                raise InputError(
                    f"a passport of form {tree['format']}, this version reads {FORMAT}: update dynident"
                )
            return Decoder(data["numbers"], data["places"]).value(tree["value"])
    except _UNREADABLE as error:
        raise InputError(f"a passport of another version of dynident ({error}): make it again") from None
