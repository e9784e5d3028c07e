"""Code of a robot's functions: self-contained C for a controller, or readable Python that needs NumPy alone."""

import inspect
import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..common.files import made_folder, write_text
from .base import base_parameters, base_regressor
from .drives import DriveState, drive_terms, parameter_kind
from .dynamics import coriolis, forward_dynamics, gravity, inverse_dynamics, inverse_dynamics_base, mass_matrix
from .frames import FrameChange, add, cross, dot
from .inertia import INERTIAL, cos_sin
from .kernel.kernel import BY_CODE, OPERATIONS, c_body
from .regressors import inertial_terms, link_wrenches, payload_columns, payload_regressor, standard_regressor
from .robot import Joint, Limits, Robot

_OF_BASE = inverse_dynamics_base, base_regressor  # functions that are made for base parameters
_OF_MOTION = inverse_dynamics, inverse_dynamics_base, mass_matrix, coriolis, gravity, forward_dynamics
_MAKERS = *_OF_MOTION, standard_regressor, base_regressor, payload_regressor
_FUNCTIONS: dict[str, Callable[..., ca.Function]] = {make.__name__: make for make in _MAKERS}
_MEANING = {
    "q": "joint positions [rad or m]",
    "qd": "joint speeds [rad/s or m/s]",
    "qdd": "joint accelerations [rad/s^2 or m/s^2]",
    "Gamma": "motor torques [N m or N]",
    "c": "Coriolis and centrifugal torques [N m or N]",
    "Q": "torques against gravity, without the spring [N m or N]",
    "A": "inertia matrix, rotors included",
    "chi": "parameters (SI units)",
    "load": "torques of links, payload and spring, which the gears carry [N m or N]",
    "Phi": "regressor: torque = Phi * parameters (SI units)",
}


def code_names() -> tuple[str, ...]:
    """Names of the functions ``generate_code`` can write."""
    return tuple(_FUNCTIONS)


def generate_code(robot: Robot, name: str, folder: str | Path) -> tuple[Path, ...]:
    """Write one function of a robot as C99: header, source and an example main.

    Args:
        name: one of ``code_names()``.
        folder: where the files go; made if it is not there.

    Returns:
        Paths of the header, the source and the example. Matrices are dense and row-major.

    Raises:
        InputError: if there is no function of that name.
        OSError: if a file cannot be written.
    """
    if name not in _FUNCTIONS:
        raise InputError(f"no function {name!r} to generate: give one of {', '.join(_FUNCTIONS)}")
    make = _FUNCTIONS[name]
    base = base_parameters(robot) if make in _OF_BASE else None
    function = make(robot, base) if base else make(robot)
    columns = payload_columns(robot) if name == "payload_regressor" else robot.standard
    columns = base.columns if base else columns
    where = "Columns of Phi" if function.name_out(0) == "Phi" else "Entries of chi"
    about = _wrapped(" * ", f"{where}: {', '.join(f'{k}={column}' for k, column in enumerate(columns))}")
    if name == "payload_regressor":
        # The frame is free text: nothing in it may end the comment.
        about += _wrapped(" * ", "Frame of the payload: " + re.sub(r"[^ -~]|[*/\\?]", "_", robot.last_frame))
    if base:
        about += [" *", " * These are base parameters; R marks those that others are grouped in:"]
        groupings = zip(base.names, base.groupings(), strict=True)
        about += [line for column, text in groupings if column.endswith("R") for line in _wrapped(" * ", text)]
    known = known_parameters(robot)
    chi = base.value(known).tolist() if base else [known[column] for column in columns]
    symbol = f"{symbol_of(robot)}_{name}"
    source = [f'#include "{symbol}.h"', "", "#include <math.h>", "", _declaration(function, symbol), "{"]
    source += [*(f"  {line}" for line in c_body(function)), "}", ""]
    texts = {
        f"{symbol}.h": _header(function, symbol, about),
        f"{symbol}.c": "\n".join(source),
        f"{symbol}_example.c": _example(function, symbol, chi),
    }
    for file, text in texts.items():
        write_text(made_folder(folder) / file, text)
    return tuple(Path(folder) / file for file in texts)


def symbol_of(robot: Robot) -> str:
    """Name of a robot as programs may have it."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", robot.name)
    return name if name[:1].isalpha() else f"robot_{name}"


def known_parameters(robot: Robot) -> dict[str, float]:
    """Parameters of the robot's description; a unit mass and inertia where it has none."""
    units = ("XX", "YY", "ZZ", "M", "IA")
    return {name: robot.parameters.get(name, float(parameter_kind(name) in units)) for name in robot.standard}


