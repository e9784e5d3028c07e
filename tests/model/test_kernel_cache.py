"""The cache of compiled kernels: right answers whatever happens to it."""

import os
import shutil
import stat
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from dynident.model.kernel import cache

pytestmark = pytest.mark.skipif(not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="needs a C compiler")

SOURCE = "double kernel(double x) { return x + 1.0; }"

SCRIPT = """
import sys, time
from pathlib import Path
import casadi as ca, numpy as np
from dynident.model.kernel.kernel import Kernel
if len(sys.argv) > 1:
    Path(sys.argv[1], f"ready{sys.argv[2]}").touch()
    while not Path(sys.argv[1], "go").exists():
        time.sleep(0.001)
x = ca.SX.sym("x", 2)
kernel = Kernel(ca.Function("f", [x], [ca.sin(x[0]) * x[1] + 3]))
values = np.random.default_rng(0).normal(size=(101, 2))
assert np.allclose(kernel(values)[0], np.sin(values[:, 0]) * values[:, 1] + 3, rtol=1e-14, atol=1e-14)
tiny = np.array([1e-310])
assert tiny[0] / 2 == 5e-311 and (tiny / 2)[0] == 5e-311 and float("1e-310") * 0.5 > 0.0
print("compiled" if kernel.compiled else "numpy")
"""


def _start(folder: Path, *arguments: str, **variables: str) -> "subprocess.Popen[str]":
    environment = {**os.environ, "DYNIDENT_CACHE": str(folder), **variables}
    command = [sys.executable, "-c", SCRIPT, *arguments]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _answer(process: "subprocess.Popen[str]") -> str:
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    return output.strip()


def _entries(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.so"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache that this process uses as well."""
    path = tmp_path / "below" / "cache"
    monkeypatch.setenv("DYNIDENT_CACHE", str(path))
    monkeypatch.delenv("DYNIDENT_NO_COMPILER", raising=False)
    return path


def test_key_is_source_compiler_flags_and_processor(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def entries_after() -> int:
        cache.compiled_library(SOURCE)
        return len({path.name.split("-")[0] for path in _entries(folder)})

    assert entries_after() == 1
    assert entries_after() == 1
    cache.compiled_library(SOURCE.replace("1.0", "2.0"))
    assert entries_after() == 2
    monkeypatch.setattr(cache, "_FLAGS", (*cache._FLAGS, "-fno-math-errno"))
    assert entries_after() == 3
    monkeypatch.setattr(cache, "_processor", lambda: "another processor")
    assert entries_after() == 4
    wrapper = tmp_path / "mycc"
    wrapper.write_text('#!/bin/sh\nexec cc "$@"\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("CC", str(wrapper))
    assert entries_after() == 5
    wrapper.write_text('#!/bin/sh\n# upgraded\nexec cc "$@"\n')
    assert entries_after() == 6


@pytest.mark.long
def test_sixteen_processes_race_on_an_empty_cache(folder: Path, tmp_path: Path) -> None:
    processes = [_start(folder, str(tmp_path), str(k)) for k in range(16)]
    while len(list(tmp_path.glob("ready*"))) < 16:
        assert all(process.poll() is None for process in processes)
    (tmp_path / "go").touch()
    assert [_answer(process) for process in processes] == ["compiled"] * 16
    assert list(folder.iterdir()) == _entries(folder), "no half-written files stay"


def _flip_a_byte(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 0xFF]) + content[middle + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda content: b"", id="empty"),
        pytest.param(lambda content: content[:4096], id="first page only"),
        pytest.param(lambda content: content[: len(content) // 2], id="half"),
        pytest.param(lambda content: content[:-1], id="last byte lost"),
        pytest.param(lambda content: b"no library" * 1000, id="garbage"),
        pytest.param(_flip_a_byte, id="one byte changed"),
    ],
)
def test_damaged_entry_is_rebuilt(folder: Path, damage: Callable[[bytes], bytes]) -> None:
    cache.compiled_library(SOURCE, "kernel")
    (entry,) = _entries(folder)
    good = entry.read_bytes()
    entry.unlink()  # it is loaded
    entry.write_bytes(damage(good))
    assert Path(cache.compiled_library(SOURCE, "kernel")._name).parent == folder
    (entry,) = _entries(folder)
    assert entry.read_bytes() == good


def test_cache_that_others_can_write_is_not_used(folder: Path) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    used = cache.cache_folder()
    assert used != folder
    assert stat.S_IMODE(used.stat().st_mode) == 0o700


def test_without_compiler_numpy_answers(folder: Path) -> None:
    assert _answer(_start(folder, DYNIDENT_NO_COMPILER="1")) == "numpy"
    assert not folder.exists()


def test_compiler_that_fails_is_told_and_numpy_answers(folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "brokencc"
    broken.write_text("#!/bin/sh\necho out of order >&2\nexit 1\n")
    broken.chmod(0o755)
    process = _start(folder, CC=str(broken))
    output, errors = process.communicate(timeout=120)
    assert (process.returncode, output.strip()) == (0, "numpy")
    assert "out of order" in errors
    assert list(folder.iterdir()) == []


def _compiler(folder: Path, text: str) -> str:
    path = folder / "mycc"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


def test_compiler_that_hangs_is_asked_once(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It and what it started are ended; who asks again in this process need not wait."""
    calls = tmp_path / "asked"
    monkeypatch.setenv("CC", _compiler(tmp_path, f"echo once >> {calls}\nsleep 100"))
    monkeypatch.setattr(cache, "_PATIENCE", 0.3)
    begun = time.monotonic()
    for _ in range(3):
        with pytest.raises(cache.CompilerUnavailable, match=r"failed to finish within 0\.3 s"):
            cache.compiled_library(SOURCE)
    assert time.monotonic() - begun < 10.0
    assert calls.read_text() == "once\n"
    assert list(folder.iterdir()) == []
