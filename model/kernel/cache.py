"""Compiles generated C once and keeps the library.

The cache is keyed by the source, the compiler, the flags and the processor's features. Entries are written
beside their place and moved there in one step, so that processes may race; an entry's name holds the checksum
of its content, which is verified before it is loaded. ``DYNIDENT_CACHE`` moves the cache,
``DYNIDENT_NO_COMPILER=1`` does without a compiler.
"""

import atexit
import contextlib
import ctypes
import functools
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

# No -ffast-math: linked in, it would switch the whole process to flush-to-zero.
_FLAGS = ("-O2", "-fPIC", "-shared", "-std=gnu11", "-w")
# GCC's combining of more instructions takes up to half of its time on long straight code, and gains nothing there.
_WAYS = (("-march=native", "--param=max-combine-insns=2"), ("-march=native",), ())  # the first it knows
_PATIENCE = 20.0  # s
_LATE = "to finish within "
_SUFFIX = ".dll" if sys.platform == "win32" else ".so"
_problems: dict[str, str] = {}  # faults of the compilers that this process asked: nobody waits for one twice


class CompilerUnavailable(RuntimeError):  # noqa: N818
    """There is no C compiler that works here; the NumPy path does the same work."""


def compiled_library(source: str) -> ctypes.CDLL:
    """Load the library of a C source, compiling it if the cache does not hold it.

    Raises CompilerUnavailable without a working compiler or with ``DYNIDENT_NO_COMPILER=1``.
    """
    if os.environ.get("DYNIDENT_NO_COMPILER", "") not in ("", "0"):
        raise CompilerUnavailable("DYNIDENT_NO_COMPILER is set")
    compiler = _compiler(os.environ.get("CC", ""))
    state = compiler.stat()  # tells of another compiler without starting it
    identity = f"{compiler} {state.st_size} {state.st_mtime_ns}"
    text = "\n".join((source, identity, " ".join((*_FLAGS, *_WAYS[0])), _processor()))
    key = sha256(text.encode()).hexdigest()[:32]
    problem = OSError()
    # The second folder serves where the first one is full or does not allow code to be loaded.
    for folder in (cache_folder, _temporary_folder):
        try:
            cache = folder()
            for path in cache.glob(f"{key}-*{_SUFFIX}"):
                # Verified before it is mapped: the first use of a truncated library would kill the process.
                if path.stem == f"{key}-{sha256(path.read_bytes()).hexdigest()[:32]}":
                    with contextlib.suppress(OSError):
                        return ctypes.CDLL(str(path))
                path.unlink(missing_ok=True)
            return ctypes.CDLL(str(_compile(compiler, identity, source, cache, key)))
        except OSError as error:
            problem = error
    raise CompilerUnavailable(f"loading compiled code failed: {problem}")


def cache_folder() -> Path:
    """The folder of compiled code, private to the user; a temporary one if that cannot be had."""
    try:
        base = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME")
        given = os.environ.get("DYNIDENT_CACHE")
        folder = Path(given) if given else (Path(base) if base else Path.home() / ".cache") / "dynident"
        # What has to be made is private too, whatever the umask; what is there keeps its mode.
        for missing in reversed([path for path in (folder, *folder.parents) if not path.exists()]):
            missing.mkdir(mode=0o700, exist_ok=True)
        state = folder.stat()
        if hasattr(os, "getuid") and (state.st_uid != os.getuid() or state.st_mode & 0o022):
            return _temporary_folder()  # someone else could put code there
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):  # the second where a user has no home
        return _temporary_folder()


@functools.cache
def _temporary_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="dynident-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def _compiler(chosen: str) -> Path:
    for name in filter(None, (chosen, "cc", "gcc", "clang")):
        if program := shutil.which(name):
            return Path(program).absolute()
    raise CompilerUnavailable("no C compiler found (cc, gcc or clang)")


def _compile(compiler: Path, identity: str, source: str, folder: Path, key: str) -> Path:
    problem = ""
    with tempfile.TemporaryDirectory(dir=folder, suffix=".part", ignore_cleanup_errors=True) as beside:
        made = Path(beside, f"library{_SUFFIX}")
        if identity not in _problems:
            # One that hangs or fails at anything is found out by one line of C.
            _problems[identity] = _asked(compiler, _FLAGS, "int answer(void) { return 0; }", str(made))
        for flags in ((*_FLAGS, *way) for way in _WAYS):
            if _problems[identity]:
                break
            problem = _asked(compiler, flags, source, str(made))
            _problems[identity] = problem if problem.startswith(_LATE) else ""
            if not problem:
                library = folder / f"{key}-{sha256(made.read_bytes()).hexdigest()[:32]}{_SUFFIX}"
                try:
                    return made.replace(library)
                except PermissionError:
                    # Windows keeps a library that another process has loaded; its name holds the checksum.
                    if library.is_file():
                        return library
                    raise
    raise CompilerUnavailable(f"the C compiler failed {_problems[identity] or problem}")


def _asked(compiler: Path, flags: Sequence[str], source: str, target: str) -> str:
    """Compile a source; empty if that went well, or else what the compiler said, in any encoding."""
    command = [str(compiler), *flags, "-x", "c", "-", "-o", target, "-lm"]
    # No pipe to read from: what a compiler started may outlive it and hold that open.
    with tempfile.TemporaryFile() as messages:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=messages, stderr=messages, start_new_session=True
        )
        try:
            process.communicate(source.encode(), timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            process.kill()
            process.wait()
            return f"{_LATE}{_PATIENCE:g} s"
        messages.seek(0)
        message = messages.read().decode(errors="replace").strip()[:200]
        return f"({message or process.returncode})" if process.returncode else ""


@functools.cache
def _processor() -> str:
    """Name the processor's features: compiled code may use all of them."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line for line in lines if line.startswith(("flags", "Features")))
    except (OSError, StopIteration):
        return f"{platform.machine()} {platform.processor()}"
