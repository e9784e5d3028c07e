"""What every payload method returns, and the frame in which it is given."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...common.arrays import Array, frozen_array
from ...model import INERTIAL, InertialParameters, Pose, Robot
from ...model.inertia import PayloadSpread, payload_spread
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import Estimate

METHOD_NAMES = {1: "known-robot", 2: "change", 3: "difference", 4: "global"}
"""The paper's methods, by number, in a word."""


@dataclass(frozen=True)
class PayloadEstimate:
    """A payload as one method sees it: all ten parameters, or those that a short motion determines.

    Attributes:
        method: 1 to 4.
        estimate: the parameters of ``PAYLOAD`` about the origin of ``frame``, with covariance.
        frame: the frame, in words.
        without_robust: why there are no robust standard deviations although they were asked for.
        from_scale: whether the mass is a scale's, not the torques'.
    """

    method: int
    estimate: Estimate
    frame: str
    without_robust: str = ""
    from_scale: bool = False

    @cached_property
    def places(self) -> tuple[int, ...]:
        """Where the determined parameters stand among the ten."""
        return tuple(PAYLOAD.index(name) for name in self.estimate.names)

    def unexplained(self, torque_rms: Array) -> Array:
        """Each joint's error over another torque (rms), shape (n,); nan where there is no equation or no torque."""
        rows = np.array(self.estimate.fit.rows, dtype=float)
        torque = np.where((rows > 0) & (torque_rms > 0.0), torque_rms, np.nan)
        return np.asarray(self.estimate.fit.error_norms / np.sqrt(np.maximum(rows, 1.0)) / torque)

    @property
    def complete(self) -> bool:
        """Whether all ten are determined."""
        return len(self.places) == len(PAYLOAD)

    @property
    def ten(self) -> Array:
        """The ten, nan where not determined, shape (10,)."""
        values = np.full(len(PAYLOAD), np.nan)
        values[list(self.places)] = self.estimate.values
        return values

    @cached_property
    def body(self) -> InertialParameters:
        """The payload as a body; all ten must be determined."""
        return InertialParameters(self.estimate.values)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @cached_property
    def sigma_com(self) -> Array:
        """Standard deviations of the centre of mass [m], shape (3,), by the full covariance."""
        return self._spread(self.estimate.covariance).com

    @cached_property
    def sigma_inertia_com(self) -> Array:
        """Standard deviations of the inertia at the centre of mass [kg m^2], 3 x 3, by the full covariance."""
        return self._spread(self.estimate.covariance).inertia_com

    @cached_property
    def sigma_com_robust(self) -> Array | None:
        """Standard deviations that hold for autocorrelated noise [m], where it was asked for."""
        robust = self.estimate.robust
        return self._spread(robust.covariance).com if robust else None

    @cached_property
    def sigma_inertia_com_robust(self) -> Array | None:
        """Standard deviations that hold for autocorrelated noise [kg m^2], 3 x 3, where it was asked for."""
        robust = self.estimate.robust
        return self._spread(robust.covariance).inertia_com if robust else None

    @cached_property
    def larger_sigma(self) -> Array:
        """The larger of the formula's and the robust standard deviation of each parameter, shape (10,)."""
        return self.estimate.larger_sigma

    def _spread(self, covariance: Array) -> PayloadSpread:
        return payload_spread(self.estimate.values, covariance, range(len(INERTIAL)))


def in_payload_frame(robot: Robot, equations: Equations) -> Equations:
    """Equations whose payload stands in frame n, in the ten parameters about ``robot.payload_frame`` instead.

    Args:
        robot: its payload frame stands at ``robot.flange`` in frame n.
        equations: ``PAYLOAD`` among their columns.
    """
    if robot.flange.is_identity:
        return equations
    places, M = [equations.columns.index(name) for name in PAYLOAD], np.eye(len(equations.columns))
    M[np.ix_(places, places)] = frame_change(robot.flange)
    return equations.transformed(M, equations.columns)


@lru_cache(maxsize=64)
def frame_change(pose: Pose) -> Array:
    """How the ten parameters of a body change with its frame, 10 x 10.

    Args:
        pose: of the frame they are given in, in the frame they are wanted in.
    """
    columns = [InertialParameters(unit).moved(pose.R, pose.p).vector for unit in np.eye(10)]
    return frozen_array(np.column_stack(columns), (10, 10), "change of frame")
