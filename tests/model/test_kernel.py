"""The kernel against CasADi's own virtual machine, step after step, and whatever happens to its cache."""

import math
import os
import shutil
import stat
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model.dynamics import runge_kutta
from dynident.model.kernel import cache
from dynident.model.kernel.kernel import OPERATIONS, Kernel, read_program

TWO_ARGUMENTS = {
    *("ADD", "SUB", "MUL", "DIV", "ATAN2", "FMIN", "FMAX", "POW", "CONSTPOW"),
    *("LT", "LE", "EQ", "NE", "AND", "OR", "IF_ELSE_ZERO"),
}
SPECIAL = (0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -3.0, 1e-310, 1e300, math.inf, -math.inf, math.nan)
VALUES = np.concatenate([SPECIAL, np.random.default_rng(0).uniform(-3.0, 3.0, 60)])


def expression(name: str, x: ca.SX, y: ca.SX) -> ca.SX:
    if name == "CONSTPOW":
        return x**2.5
    code = getattr(ca, f"OP_{name}")
    return ca.SX.binary(code, x, y) if name in TWO_ARGUMENTS else ca.SX.unary(code, x)


def test_every_operation(compiled: bool) -> None:
    """On ordinary and on special numbers, in every pairing."""
    names, x, y = sorted(OPERATIONS.keys() - {"ASSIGN"}), ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("f", [x, y], [ca.densify(ca.vertcat(*(expression(name, x, y) for name in names)))])
    # Early versions of CasADi write 2 x as a product.
    assert {*names} - {"TWICE"} <= {name for name, *_ in read_program(function).steps}
    pairs = np.array(np.meshgrid(VALUES, VALUES)).reshape(2, -1).T
    columns = [pairs[:, [k]] for k in (0, 1)]
    kernel = Kernel(function)
    assert kernel.compiled == compiled
    rows, expected = kernel(*columns), np.array([function(*pair).full()[:, 0] for pair in pairs]).T
    for name, row, exact in zip(names, rows, expected, strict=True):
        # 4 units in the last place: libraries may round differently.
        np.testing.assert_allclose(row, exact, rtol=1e-15, atol=4e-16, err_msg=name)


