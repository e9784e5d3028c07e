"""Scatter of constant torques and Coulomb friction from window to window without any payload.

Run: DYNIDENT_DATA=.. python benchmarks/constant_torques.py. Windows of unloaded recordings share all other
parameters of the robot; constant torque and Coulomb friction are each window's own. Printed is the scatter beyond
the noise of the windows' estimates (Paule and Mandel, with a 90 % interval), as a share of the Coulomb friction and
of the torque. Recordings with payload, by which weighing is judged, take no part;
``estimation.payload.short_motion`` uses the result.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.benchmarks.shared import UR10E_GAINS, recordings_folder, rms, show
from dynident.common.arrays import Array
from dynident.estimation.equations.observer import Observation, Observer
from dynident.estimation.fit.covariance import autocorrelation_time
from dynident.estimation.payload.short_motion import SLOW
from dynident.estimation.signals.filtering import measurement, used_rows
from dynident.model import Robot, base_parameters, load_robot
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2

UR10E = ("ur10e/unloaded.csv.gz", "ur10e/validation_unloaded.csv.gz", "ur10e/validation_point_to_point.csv.gz")
TX40 = ("tx40/tx40.csv.gz",)
ARM, WRIST = (1, 2, 3), (4, 5, 6)


class Scatter(NamedTuple):
    """One parameter of one joint by windows: estimates, their variances, and what they are compared with."""

    kind: str
    joint: int
    values: Array
    variances: Array
    friction: float
    torque: float


def windows(folder: Path, robot: Robot, files: Sequence[str], length: float | None) -> list[Observation]:
    """Equal windows of at least ``length`` [s] of each recording, or each whole."""
    observer = Observer(robot.with_offsets(True), base_parameters(robot.with_offsets(True)).columns)
    parts = []
    for file in files:
        recording = read_recording(folder / file, robot, UR10E_GAINS if file.startswith("ur10e") else None)
        data = measurement(recording, robot.processing)
        keep = used_rows(data.motion, robot.processing) & (np.abs(data.motion.qd) >= SLOW)
        whole = observer.observe(data, keep, robot.processing.decimate)
        times = np.concatenate(whole.t)
        count = max(1, int(np.ptp(times) / length)) if length else 1
        edges = np.linspace(times.min(), times.max() + 1e-9, count + 1)
        parts += [whole.between(*pair) for pair in pairwise(edges)]
    return parts


def scatters(robot: Robot, parts: Sequence[Observation]) -> list[Scatter]:
    """Constant torque and Coulomb friction of each joint and window."""
    columns = parts[0].columns
    own = [k for k, name in enumerate(columns) if name.startswith(("OFF", "FS")) and name[-1].isdigit()]
    rest = [k for k in range(len(columns)) if k not in own]
    joint = np.concatenate([np.full(len(Y), j) for part in parts for j, Y in enumerate(part.Y)])
    place = np.concatenate([np.full(len(Y), k) for k, part in enumerate(parts) for Y in part.Y])
    W = np.vstack([rows for part in parts for rows in part.W])
    y = np.concatenate([torques for part in parts for torques in part.Y])
    A = np.hstack([W[:, rest], *(W[:, own] * (place == k)[:, None] for k in range(len(parts)))])
    x, variance, error = solved_by_joint(A, y, joint, robot.n)
    spreads = []
    for j in range(robot.n):
        own_errors = [error[(joint == j) & (place == k)] for k in range(len(parts))]
        series = [(part.t[j], own) for part, own in zip(parts, own_errors, strict=True) if len(part.t[j]) > 3]
        step = min(float(np.diff(t).min()) for t, _ in series)
        memory = max(1.0, 2.0 * autocorrelation_time(series, step) / step)
        torque = float(rms(y[joint == j]))
        at = {kind: own.index(columns.index(f"{kind}{j + 1}")) for kind in ("OFF", "FS")}
        where = {kind: len(rest) + len(own) * np.arange(len(parts)) + k for kind, k in at.items()}
        friction = float(np.mean(x[where["FS"]]))
        for kind, k in where.items():
            spreads.append(Scatter(kind, j + 1, x[k], memory * variance[k], friction, torque))
    return spreads


def solved_by_joint(A: Array, y: Array, joint: NDArray[np.int_], n: int) -> tuple[Array, Array, Array]:
    """Least squares with each joint's own weight: solution, its variances, errors."""
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    weight = np.ones(n)
    for _ in range(3):
        rows = weight[joint][:, None] * A / scale
        x = np.linalg.lstsq(rows, weight[joint] * y, rcond=1e-10)[0] / scale
        error = y - A @ x
        weight = np.array([1.0 / rms(error[joint == j]) for j in range(n)])
    return x, np.diag(np.linalg.pinv(rows.T @ rows, rcond=1e-12)) / scale**2, error


def beyond_noise(some: Sequence[Scatter], unit: Callable[[Scatter], float]) -> tuple[float, float, float]:
    """Common standard deviation in that unit: estimate, and ends of its 90 % interval."""
    freedom = sum(len(scatter.values) - 1 for scatter in some)

    def spread(share: float) -> float:
        total = 0.0
        for scatter in some:
            weights = 1.0 / (scatter.variances + (share * unit(scatter)) ** 2)
            mean = weights @ scatter.values / weights.sum()
            total += float(weights @ (scatter.values - mean) ** 2)
        return total

    def solved(level: float) -> float:
        return 0.0 if spread(0.0) <= level else float(brentq(lambda share: spread(share) - level, 0.0, 1.0))

    return solved(freedom), solved(float(chi2.ppf(0.95, freedom))), solved(float(chi2.ppf(0.05, freedom)))


def main() -> None:
    folder = recordings_folder("constant torques")
    if folder is None:
        return
    for title, name, files, length in (
        ("UR10e, two recordings, 10 s", "ur10e", UR10E[:2], 10.0),
        ("UR10e, validation_unloaded alone, 10 s", "ur10e", UR10E[1:2], 10.0),
        ("UR10e, three recordings, each whole", "ur10e", UR10E, None),
        ("TX40, 2 s", "tx40", TX40, 2.0),
    ):
        robot, rows = load_robot(name), []
        parts = windows(folder, robot, files, length)
        every = scatters(robot, parts)
        for kind, words in (("OFF", "constant torque"), ("FS", "Coulomb friction")):
            for joints in (ARM, WRIST):
                some = [scatter for scatter in every if scatter.kind == kind and scatter.joint in joints]
                friction, torque = (
                    "{:.1f} [{:.1f}, {:.1f}]".format(*(100 * share for share in beyond_noise(some, unit)))
                    for unit in (lambda scatter: scatter.friction, lambda scatter: scatter.torque)
                )
                rows.append([f"{words}, joints {joints[0]}-{joints[-1]}", friction, torque])
        title = f"{title}: {len(parts)} windows; scatter beyond noise [90 % interval], % of Coulomb friction"
        show(title, rows, "% of the torque", asked=False)


if __name__ == "__main__":
    main()