def _declaration(function: ca.Function, symbol: str) -> str:
    arrays = [f"const double {function.name_in(k)}[{function.numel_in(k)}]" for k in range(function.n_in())]
    arrays.append(f"double {function.name_out(0)}[{function.numel_out(0)}]")
    return f"void {symbol}(\n    " + ",\n    ".join(arrays) + ")"


def _header(function: ca.Function, symbol: str, about: list[str]) -> str:
    guard = f"{symbol.upper()}_H"
    lines = [f"/* {symbol}: generated by dynident from the robot's description.", " *"]
    for k in range(function.n_in()):
        name = function.name_in(k)
        lines += _wrapped(" * ", f"{name}: in, {function.numel_in(k)} values, {_MEANING[name]}")
    (rows, columns), name = function.size_out(0), function.name_out(0)
    layout = f"{rows} x {columns}, row-major: {name}[{columns} * row + column]" if columns > 1 else f"{rows} values"
    lines += _wrapped(" * ", f"{name}: out, {layout}, {_MEANING[name]}")
    lines += [" *", f" * No allocation, no state. {name} must not overlap the inputs.", " *"]
    lines += [*about, " */", f"#ifndef {guard}", f"#define {guard}", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    lines += [f"{_declaration(function, symbol)};"]
    return "\n".join([*lines, "", "#ifdef __cplusplus", "}", "#endif", "", "#endif", ""])


def _wrapped(before: str, text: str) -> list[str]:
    """Break lines at spaces only, a number such as 1e-05 stays whole; each begins with ``before``."""
    lines = textwrap.wrap(text, 98, subsequent_indent="    ", break_on_hyphens=False, break_long_words=False)
    return [f"{before}{line}" for line in lines]


def _example(function: ca.Function, symbol: str, chi: list[float]) -> str:
    (rows, columns), output = function.size_out(0), function.name_out(0)
    lines = [f"/* Example of a call. Compile: cc -std=c99 {symbol}.c {symbol}_example.c -lm */"]
    lines += ["#include <stdio.h>", "", f'#include "{symbol}.h"', "", "int main(void)", "{"]
    for k in range(function.n_in()):
        name, size = function.name_in(k), function.numel_in(k)
        values = chi if name == "chi" else [0.1 * (k + 1)] * size
        text = f"const double {name}[{size}] = {{{', '.join(f'{value:.9g}' for value in values)}}};"
        lines += _wrapped("  ", text)
    names = [function.name_in(k) for k in range(function.n_in())]
    lines += [f"  double {output}[{rows * columns}];", "", f"  {symbol}({', '.join([*names, output])});"]
    lines += [
        f"  for (int row = 0; row < {rows}; ++row)",
        f"    for (int column = 0; column < {columns}; ++column)",
    ]
    entry = f"{output}[{columns} * row + column]"
    end = f"""column + 1 < {columns} ? ' ' : '\\n'"""
    return "\n".join([*lines, f'      printf("%.17g%c", {entry}, {end});', "  return 0;", "}", ""])


class Arm(NamedTuple):
    """A robot. States and torques are arrays of n numbers, or n x N for N states at once; SI units.

    ``gravity``: acceleration in frame 0; ``standard``: parameters by name; ``base``: what is grouped in each base
    parameter; ``drives``: gives the entries of the drives' parameters, ``spring`` its torque, by joint from 0.
    """

    joints: tuple[Joint, ...]
    gravity: tuple[float, float, float]
    standard: dict[str, float]
    base: dict[str, dict[str, float]]
    drives: Callable[[Array, Array, Array, Array], dict[str, dict[int, Any]]]
    spring: Callable[[Array], dict[int, Any]]

    def regressor(self, q: Array, qd: Array, qdd: Array, load: Array | None = None) -> Array:
        """Columns of all standard parameters, n x N_s (x N); ``load``: torques that the gears carry."""
        load = np.zeros_like(q) if load is None else load
        robot: Any = self
        terms = inertial_terms(robot, DriveState(q, qd, qdd, load), np) | self.drives(q, qd, qdd, load)
        phi = np.zeros((len(self.joints), len(self.standard), *q.shape[1:]))
        for k, name in enumerate(self.standard):
            for row, value in terms[name].items():
                phi[row, k] = value
        return phi

    def base_regressor(self, q: Array, qd: Array, qdd: Array, load: Array | None = None) -> Array:
        """Columns of the base parameters, n x N_b (x N)."""
        return self.regressor(q, qd, qdd, load)[:, [list(self.standard).index(name) for name in self.base]]

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array, chi: Array | None = None) -> Array:
        """Torques that a motion needs; ``chi``: other standard parameters than the arm's own."""
        chi = np.array([*self.standard.values()]) if chi is None else chi
        links = np.array([name.rstrip("0123456789") in INERTIAL for name in self.standard])
        load = np.einsum("jk...,k->j...", self.regressor(q, qd, qdd), chi * links)
        for row, torque in self.spring(q).items():
            load[row] -= torque
        rubbing = np.einsum("jk...,k->j...", self.regressor(q, qd, qdd, load), chi * ~links)
        return np.asarray(load + rubbing)

    def mass_matrix(self, q: Array, chi: Array | None = None) -> Array:
        """Inertia matrix, n x n, rotors included."""
        rest, units = np.zeros_like(q), np.eye(len(q))
        still = self.inverse_dynamics(q, rest, rest, chi)
        return np.column_stack([self.inverse_dynamics(q, rest, unit, chi) - still for unit in units])