@pytest.fixture
def mixed() -> ca.Function:
    """Two inputs, two outputs, constants, a shared subexpression, an input that is an output."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    shared = ca.sin(x[0]) * ca.cos(x[1]) + p[0]
    matrix = ca.SX(2, 3)
    matrix[0, 0], matrix[1, 0], matrix[1, 2] = shared, x[2], 7.25
    return ca.Function("mixed", [x, p], [matrix, shared * shared - ca.sqrt(ca.fabs(x[2] * p[1])) / 3.0])


@pytest.mark.parametrize("size", [0, 1, 7, 8, 9, 4095, 4096, 4097])
def test_every_size(mixed: ca.Function, compiled: bool, size: int) -> None:
    draw = np.random.default_rng(size)
    x, p = draw.normal(size=(size, 3)), draw.normal(size=(size, 2))
    kernel = Kernel(mixed)
    result = kernel(x, p)
    assert result.shape == (4, size)
    assert list(zip(kernel.rows, kernel.columns, strict=True)) == [(0, 0), (1, 0), (1, 2)]
    shared = np.sin(x[:, 0]) * np.cos(x[:, 1]) + p[:, 0]
    last = shared * shared - np.sqrt(np.abs(x[:, 2] * p[:, 1])) / 3.0
    expected = np.array([shared, x[:, 2], np.full(size, 7.25), last])
    np.testing.assert_allclose(result, expected, rtol=1e-14, atol=1e-15)
    assert compiled == kernel.compiled


@pytest.mark.parametrize(
    "shapes",
    [[], [(5, 3)], [(5, 3), (5, 3)], [(5, 2), (5, 3)], [(5, 5)], [(5, 3), (5, 2), (5, 1)], [(5, 3), (4, 2)],
     [(5, 3), (1, 2)], [(3,), (3,)], [(2, 5, 3), (2,)]],
    ids=str,
)  # fmt: skip
def test_wrong_sizes_are_refused(mixed: ca.Function, compiled: bool, shapes: list[tuple[int, ...]]) -> None:
    with pytest.raises(ValueError, match="inputs"):
        Kernel(mixed)(*(np.zeros(shape) for shape in shapes))


def test_other_functions_are_refused() -> None:
    x = ca.MX.sym("x", 2)
    with pytest.raises(TypeError, match="other is not an SX function: expand"):
        Kernel(ca.Function("other", [x], [x + 1.0]))


def test_unknown_operation_is_named() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(TypeError, match=f"gauss uses CasADi operation {ca.OP_ERF}"):
        Kernel(ca.Function("gauss", [x], [ca.erf(x)]))


@pytest.mark.parametrize(("function", "exact"), [(ca.sin, math.sin), (ca.cos, math.cos)], ids=["sin", "cos"])
def test_sine_and_cosine(
    function: Callable[[ca.SX], ca.SX], exact: Callable[[float], float], compiled: bool
) -> None:
    """Within 2.5e-16 up to 1e5 rad and beyond; near multiples of pi/2 also relative to the small result."""
    draw = np.random.default_rng(3)
    near = np.arange(-60000, 60001, 997) * (np.pi / 2)
    angles = np.concatenate(
        [draw.uniform(-size, size, 5000) for size in (1e-8, 1.0, 10.0, 1e3, 1e5, 1e9, 1e12, 1e15, 1e300)]
        + [near, [0.0, 1e5, np.nextafter(1e5, 2e5), -1e5, 5e-324, 1.7e308]]
    )
    angles.sort()  # eight of a kind: one large angle sends its seven neighbours to the C library too
    symbol = ca.SX.sym("x")
    result = Kernel(ca.Function("f", [symbol], [function(symbol)]))(angles[:, None])[0]
    expected = np.array([exact(angle) for angle in angles])
    assert np.abs(result - expected).max() <= 2.5e-16
    np.testing.assert_allclose(result, expected, rtol=5e-16, atol=1e-22)


STEPS, RUNS = 7, 11


@pytest.fixture
def step() -> ca.Function:
    """A pendulum with its own length, driven, and what it was driven by."""
    x, drive, length, h = ca.SX.sym("x", 2), ca.SX.sym("u", 1), ca.SX.sym("l"), ca.SX.sym("h")
    none = ca.SX(0, 1)
    after = runge_kutta(
        lambda x, _: ca.vertcat(x[1], drive - 9.81 / length * ca.sin(x[0])), x, h, (none, none, none)
    )
    return ca.Function("pendulum", [x, drive, length, h], [ca.vertcat(after, 2.0 * drive)])


def inputs() -> list[Array]:
    draw = np.random.default_rng(0)
    state, drive = draw.normal(size=(RUNS, 2)), draw.normal(size=(2 * STEPS, RUNS, 1))[::2]
    return [state, drive, draw.uniform(0.5, 2.0, size=(RUNS, 1)), np.array([0.01])]


def alone(step: ca.Function) -> Array:
    """Run after run, step after step."""
    state, drive, length, h = inputs()
    out = np.empty((STEPS, 3, RUNS))
    for k in range(RUNS):
        x = state[k]
        for i in range(STEPS):
            out[i, :, k] = np.array(step(x, drive[i, k], length[k], h)).ravel()
            x = out[i, :2, k]
    return out


def test_it_is_what_single_calls_give(step: ca.Function, compiled: bool) -> None:
    arguments = inputs()
    state = arguments[0].copy()
    np.testing.assert_allclose(Kernel(step).chain(*arguments), alone(step), rtol=1e-13, atol=1e-13)
    turned = Kernel(step).chain(np.asfortranarray(state), *arguments[1:])
    np.testing.assert_array_equal(turned, Kernel(step).chain(*arguments), "whatever its layout")
    np.testing.assert_array_equal(arguments[0], state, "the caller's state stays")


def test_the_last_step_is_the_next_ones_start(step: ca.Function, compiled: bool) -> None:
    state, drive, *shared = inputs()
    stepper = Kernel(step).chain
    whole = stepper(state, drive, *shared)
    first = stepper(state, drive[:3], *shared)
    second = stepper(np.ascontiguousarray(first[-1, :2].T), drive[3:], *shared)
    np.testing.assert_array_equal(np.concatenate([first, second]), whole)


SOURCE = "double kernel(double x) { return x + 1.0; }"

SCRIPT = """
import casadi as ca, numpy as np
from dynident.model.kernel.kernel import Kernel
x = ca.SX.sym("x", 2)
kernel = Kernel(ca.Function("f", [x], [ca.sin(x[0]) * x[1] + 3]))
values = np.random.default_rng(0).normal(size=(101, 2))
assert np.allclose(kernel(values)[0], np.sin(values[:, 0]) * values[:, 1] + 3, rtol=1e-14, atol=1e-14)
tiny = np.array([1e-310])
assert tiny[0] / 2 == 5e-311 and (tiny / 2)[0] == 5e-311 and float("1e-310") * 0.5 > 0.0
print("compiled" if kernel.compiled else "numpy")
"""


def _alone(folder: Path, **variables: str) -> tuple[str, str]:
    """What the script prints in a process of its own, and its errors."""
    environment = {**os.environ, "DYNIDENT_CACHE": str(folder), **variables}
    command = [sys.executable, "-c", SCRIPT]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.strip(), ended.stderr


def _entries(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.so"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache that this process uses as well."""
    if not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("needs a C compiler")
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
    monkeypatch.setenv("CC", _compiler(tmp_path, 'exec cc "$@"'))
    assert entries_after() == 5
    _compiler(tmp_path, '# upgraded\nexec cc "$@"')
    assert entries_after() == 6


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda content: b"", id="empty"),
        pytest.param(lambda content: content[:4096], id="first page only"),
        pytest.param(lambda content: content[: len(content) // 2], id="half"),
        pytest.param(lambda content: content[:-1], id="last byte lost"),
        pytest.param(lambda content: b"no library" * 1000, id="garbage"),
        pytest.param(lambda c: c[: (k := len(c) // 2)] + bytes([c[k] ^ 0xFF]) + c[k + 1 :], id="one byte changed"),
    ],
)
def test_damaged_entry_is_rebuilt(folder: Path, damage: Callable[[bytes], bytes]) -> None:
    cache.compiled_library(SOURCE)
    (entry,) = _entries(folder)
    good = entry.read_bytes()
    entry.unlink()  # it is loaded
    entry.write_bytes(damage(good))
    assert Path(cache.compiled_library(SOURCE)._name).parent == folder
    (entry,) = _entries(folder)
    assert entry.read_bytes() == good


def test_cache_that_others_can_write_is_not_used(folder: Path) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    used = cache.cache_folder()
    assert used != folder
    assert stat.S_IMODE(used.stat().st_mode) == 0o700


def test_a_process_of_its_own_answers_with_a_compiler_and_without(folder: Path, tmp_path: Path) -> None:
    """And is left alone by compiled code: loading it must not switch to flush-to-zero."""
    assert _alone(folder, DYNIDENT_NO_COMPILER="1") == ("numpy", "")
    assert not folder.exists()
    answer, errors = _alone(folder, CC=_compiler(tmp_path, "echo out of order >&2\nexit 1"))
    assert answer == "numpy"
    assert "out of order" in errors
    assert list(folder.iterdir()) == []
    assert _alone(folder)[0] == "compiled"


def _compiler(folder: Path, text: str) -> str:
    path = folder / "mycc"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize(("hangs", "asked"), [("sleep 100", 1), ("grep -q answer || sleep 100", 2)])
def test_compiler_that_hangs_is_asked_once(
    hangs: str, asked: int, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At anything or at real code: it and what it started are ended; who asks again here need not wait."""
    calls = tmp_path / "asked"
    monkeypatch.setenv("CC", _compiler(tmp_path, f"echo once >> {calls}\n{hangs}"))
    monkeypatch.setattr(cache, "_PATIENCE", 0.3)
    begun = time.monotonic()
    for _ in range(3):
        with pytest.raises(cache.CompilerUnavailable, match=r"failed to finish within 0\.3 s"):
            cache.compiled_library(SOURCE)
    assert time.monotonic() - begun < 10.0
    assert calls.read_text() == asked * "once\n"
    assert list(folder.iterdir()) == []
