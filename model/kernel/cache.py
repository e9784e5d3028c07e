"""Compiles generated C once and keeps the library.

The cache is keyed by the source, the compiler, the flags and the processor's features. Entries are written
beside their place and moved there in one step, so that processes may race. ``DYNIDENT_CACHE`` moves the
cache, ``DYNIDENT_NO_COMPILER=1`` does without a compiler.
"""

import ctypes
import functools
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# No -ffast-math: linked in, it would switch the whole process to flush-to-zero.
_FLAGS = ("-O2", "-fPIC", "-shared", "-std=gnu11", "-w")
_NATIVE = "-march=native"
_TIMEOUT = 120.0  # s


class CompilerUnavailable(RuntimeError):  # noqa: N818
    """There is no C compiler that works here; the NumPy path does the same work."""


def compiled_library(source: str) -> ctypes.CDLL:
    """Load the library of a C source, compiling it if the cache does not hold it.

    Raises:
        CompilerUnavailable: without a working compiler or with ``DYNIDENT_NO_COMPILER=1``.
    """
    if os.environ.get("DYNIDENT_NO_COMPILER", "") not in ("", "0"):
        raise CompilerUnavailable("DYNIDENT_NO_COMPILER is set")
    compiler = _compiler()
    key = "\n".join((source, _identity(compiler), " ".join(_FLAGS), _NATIVE, _processor()))
    path = cache_folder() / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}{_suffix()}"
    if path.is_file():
        try:
            return _load(path)
        except OSError:
            path.unlink(missing_ok=True)  # a damaged entry is made anew
    _compile(compiler, source, path)
    return _load(path)


def cache_folder() -> Path:
    """The folder of compiled code, private to the user; a temporary one if it cannot be written."""
    wanted = os.environ.get("DYNIDENT_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(wanted) if wanted else Path(base) / "dynident"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return _temporary_folder()


@functools.cache
def _temporary_folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="dynident-"))


def _suffix() -> str:
    return ".dll" if sys.platform == "win32" else ".so"


def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    if not hasattr(library, "kernel"):
        raise OSError(f"{path} holds no kernel")
    return library


@functools.cache
def _compiler() -> Path:
    for name in filter(None, (os.environ.get("CC"), "cc", "gcc", "clang")):
        program = shutil.which(name)
        if program is not None:
            return Path(program).resolve()
    raise CompilerUnavailable("no C compiler found (cc, gcc or clang)")


def _identity(compiler: Path) -> str:
    """Which compiler this is, without starting it."""
    state = compiler.stat()
    return f"{compiler} {state.st_size} {state.st_mtime_ns}"


def _compile(compiler: Path, source: str, path: Path) -> None:
    """Compile beside ``path`` and move the result there in one step."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
    os.close(descriptor)
    try:
        for flags in ((*_FLAGS, _NATIVE), _FLAGS):
            command = [str(compiler), *flags, "-x", "c", "-", "-o", name, "-lm"]
            answer = subprocess.run(
                command, input=source, capture_output=True, text=True, timeout=_TIMEOUT, check=False
            )
            if answer.returncode == 0:
                Path(name).replace(path)
                return
        raise CompilerUnavailable(f"the C compiler failed: {answer.stderr.strip()[:200]}")
    finally:
        Path(name).unlink(missing_ok=True)


@functools.cache
def _processor() -> str:
    """The processor's features: compiled code may use all of them."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line for line in lines if line.startswith(("flags", "Features")))
    except (OSError, StopIteration):
        return f"{platform.machine()} {platform.processor()}"
