"""Motions of a simulated RX90 that are the same in every run; each run draws other torque noise.

The filtered and decimated rows of W and their Gram matrices are made once; a run draws the rows' noise and solves
the normal equations with and without each block (the condition number of W is about 60). Numbers agree with the
library's own way from recordings to standard deviations: ``Experiment.by_the_library``.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD
from dynident.common.arrays import Array
from dynident.estimation import PAYLOAD, Estimate, Settings, payload_estimate
from dynident.estimation.equations.observer import Observation
from dynident.estimation.fit.blocks import autocorrelation_time, block_edges, span
from dynident.estimation.fit.covariance import RobustCovariance
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.payload.problem import PairedMeasurement, loaded_observer, long_motion
from dynident.estimation.signals.decimation import decimated
from dynident.estimation.signals.filtering import measurement
from dynident.model import InertialParameters, Motion, base_parameters, load_robot
from dynident.model.motion import Measurement
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from scipy.signal import lfilter

BODIES = {
    "disc": PAPER_PAYLOAD,
    "cube": InertialParameters.from_com(7.025, [0.0, 0.0, 0.143], 7.025 * 0.2**2 / 6.0 * np.eye(3)),
}
JOINTS = range(6)

Torques = list[Array]
"""One array per joint: the rows of all recordings, one recording after the other."""


class Sums(NamedTuple):
    """Normal equations by joint and block: ``G`` 6 x B x c x c, ``g`` 6 x B x c; ``yy`` and ``rows`` (6,)."""

    G: Array
    g: Array
    yy: Array
    rows: Array


class Experiment:
    """Fixed motions; each run draws other noise."""

    def __init__(self, trajectories: int) -> None:
        """Simulate and process without noise."""
        self.robot = load_robot("rx90")
        self.base, self.processing = base_parameters(self.robot), self.robot.processing
        self.simulator = Simulator(self.robot)
        self.motions = [random_via_points(self.robot, 14, seed).motion(250.0) for seed in range(trajectories)]
        watcher = loaded_observer(self.robot, self.base)
        loads: dict[str, InertialParameters | None] = {"bare": None, **BODIES}
        observations = {
            name: [watcher.observe(self.measured(motion, load), self.processing) for motion in self.motions]
            for name, load in loads.items()
        }
        self.recordings: list[Observation] = observations["bare"]
        self.W = [np.vstack([observation.W[j] for observation in self.recordings]) for j in JOINTS]
        self.exact = {
            name: [np.concatenate([observation.Y[j] for observation in all_of]) for j in JOINTS]
            for name, all_of in observations.items()
        }
        self.truth = self.base.value(self.robot.parameters)
        self.bandwidth, self.columns = self.recordings[0].bandwidth, self.recordings[0].columns
        self.step = min(float(np.diff(t).min()) for observation in self.recordings for t in observation.t)
        self.duration = sum(float(np.ptp(span(observation))) for observation in self.recordings)
        self._grams: dict[tuple[int, int], Array] = {}

    def measured(self, motion: Motion, load: InertialParameters | None, noise: Array | None = None) -> Measurement:
        """What the library makes of a recording; noise samples x 6 [N·m]."""
        recording = self.simulator.record(motion, load)
        clean = measurement(recording, self.processing)
        return clean if noise is None else Measurement(clean.motion, clean.torque + noise)

    def noise(self, memory: float, seed: int) -> list[list[Array]]:
        """For no load and load, for each motion: samples x 6 [N·m]; as large as behind the paper's Table 2."""
        draw = np.random.default_rng(seed)
        return [[_noise(draw, len(motion.t), memory) for motion in self.motions] for _ in range(2)]

    def on_rows(self, noise: Sequence[Array]) -> Torques:
        """Noise as the rows of W see it: decimated like them."""
        parts: list[list[Array]] = [[] for _ in JOINTS]
        for observation, motion, samples in zip(self.recordings, self.motions, noise, strict=True):
            slow = decimated(np.ascontiguousarray(samples.T), self.processing.decimate)
            step = self.processing.decimate * (motion.t[1] - motion.t[0])
            for j in JOINTS:
                parts[j].append(slow[j, np.rint((observation.t[j] - motion.t[0]) / step).astype(int)])
        return [np.concatenate(part) for part in parts]

    def sums(self, Y: Torques, length: float) -> Sums:
        """Normal equations in all 64 columns by blocks of at least ``length`` [s]."""
        G, g = [], []
        offsets = np.zeros(6, dtype=int)
        for k, observation in enumerate(self.recordings):
            edges = block_edges(observation, length)
            cuts = [np.searchsorted(t, edges).tolist() for t in observation.t]
            if (k, len(edges)) not in self._grams:
                self._grams[k, len(edges)] = np.array([_gram(observation.W[j], cuts[j]) for j in JOINTS])
            G.append(self._grams[k, len(edges)])
            rows = [slice(offsets[j], offsets[j] + len(observation.t[j])) for j in JOINTS]
            g.append(np.array([_added(observation.W[j] * Y[j][rows[j], None], cuts[j]) for j in JOINTS]))
            offsets += [len(t) for t in observation.t]
        yy = np.array([y @ y for y in Y])
        return Sums(np.concatenate(G, axis=1), np.concatenate(g, axis=1), yy, np.array([len(y) for y in Y], float))

    def length(self, groups: Sequence[tuple[Torques, slice]]) -> float:
        """Length of a block by the library's rule, from the residuals of each group's own columns."""
        memory = 0.0
        for Y, columns in groups:
            x = self.answer([(self.sums(Y, np.inf), columns)], self.columns[columns], robust=False).values
            errors = [y - W[:, columns] @ x for W, y in zip(self.W, Y, strict=True)]
            ends = [np.cumsum([len(observation.t[j]) for observation in self.recordings])[:-1] for j in JOINTS]
            for j in JOINTS:
                series = zip(
                    (observation.t[j] for observation in self.recordings), np.split(errors[j], ends[j]), strict=True
                )
                memory = max(memory, autocorrelation_time(list(series), self.step))
        return max(5.0 * memory, 1.0, self.duration / 100.0)

    def answer(
        self, parts: Sequence[tuple[Sums, slice]], names: Sequence[str], robust: bool = True, length: float = 0.0
    ) -> Estimate:
        """Weighted least squares on the sum of equations, each in a slice of the columns."""
        whole = _combined(parts, len(names))
        rows = whole.rows.sum()
        effective = self.bandwidth * rows
        N, n = whole.G.sum(axis=1), whole.g.sum(axis=1)
        ordinary = np.linalg.solve(N.sum(axis=0), n.sum(axis=0))
        share = 1.0 - len(names) / effective
        weights = np.sqrt(whole.rows * share) / _error_norms(N, n, whole.yy, ordinary)
        square = weights[:, None] ** 2
        total, right = np.tensordot(square[:, 0], N, 1), (square * n).sum(axis=0)
        x, inverse = np.linalg.solve(total, right), np.linalg.inv(total)
        dof = effective - len(names)
        norms = _error_norms(N, n, whole.yy, x)
        variance = float(np.sum((weights * norms) ** 2)) / dof
        jackknife = None
        if robust:
            lost, gone = np.tensordot(square[:, 0], whole.G, 1), np.tensordot(square[:, 0], whole.g, 1)
            changes = np.linalg.solve(total - lost, (right - gone)[..., None])[..., 0] - x
            B = len(changes)
            jackknife = RobustCovariance((1.0 - 1.0 / B) * changes.T @ changes, B, B - 1, length)
        fit = Fit(norms, np.sqrt(whole.yy), tuple(int(count) for count in whole.rows))
        return Estimate(tuple(names), x, variance * inverse, dof, fit, weights, jackknife)

    def run(self, memory: float, seed: int) -> tuple[Estimate, dict[tuple[str, int], Estimate]]:
        """The robot, and the payload by body and method."""
        bare_noise, loaded_noise = (self.on_rows(noise) for noise in self.noise(memory, seed))
        c = len(self.base.columns)
        robot, payload, both = slice(0, c), slice(c, None), slice(None)
        bare = [exact + e for exact, e in zip(self.exact["bare"], bare_noise, strict=True)]
        length = self.length([(bare, robot)])
        known = self.answer([(self.sums(bare, length), robot)], self.columns[robot], length=length)
        estimates = {}
        for name in BODIES:
            loaded = [exact + e for exact, e in zip(self.exact[name], loaded_noise, strict=True)]
            change = [y - y0 for y, y0 in zip(loaded, bare, strict=True)]
            length = self.length([(loaded, robot), (bare, robot), (change, payload)])
            sums = [self.sums(Y, length) for Y in (bare, loaded, change)]
            estimates[name, 3] = self.answer([(sums[2], payload)], PAYLOAD, length=length)
            joint = self.answer([(sums[0], robot), (sums[1], both)], self.columns, length=length)
            estimates[name, 4] = _part(joint, payload)
        return known, estimates

    def by_the_library(self, memory: float, seed: int, body: str) -> dict[int, Estimate]:
        """Methods 3 and 4 the long way: recordings, blocks, QR."""
        robot, processing, noise = self.robot, self.processing, self.noise(memory, seed)
        bares = [self.measured(motion, None, e) for motion, e in zip(self.motions, noise[0], strict=True)]
        loadeds = [self.measured(motion, BODIES[body], e) for motion, e in zip(self.motions, noise[1], strict=True)]
        pairs = [PairedMeasurement(*pair) for pair in zip(bares, loadeds, strict=True)]
        problem = long_motion(robot, loadeds, bares, pairs, Settings(processing, friction_change=0.0))
        return {method: payload_estimate(problem, method).estimate for method in (3, 4)}


