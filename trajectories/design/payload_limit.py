"""Torque limits for every payload of a set, exact and smooth where one body is the worst.

Where the worst body is unique, the slope of the largest torque is that of the worst body's torque (Danskin's
envelope theorem): the body itself is the slope in the regressor's payload columns.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from .information import RegressorKernel
from .limits import Limit, State, joint_labels
from .payloads import PayloadSet, PayloadTorque


@dataclass(frozen=True, eq=False)
class RobotTorque:
    """The robot's own torque W chi and how sure it is.

    Attributes:
        chi: in the kernel's columns, shape (c,).
        root: C = root root' is the covariance of chi, c x r; r = 0 where it is taken as exact.
        sigmas: so many standard deviations count.
    """

    chi: Array
    root: Array
    sigmas: float = 2.0


def payload_limit(
    kernel: RegressorKernel, own: RobotTorque, torque: Array, payloads: PayloadSet, columns: Sequence[str]
) -> Limit:
    """Largest and smallest torque of each joint over its limit, of all payloads of a set.

    The first n values are the largest torques, bounded above alone, the others the smallest, bounded below alone.

    Args:
        kernel: holds the payload's columns.
        own: torque without payload.
        torque: limits [N·m or N], shape (n,), infinite where there is none.
        payloads: in the last link's frame.
        columns: names of the payload's ten columns.
    """
    n, finite = len(torque), np.isfinite(torque)
    unit = np.where(finite, torque, 1.0)
    none, bound = np.full(n, np.inf), np.where(finite, 1.0, np.inf)
    torques = _PayloadTorques(kernel, own, payloads, tuple(columns))

    def values(state: State) -> Array:
        return np.asarray(torques.values(state.entries) / np.tile(unit, 2))

    def pullback(state: State, slope: Array, into: State) -> None:
        torques.pullback(state.entries, slope / np.tile(unit, 2), into.entries)

    return Limit(
        "torque",
        f"torque with any payload up to {payloads.mass:g} kg",
        joint_labels(n) * 2,
        np.concatenate([-none, -bound]),
        np.concatenate([bound, none]),
        np.zeros(2 * n),
        np.tile(unit, 2),
        values,
        pullback,
    )


class _PayloadTorques:
    """Extreme torques [N·m or N] from a regressor's entries, and their slopes."""

    def __init__(
        self, kernel: RegressorKernel, own: RobotTorque, payloads: PayloadSet, columns: tuple[str, ...]
    ) -> None:
        """Find the payload's columns among each joint's entries."""
        self._kernel, self._own, self._payloads = kernel, own, payloads
        place = {kernel.columns.index(name): k for k, name in enumerate(columns)}
        self._rows: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
        for part, names in kernel.parts:
            pairs = [(part.start + i, place[name]) for i, name in enumerate(names) if name in place]
            rows, numbers = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
            self._rows.append((rows, numbers))
        self._last: tuple[Array, tuple[PayloadTorque, PayloadTorque]] | None = None

    def values(self, entries: Array) -> Array:
        """Largest, then smallest torques, (N, 2 n)."""
        torque, doubt = self._kernel.torque(entries, self._own.chi), self._doubt(entries)[0]
        largest, smallest = (extreme.torque.reshape(torque.T.shape).T for extreme in self._extremes(entries))
        return np.hstack([torque + doubt + largest, torque - doubt + smallest])

    def pullback(self, entries: Array, slope: Array, seed: Array) -> None:
        """Add to ``seed`` what slopes in the torques (N, 2 n) mean for the entries."""
        up, down = np.split(slope, 2, axis=1)
        self._kernel.torque_slope(up + down, self._own.chi, seed)
        self._doubt_slope(entries, up - down, seed)
        for share, extreme in zip((up, down), self._extremes(entries), strict=True):
            bodies = extreme.body.T.reshape(10, len(self._rows), -1)
            for j, (rows, numbers) in enumerate(self._rows):
                if share[:, j].any():
                    seed[rows] += bodies[numbers, j] * share[:, j]

    def _extremes(self, entries: Array) -> tuple[PayloadTorque, PayloadTorque]:
        """Joint after joint, (n N,) and (n N, 10); kept until other entries come, for slopes follow values."""
        if self._last is None or self._last[0] is not entries:
            self._last = entries, self._searched(entries)
        return self._last[1]

    def _searched(self, entries: Array) -> tuple[PayloadTorque, PayloadTorque]:
        columns = np.zeros((len(self._rows), entries.shape[1], 10))
        for own, (rows, numbers) in zip(columns, self._rows, strict=True):
            own[:, numbers] = entries[rows].T
        return self._payloads.extremes(columns.reshape(-1, 10))

    def _doubt(self, entries: Array) -> tuple[Array, list[Array]]:
        """So many standard deviations of the robot's own torque, (N, n), and root' w of each joint, r x N."""
        spread = [self._own.root[names].T @ entries[part] for part, names in self._kernel.parts]
        sizes = [np.sqrt((share**2).sum(axis=0)) for share in spread]
        return self._own.sigmas * np.stack(sizes, axis=1), spread

    def _doubt_slope(self, entries: Array, slope: Array, seed: Array) -> None:
        if not self._own.root.shape[1]:
            return
        doubt, spread = self._doubt(entries)
        for j, (part, names) in enumerate(self._kernel.parts):
            size = np.where(doubt[:, j] > 0.0, doubt[:, j], 1.0) / self._own.sigmas**2
            seed[part] += self._own.root[names] @ spread[j] * (slope[:, j] / size)
