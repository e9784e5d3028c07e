"""Generated C compiles without a warning, computes what CasADi computes, and has the operations that are told."""

import ctypes
import re
import runpy
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model.codegen import code_names
from dynident.tests.conftest import CROOKED, IN_FULL, PRISMATIC
from dynident.tests.selection import every

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1")
SLIDING = replace(CROOKED, name='odd "name" */ 6-axis')
TABLE = replace(
    SLIDING,
    drives=model.Drives(spring=model.Spring(2, table=((-3.0, 30.0), (-0.5, 5.0), (1.0, -8.0), (3.0, -60.0)))),
)
SLIDER = model.Robot("slider", (model.Joint("prismatic"),), drives=model.Drives(friction=()))
ROBOTS = {name: model.load_robot(name) for name in IN_FULL} | {"sliding": SLIDING, "table": TABLE, "slider": SLIDER}
"""Shipped arms but for those that differ by lengths and axes alone, and what else drives can have."""

FUNCTIONS: dict[str, Callable[[model.Robot], ca.Function]] = {
    "inverse_dynamics": model.inverse_dynamics,
    "inverse_dynamics_base": lambda robot: model.inverse_dynamics_base(robot, model.base_parameters(robot)),
    "mass_matrix": model.mass_matrix,
    "coriolis": model.coriolis,
    "gravity": model.gravity,
    "forward_dynamics": model.forward_dynamics,
    "standard_regressor": model.standard_regressor,
    "base_regressor": lambda robot: model.base_regressor(robot, model.base_parameters(robot)),
    "payload_regressor": model.payload_regressor,
}

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


def compile_c(sources: list[Path], output: Path, *flags: str) -> None:
    command = ["cc", *STRICT, *flags, *map(str, sources), "-o", str(output), "-lm"]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr


def call(library: Path, symbol: str, inputs: list[Array], shape: tuple[int, int]) -> Array:
    """Call the compiled function; the output is filled with nan first, so that a gap shows."""
    function = getattr(ctypes.CDLL(str(library)), symbol)
    function.restype = None
    arrays = [*inputs, np.full(shape, np.nan)]
    function(*(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in arrays))
    return arrays[-1]


def assert_same(result: Array, expected: ca.DM) -> None:
    scale = np.abs(expected.full()).max()
    np.testing.assert_allclose(result, expected.full(), rtol=1e-12, atol=1e-12 * scale)


@needs_compiler
@pytest.mark.parametrize("case", every(4, [*product(ROBOTS, FUNCTIONS)][::2]), ids="-".join)
def test_compiled_code_answers_as_casadi(case: tuple[str, str], tmp_path: Path) -> None:
    robot, name = ROBOTS[case[0]], case[1]
    _, source, _ = model.generate_code(robot, name, tmp_path)
    compile_c([source], tmp_path / "lib.so", "-shared", "-fPIC")
    function, draw = FUNCTIONS[name](robot), np.random.default_rng(3)
    for _ in range(5):
        inputs = [draw.uniform(-2.0, 2.0, function.numel_in(k)) for k in range(function.n_in())]
        result = call(tmp_path / "lib.so", source.stem, inputs, function.size_out(0))
        assert_same(result, function(*inputs))


@needs_compiler
@pytest.mark.parametrize("name", ["inverse_dynamics", "mass_matrix", "base_regressor"])
def test_example_compiles_and_prints_the_result(name: str, tmp_path: Path) -> None:
    robot = ROBOTS["rx90"]
    _, source, example = model.generate_code(robot, name, tmp_path)
    compile_c([source, example], tmp_path / "example")
    printed = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=True).stdout
    function, text = FUNCTIONS[name](robot), example.read_text(encoding="utf-8")
    arrays = dict(re.findall(r"const double (\w+)\[\d+\] = \{([^}]*)\}", text))
    inputs = [[float(part) for part in arrays[function.name_in(k)].split(",")] for k in range(function.n_in())]
    result = np.array([line.split() for line in printed.splitlines()], dtype=float)
    assert_same(result, function(*inputs))
    assert np.abs(result).max() > 1e-3