def _noise(draw: np.random.Generator, samples: int, memory: float) -> Array:
    """White, or AR(1), autocorrelation exp(-k / memory), a third as large: decimation leaves it nearly whole."""
    steps = draw.standard_normal((samples, 6))
    if memory == 0.0:
        return np.asarray(steps * RX90_NOISE)
    phi = np.exp(-1.0 / memory)
    steps[1:] *= np.sqrt(1.0 - phi**2)
    return np.asarray(lfilter([1.0], [1.0, -phi], steps, axis=0) * np.array(RX90_NOISE) / 3.0)


def _gram(W: Array, cuts: Sequence[int]) -> Array:
    return np.array([W[a:b].T @ W[a:b] for a, b in pairwise(cuts)])


def _added(rows: Array, cuts: Sequence[int]) -> Array:
    return np.array([rows[a:b].sum(axis=0) for a, b in pairwise(cuts)])


def _combined(parts: Sequence[tuple[Sums, slice]], c: int) -> Sums:
    """Equations added up; a part's columns are a slice of its own 64, and stand there among the c if c is 64."""
    total: Sums | None = None
    for part, columns in parts:
        G, g = part.G[:, :, columns, columns], part.g[:, :, columns]
        if G.shape[-1] < c:
            G, g = np.zeros((*G.shape[:2], c, c)), np.zeros((*G.shape[:2], c))
            G[:, :, columns, columns], g[:, :, columns] = part.G[:, :, columns, columns], part.g[:, :, columns]
        own = Sums(G, g, part.yy, part.rows)
        total = own if total is None else Sums(*(a + b for a, b in zip(total, own, strict=True)))
    assert total is not None
    return total


def _error_norms(N: Array, n: Array, yy: Array, x: Array) -> Array:
    return np.asarray(np.sqrt(yy - 2.0 * n @ x + np.einsum("i,jik,k->j", x, N, x)))


def _part(joint: Estimate, columns: slice) -> Estimate:
    robust = joint.robust
    assert robust is not None
    own = RobustCovariance(robust.covariance[columns, columns], robust.blocks, robust.degrees_of_freedom, 0.0)
    values, covariance = joint.values[columns], joint.covariance[columns, columns]
    return Estimate(PAYLOAD, values, covariance, joint.degrees_of_freedom, joint.fit, joint.weights, own)
