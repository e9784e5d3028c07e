"""The RX90's base regressor (6 x 54) on 10,500 samples, and how many operations the generated functions need.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/regressor.py [time] [counts]

time: this package, Pinocchio, and plain writing. Everyone starts from q, qd, qdd and computes sines
and cosines; all on one thread, in turn, in one run. Ratios of medians: a ratio can be compared between machines.
counts: the tables of docs/operation_counts.md, beside SYMORO+'s counts.
"""

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import casadi as ca
import numpy as np
import pinocchio as pin
from dynident import model
from dynident.benchmarks.shared import options, show
from dynident.common.arrays import Array
from dynident.model.base import random_states
from dynident.model.kernel.kernel import Kernel, read_program

SAMPLES, ROUNDS = 10_500, 5
WARM, REPEATS = 4, 12  # runs in a row of each: not counted, counted; everyone finds its own data in the cache
PINOCCHIO_SAMPLES = 1_000
SYMORO = {"inverse dynamics, base parameters": (325, 272), "base identification model": (877, 501)}
"""Multiplications and additions that SYMORO+ needs for the RX90."""
KINDS = {"MUL": "x", "SQ": "x", "DIV": "x", "INV": "x", "ADD": "+", "SUB": "+", "TWICE": "+", "NEG": "-"}
PINOCCHIO, WRITING = "Pinocchio, loop from Python", "writing the entries once"


def pinocchio_loop(robot: model.Robot, states: Iterable[Array]) -> Callable[[], None]:
    """A Python loop over Pinocchio's regressor of the joint torques, 6 x 60; bodies are random."""
    arm, parent = pin.Model(), 0
    for number, joint in enumerate(robot.joints, start=1):  # revolute, in modified DH
        before = pin.SE3(pin.utils.rotate("x", joint.alpha), np.array([joint.d, 0.0, 0.0]))
        after = pin.SE3(np.eye(3), np.array([0.0, 0.0, joint.r]))
        parent = arm.addJoint(parent, pin.JointModelRZ(), before * after, f"joint{number}")
        arm.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
    data, rows = arm.createData(), list(zip(*states, strict=True))

    def run() -> None:
        for q, qd, qdd in rows:
            pin.computeJointTorqueRegressor(arm, data, q, qd, qdd)

    return run


def times() -> None:
    """Print nanoseconds per sample and ratios."""
    robot = model.load_robot("rx90")
    function = model.base_regressor(robot, model.base_parameters(robot))
    states = tuple(np.ascontiguousarray(x) for x in random_states(robot, SAMPLES, seed=0))
    kernel = Kernel(function)
    os.environ["DYNIDENT_NO_COMPILER"] = "1"
    plain = Kernel(function)
    entries = function.nnz_out(0)
    rows = np.empty((entries, SAMPLES))
    runs: dict[str, Callable[[], object]] = {
        PINOCCHIO: pinocchio_loop(robot, tuple(x[:PINOCCHIO_SAMPLES] for x in states)),
        **({"dynident, compiled": lambda: kernel(*states)} if kernel.compiled else {}),
        "dynident, NumPy": lambda: plain(*states),
        WRITING: lambda: rows.fill(1.0),
    }
    taken: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, run in runs.items():
            moments = [time.perf_counter()]
            for _repeat in range(WARM + REPEATS):
                run()
                moments.append(time.perf_counter())
            taken[name] += np.diff(moments)[WARM:].tolist()
    counts = {name: PINOCCHIO_SAMPLES if name == PINOCCHIO else SAMPLES for name in runs}
    ns = {name: 1e9 * float(np.median(values)) / counts[name] for name, values in taken.items()}
    lines = []
    for name, value in ns.items():
        numbers = (value, ns[PINOCCHIO] / value, value / ns[WRITING])
        lines.append([name, *(f"{number:.2f}" for number in numbers)])
    title = f"{entries} non-zero entries, {SAMPLES} samples, ns per sample (median of {ROUNDS * REPEATS})"
    show(title, lines, "Pinocchio / this", "this / writing", asked=False)


def operation_counts(function: ca.Function) -> tuple[int, int, int, int]:
    """Multiplications (and divisions), additions (and subtractions), changes of sign, other operations."""
    counts = Counter(KINDS.get(name, "other") for name, *_ in read_program(function).steps)
    return counts["x"], counts["+"], counts["-"], counts["other"]


def rigid_bodies() -> Iterator[str]:
    """Rows of the comparison with SYMORO+: RX90, 36 base parameters of the links, no drives."""
    robot = replace(model.load_robot("rx90"), drives=model.Drives(rotor_inertia=False, friction=()))
    base = model.base_parameters(robot)
    functions = (model.inverse_dynamics_base(robot, base), model.base_regressor(robot, base))
    for (name, (multiplications, additions)), function in zip(SYMORO.items(), functions, strict=True):
        yield f"| {name} | {_cells(function)} | {multiplications} | {additions} |"


def whole_model() -> Iterator[str]:
    """Rows of all functions: RX90 with rotor inertia, friction and coupling."""
    robot = model.load_robot("rx90")
    base = model.base_parameters(robot)
    makers = (model.inverse_dynamics, model.mass_matrix, model.coriolis, model.gravity, model.forward_dynamics)
    functions = [make(robot) for make in (*makers, model.standard_regressor, model.payload_regressor)]
    for function in (*functions, model.inverse_dynamics_base(robot, base), model.base_regressor(robot, base)):
        yield f"| `{function.name()}` | {_cells(function)} |"


def _cells(function: ca.Function) -> str:
    return " | ".join(str(count) for count in operation_counts(function))


def tables() -> tuple[str, str]:
    """The two tables as they stand in docs/operation_counts.md."""
    head = "multiplications | additions | sign changes | sin, cos, sign |"
    first = [f"| links only | {head} SYMORO+ multiplications | additions |", "|---|" + "---:|" * 6, *rigid_bodies()]
    second = [f"| whole model | {head}", "|---|" + "---:|" * 4, *whole_model()]
    return "\n".join(first), "\n".join(second)


if __name__ == "__main__":
    parts = options(__doc__, parts=("time", "counts")).parts
    if "time" in parts:
        times()
    if "counts" in parts:
        print("\n\n".join(tables()))
