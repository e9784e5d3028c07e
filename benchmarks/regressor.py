"""The RX90's base regressor (6 x 54) on 10,500 samples: this package, Pinocchio, CasADi's own C, and plain writing.

Run: python benchmarks/regressor.py

Everyone starts from q, qd, qdd and computes sines and cosines; all on one thread, in turn, in one run. Ratios of
medians are printed; a ratio is what can be compared between machines.
"""

import ctypes
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
from dynident.benchmarks.peers import pinocchio_model
from dynident.common.arrays import Array
from dynident.model import Robot, base_parameters, base_regressor, load_robot
from dynident.model.base.rank import random_states
from dynident.model.kernel.c_path import aligned_empty
from dynident.model.kernel.kernel import Kernel
from rich.console import Console
from rich.table import Table

SAMPLES = 10_500
ROUNDS = 5
WARM, REPEATS = 4, 12  # runs in a row of each: not counted, counted; everyone finds its own data in the cache
PINOCCHIO_SAMPLES = 1_000


def pinocchio_loop(robot: Robot, states: tuple[Array, ...]) -> Callable[[], None]:
    """A Python loop over Pinocchio's regressor of the joint torques, 6 x 60."""
    model = pinocchio_model(robot)
    data = model.createData()
    rows = [tuple(row) for row in zip(*(x[:PINOCCHIO_SAMPLES] for x in states), strict=True)]

    def run() -> None:
        for q, qd, qdd in rows:
            pin.computeJointTorqueRegressor(model, data, q, qd, qdd)

    return run


def casadi_c(function: ca.Function, states: tuple[Array, ...], folder: Path) -> Callable[[], None] | None:
    """CasADi's generated C, -O2, called sample by sample from C; None without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    here = Path.cwd()
    os.chdir(folder)
    function.generate("generated.c")
    os.chdir(here)
    n, entries = function.nnz_in(0), function.nnz_out(0)
    source = (
        (folder / "generated.c").read_text()
        + f"""
    void loop(const double *q, const double *qd, const double *qdd, double *out, long long samples) {{
      static double w[{function.sz_w() + 1}]; static casadi_int iw[{function.sz_iw() + 1}];
      for (long long i = 0; i < samples; ++i) {{
        const double *arg[{function.sz_arg() + 1}] = {{q + {n} * i, qd + {n} * i, qdd + {n} * i}};
        double *res[{function.sz_res() + 1}] = {{out + {entries} * i}};
        {function.name()}(arg, res, iw, w, 0);
      }}
    }}"""
    )
    (folder / "loop.c").write_text(source)
    library = folder / "loop.so"
    subprocess.run(
        [compiler, "-O2", "-fPIC", "-shared", "-w", str(folder / "loop.c"), "-o", str(library), "-lm"], check=True
    )
    loop = ctypes.CDLL(str(library)).loop
    pointer = ctypes.POINTER(ctypes.c_double)
    out = np.zeros((SAMPLES, entries))
    arguments = [x.ctypes.data_as(pointer) for x in (*states, out)]
    return lambda: loop(*arguments, ctypes.c_longlong(SAMPLES))


def main() -> None:
    """Print nanoseconds per sample and ratios."""
    robot = load_robot("rx90")
    function = base_regressor(robot, base_parameters(robot))
    states = tuple(np.ascontiguousarray(x) for x in random_states(robot, SAMPLES, seed=0))
    kernel = Kernel(function)
    os.environ["DYNIDENT_NO_COMPILER"] = "1"
    plain = Kernel(function)
    entries = function.nnz_out(0)
    rows = aligned_empty((entries, SAMPLES))
    tiles = aligned_empty((-(-SAMPLES // 8), entries, 8))
    with tempfile.TemporaryDirectory() as folder:
        runs: dict[str, Callable[[], object] | None] = {
            "Pinocchio, loop from Python": pinocchio_loop(robot, states),
            "CasADi's C, sample by sample": casadi_c(function, states, Path(folder)),
            "dynident, tiles of eight": (lambda: kernel.tiles(*states, out=tiles)) if kernel.compiled else None,
            "dynident, rows": (lambda: kernel(*states, out=rows)) if kernel.compiled else None,
            "dynident, NumPy": lambda: plain(*states, out=rows),
            "writing the entries once": lambda: rows.fill(1.0),
        }
        times = measured({name: run for name, run in runs.items() if run is not None})
    table = Table(
        title=f"{entries} non-zero entries, {SAMPLES} samples, ns per sample (median of {ROUNDS * REPEATS})",
        box=None,
    )
    for heading in ("", "ns", "Pinocchio / this", "CasADi / this", "this / writing"):
        table.add_column(heading, justify="left" if not heading else "right")
    casadi = times.get("CasADi's C, sample by sample", np.nan)
    for name, value in times.items():
        ratios = (
            times["Pinocchio, loop from Python"] / value,
            casadi / value,
            value / times["writing the entries once"],
        )
        table.add_row(name, f"{value:.0f}", *(f"{ratio:.2f}" for ratio in ratios))
    Console(width=110).print(table)


def measured(runs: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Median time of each per sample [ns], all taken in turn."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, run in runs.items():
            count = PINOCCHIO_SAMPLES if name.startswith("Pinocchio") else SAMPLES
            for _ in range(WARM):
                run()
            for _ in range(REPEATS):
                start = time.perf_counter()
                run()
                times[name].append((time.perf_counter() - start) / count * 1e9)
    return {name: float(np.median(values)) for name, values in times.items()}


if __name__ == "__main__":
    main()