_FILE = '''"""{title}: regressor and dynamics in NumPy alone. Generated by dynident.

Torques are ``arm.regressor(q, qd, qdd) @ [*arm.standard.values()]`` [N m or N]. Base parameters:

{groupings}
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Literal, NamedTuple

import numpy as np

Array, Vector, Robot = np.ndarray, tuple, Any
_EXACT, ZERO = 1e-12, (0.0, 0.0, 0.0)
INERTIAL = {inertial}


{code}

def drives(q: Array, qd: Array, qdd: Array, load: Array) -> dict[str, dict[int, Any]]:
    """Entries of the drives' parameters, by joint from 0."""
    return {{
{drives}
    }}


def spring(q: Array) -> dict[int, Any]:
    """Torque of a spring that is known, by joint from 0; of a table within its range."""
    return {spring}


arm = Arm(
    joints=(
{joints}
    ),
    gravity={gravity},
    standard={{
{standard}
    }},
    base={{
{base}
    }},
    drives=drives,
    spring=spring,
)
'''
_CODE: Any = cos_sin, add, dot, cross, FrameChange, DriveState, link_wrenches, inertial_terms, Limits, Joint, Arm
"""Functions and types that the file takes over as they stand here."""


def generate_numpy(robot: Robot, folder: str | Path) -> Path:
    """Write regressor and dynamics of a robot as one file of Python that needs NumPy alone.

    Args:
        folder: where the file goes; made if it is not there.

    Returns:
        The file's path. It holds ``arm``, with ``regressor``, ``inverse_dynamics`` and others.

    Raises:
        InputError: if the robot has a law of friction of one's own.
        OSError: if the file cannot be written.
    """
    if any(term.code for term in robot.drives.friction):
        raise InputError(f"robot {robot.name!r} has a law of friction of its own: only C can be generated of it")
    base, known, spring = base_parameters(robot), known_parameters(robot), dict[int, str]()
    vectors = ((ca.SX.sym(f"{name}[{j}]") for j in range(robot.n)) for name in DriveState._fields)
    state = DriveState(*(ca.vertcat(*symbols) for symbols in vectors))
    if robot.spring is not None:
        j, table = robot.spring.joint - 1, ", ".join(map(str, zip(*robot.spring.table, strict=True)))
        spring[j] = f"np.interp(q[{j}], {table})" if table else _written(robot.spring.law(state.q[j], ca))
    grouped = [{base.standard[k]: float(row[k]) for k in np.flatnonzero(row)} for row in base.grouping]

    def entries(table: Any) -> str:
        return "\n".join(f"        {name!r}: {value}," for name, value in table)

    terms: dict[str, str] = {}
    for name, rows in drive_terms(robot.drives, state).items():
        terms[name] = str({row: _written(x) for row, x in rows.items()}).replace("'", "")
    text = _FILE.format(
        title=re.sub(r'[^ -~]|[\\"]', "_", robot.title or robot.name),
        groupings="\n".join(f"    {line}" for line in base.groupings()),
        inertial=INERTIAL,
        code=re.sub(r"\bca\b", "np", "\n\n".join(map(inspect.getsource, _CODE))),
        drives=entries(terms.items()),
        spring=str(spring).replace("'", ""),
        joints="\n".join(f"        {joint}," for joint in robot.joints),
        gravity=robot.gravity,
        standard=entries(known.items()),
        base=entries(zip(base.columns, grouped, strict=True)),
    )
    path = made_folder(folder) / f"{symbol_of(robot)}.py"
    write_text(path, text)
    return path


def _written(x: ca.SX | float) -> str:
    """Write an expression as Python of NumPy's functions, its symbols by their names."""
    if not isinstance(x, ca.SX) or x.is_constant():
        return repr(float(x))
    if x.is_symbolic():
        return str(x.name())
    operands = (_written(x.dep(k)) for k in range(x.n_dep()))
    form = re.sub(r"v(?:(?:each|pair)\((\w+), |(\w+)\()", r"np.\1\2(", OPERATIONS[BY_CODE[x.op()]])
    return form.format(*(f"({text})" if " " in text else text for text in operands)).replace("np.pow(", "np.power(")
