"""The observation system Y = W chi + rho of (14), joint by joint as in (15)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Kernel, Measurement, Motion, Processing, Robot, regressor
from ..model.arrays import Array
from .filtering import decimated, noise_bandwidth

_BRIDGE = 0.3  # s: a pause shorter than this does not end the moving part


@dataclass(frozen=True)
class Observation:
    """The equations of one recording.

    Attributes:
        columns: names of the columns of W.
        W: per joint, r_j x c.
        Y: per joint, torques [N·m or N], shape (r_j,); known torques (a spring) are already moved here.
        t: per joint, time of the rows [s], shape (r_j,).
        bandwidth: share of the frequency range that white noise fills; 1 without decimation.
    """

    columns: tuple[str, ...]
    W: tuple[Array, ...]
    Y: tuple[Array, ...]
    t: tuple[Array, ...]
    bandwidth: float


class Observer:
    """Turns measurements of one robot into observations of chosen columns.

    Args:
        robot: the robot.
        columns: standard parameters whose columns make up W; may repeat.
        names: what the columns are called, by default the standard names.
    """

    def __init__(self, robot: Robot, columns: Sequence[str], names: Sequence[str] | None = None) -> None:
        """Generate the code of the columns' regressor."""
        self.robot = robot
        self.columns = tuple(names or columns)
        unique = tuple(dict.fromkeys(columns))
        self._place = np.array([unique.index(name) for name in columns])
        self._kernel = Kernel(regressor(robot, unique))
        self._unique = len(unique)

    def observe(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Observation:
        """Equations of one measurement.

        Y and every column of W are filtered and decimated alike; then the longest moving part is cut out and
        rows of slow joints are left out.

        Args:
            data: the measurement, even in time if it is to be decimated.
            processing: settings.
            partner: another motion on the same time whose slow rows are left out as well.
        """
        motion, factor = data.motion, processing.decimate
        Y = decimated(self._known_torque_moved(data).T, factor)
        entries = decimated(self._kernel(motion.q, motion.qd, motion.qdd), factor)
        keep = self._kept_rows(motion, processing)
        if partner is not None:
            keep = keep & self._kept_rows(partner, processing)
        t = motion.t[::factor]
        W, torque, times = [], [], []
        for j in range(self.robot.n):
            rows = np.flatnonzero(keep[:, j])
            own = np.flatnonzero(self._kernel.rows == j)
            dense = np.zeros((self._unique, len(rows)))
            dense[self._kernel.columns[own]] = entries[np.ix_(own, rows)]
            W.append(dense[self._place].T)
            torque.append(Y[j, rows])
            times.append(t[rows])
        return Observation(self.columns, tuple(W), tuple(torque), tuple(times), noise_bandwidth(factor))

    def _known_torque_moved(self, data: Measurement) -> Array:
        spring = self.robot.spring
        if spring is None:
            return data.torque
        torque = np.array(data.torque)
        torque[:, spring.joint - 1] += spring.torque(data.motion.q[:, spring.joint - 1])
        return torque

    def _kept_rows(self, motion: Motion, processing: Processing) -> NDArray[np.bool_]:
        """Which decimated rows are used, shape (rows, n): moving, and the sign of the speed is known."""
        speed = np.abs(motion.qd)
        start, stop = moving_part(motion, processing.still_speed)
        fast = speed >= processing.slow_fraction * speed[start:stop].max(axis=0, initial=0.0)
        fast &= speed > 0.0
        fast[:start] = False
        fast[stop:] = False
        kept: NDArray[np.bool_] = fast[:: processing.decimate]
        return kept


def moving_part(motion: Motion, still_speed: float) -> tuple[int, int]:
    """First sample and one past the last of the longest stretch in which some joint moves.

    Args:
        motion: the motion.
        still_speed: a joint below it stands still [rad/s or m/s]. Pauses under 0.3 s do not end a stretch.
    """
    moving = np.flatnonzero((np.abs(motion.qd) > still_speed).any(axis=1))
    if moving.size == 0:
        return 0, 0
    breaks = np.flatnonzero(np.diff(motion.t[moving]) > _BRIDGE)
    starts = moving[np.concatenate([[0], breaks + 1])]
    stops = moving[np.concatenate([breaks, [moving.size - 1]])] + 1
    longest = int(np.argmax(stops - starts))
    return int(starts[longest]), int(stops[longest])
