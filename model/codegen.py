"""Self-contained C of a robot's functions, for a controller: no allocation, no state, only <math.h>."""

import re
import textwrap
from collections.abc import Callable
from pathlib import Path

import casadi as ca

from ..common.errors import InputError
from ..common.files import made_folder, write_text
from . import dynamics
from .base.parameters import base_regressor
from .base.rank import base_parameters
from .drives import parameter_kind
from .kernel.c_path import c_body
from .regressors import payload_columns, payload_regressor, standard_columns, standard_regressor
from .robot import Robot

_FUNCTIONS: dict[str, Callable[..., ca.Function]] = {
    "inverse_dynamics": dynamics.inverse_dynamics,
    "inverse_dynamics_base": dynamics.inverse_dynamics_base,
    "mass_matrix": dynamics.mass_matrix,
    "coriolis": dynamics.coriolis,
    "gravity": dynamics.gravity,
    "forward_dynamics": dynamics.forward_dynamics,
    "standard_regressor": standard_regressor,
    "base_regressor": base_regressor,
    "payload_regressor": payload_regressor,
}
_OF_BASE = ("inverse_dynamics_base", "base_regressor")  # functions that are made for base parameters

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
    base = base_parameters(robot) if name in _OF_BASE else None
    function = _FUNCTIONS[name](robot, base) if base else _FUNCTIONS[name](robot)
    columns = payload_columns(robot) if name == "payload_regressor" else standard_columns(robot)
    columns = base.columns if base else columns
    where = "Columns of Phi" if function.name_out(0) == "Phi" else "Entries of chi"
    about = _comment(f"{where}: {', '.join(f'{k}={column}' for k, column in enumerate(columns))}")
    if name == "payload_regressor":
        # The frame is free text: nothing in it may end the comment.
        about += _comment("Frame of the payload: " + re.sub(r"[^ -~]|[*/\\?]", "_", robot.last_frame))
    if base:
        about += [" *", " * These are base parameters; R marks those that others are grouped in:"]
        groupings = zip(base.names, base.groupings(), strict=True)
        about += [line for column, text in groupings if column.endswith("R") for line in _comment(text)]
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
    folder = Path(folder)
    made_folder(folder)
    for file, text in texts.items():
        write_text(folder / file, text)
    return tuple(folder / file for file in texts)


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
        lines += _comment(f"{name}: in, {function.numel_in(k)} values, {_MEANING[name]}")
    (rows, columns), name = function.size_out(0), function.name_out(0)
    layout = f"{rows} x {columns}, row-major: {name}[{columns} * row + column]" if columns > 1 else f"{rows} values"
    lines += _comment(f"{name}: out, {layout}, {_MEANING[name]}")
    lines += [" *", f" * No allocation, no state. {name} must not overlap the inputs.", " *"]
    lines += [*about, " */", f"#ifndef {guard}", f"#define {guard}", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    lines += [f"{_declaration(function, symbol)};"]
    return "\n".join([*lines, "", "#ifdef __cplusplus", "}", "#endif", "", "#endif", ""])


def _comment(text: str) -> list[str]:
    return [f" * {line}" for line in _wrapped(text)]


def _wrapped(text: str) -> list[str]:
    """Break lines at spaces only: a number such as 1e-05 stays whole."""
    return textwrap.wrap(text, 98, subsequent_indent="    ", break_on_hyphens=False, break_long_words=False)


def _example(function: ca.Function, symbol: str, chi: list[float]) -> str:
    (rows, columns), output = function.size_out(0), function.name_out(0)
    lines = [f"/* Example of a call. Compile: cc -std=c99 {symbol}.c {symbol}_example.c -lm */"]
    lines += ["#include <stdio.h>", "", f'#include "{symbol}.h"', "", "int main(void)", "{"]
    for k in range(function.n_in()):
        name, size = function.name_in(k), function.numel_in(k)
        values = chi if name == "chi" else [0.1 * (k + 1)] * size
        text = f"const double {name}[{size}] = {{{', '.join(f'{value:.9g}' for value in values)}}};"
        lines += [f"  {line}" for line in _wrapped(text)]
    names = [function.name_in(k) for k in range(function.n_in())]
    lines += [f"  double {output}[{rows * columns}];", "", f"  {symbol}({', '.join([*names, output])});"]
    lines += [
        f"  for (int row = 0; row < {rows}; ++row)",
        f"    for (int column = 0; column < {columns}; ++column)",
    ]
    entry = f"{output}[{columns} * row + column]"
    end = f"""column + 1 < {columns} ? ' ' : '\\n'"""
    return "\n".join([*lines, f'      printf("%.17g%c", {entry}, {end});', "  return 0;", "}", ""])