@pytest.mark.parametrize("robot", [ROBOTS["rx90"], SLIDING], ids=["rx90", "sliding"])
@pytest.mark.parametrize("name", ["inverse_dynamics", "base_regressor"])
def test_header_names_shapes_and_parameters(robot: model.Robot, name: str, tmp_path: Path) -> None:
    header = model.generate_code(robot, name, tmp_path)[0].read_text(encoding="utf-8")
    names = model.base_parameters(robot).columns if name == "base_regressor" else model.standard_columns(robot)
    pairs = re.findall(r"(\d+)=(\w+)", header)
    assert pairs == [(str(k), parameter) for k, parameter in enumerate(names)]
    assert header.count("*/") == 1
    function = FUNCTIONS[name](robot)
    for k in range(function.n_in()):
        assert f"const double {function.name_in(k)}[{function.numel_in(k)}]" in header
    if name == "base_regressor":
        assert f"Phi: out, {robot.n} x {len(names)}, row-major: Phi[{len(names)} * row + column]" in header


def test_code_needs_nothing_but_the_mathematics_library(tmp_path: Path) -> None:
    header, source, _ = model.generate_code(ROBOTS["tx40"], "forward_dynamics", tmp_path)
    text = source.read_text(encoding="utf-8") + header.read_text(encoding="utf-8")
    assert re.findall(r"#include (\S+)", text) == [f'"{header.name}"', "<math.h>"]
    assert not re.search(r"\b(malloc|calloc|static|goto)\b", text)
    assert header.stem.isidentifier()


def test_every_name_is_tested() -> None:
    assert code_names() == tuple(FUNCTIONS)


ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "benchmarks" / "regressor.py"))


def test_page_shows_the_computed_tables() -> None:
    page = (ROOT / "docs" / "operation_counts.md").read_text(encoding="utf-8")
    first, second = SCRIPT["tables"]()
    assert first in page
    assert second in page


RUBBING = replace(
    ROBOTS["rx90"].with_friction(model.friction_terms(["FS", "FV", "FL", "FR", "FB@0.1", "FA"])), title="R"
)
ALL = [*map(model.load_robot, model.robot_names()), *PRISMATIC.values(), SLIDING, TABLE, SLIDER, RUBBING]


@pytest.mark.parametrize("described", ALL, ids=lambda robot: robot.name)
def test_a_file_of_numpy_computes_the_same(described: model.Robot, tmp_path: Path) -> None:
    robot = described
    path = model.generate_numpy(robot, tmp_path)
    imported = set(re.findall(r"^(?:import|from) (\S+)", path.read_text(), re.MULTILINE))
    assert imported == {"__future__", "math", "collections.abc", "dataclasses", "typing", "numpy"}
    arm, base = runpy.run_path(str(path))["arm"], model.base_parameters(robot)
    draw, N = np.random.default_rng(1), 5
    q, qd, qdd, load = draw.uniform(-2.0, 2.0, (4, robot.n, N))
    chi = draw.uniform(0.1, 1.0, len(robot.standard))
    regressors = {
        arm.regressor: model.standard_regressor(robot),
        arm.base_regressor: model.base_regressor(robot, base),
    }
    for ours, theirs in regressors.items():
        states = (q, qd, qdd, load)[: theirs.n_in()]
        phi = ours(q, qd, qdd, load)
        for k in range(N):
            assert_same(phi[:, :, k], theirs(*(x[:, k] for x in states)))
    assert_same(
        arm.inverse_dynamics(q, qd, qdd, chi),
        model.inverse_dynamics(robot).map(N)(q, qd, qdd, np.tile(chi, (N, 1)).T),
    )
    assert_same(arm.mass_matrix(q[:, 0], chi), model.mass_matrix(robot)(q[:, 0], chi))
    grouping = [[parts.get(name, 0.0) for name in arm.standard] for parts in arm.base.values()]
    assert np.array_equal(grouping, base.grouping)
    known = {name: robot.parameters[name] for name in robot.standard if name in robot.parameters}
    assert {name: arm.standard[name] for name in known} == known


def test_numpy_knows_no_law_of_ones_own(tmp_path: Path) -> None:
    x = [ca.SX.sym(name) for name in "vpl"]
    own = model.Friction.of("FD", "N·m", ca.Function("law", x, [x[0] ** 3]))
    with pytest.raises(InputError, match="law of friction of its own: only C"):
        model.generate_numpy(ROBOTS["rx90"].with_friction((*model.PAPER, own)), tmp_path)
