"""What the joints may do, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot


@dataclass(frozen=True)
class JointBounds:
    """Limits of all joints, each of shape (n,).

    Attributes:
        low, high: positions [rad or m].
        speed: [rad/s or m/s].
        acceleration: [rad/s^2 or m/s^2].
        torque: [N·m or N], infinite where there is none.
    """

    low: Array
    high: Array
    speed: Array
    acceleration: Array
    torque: Array

    @staticmethod
    def of(
        robot: Robot,
        *,
        override: float = 1.0,
        acceleration: Sequence[float] | None = None,
        torque: Sequence[float] | None = None,
    ) -> "JointBounds":
        """Limits of a robot.

        Args:
            robot: its description holds positions and speeds; a design needs both.
            override: fraction of the nominal speed that may be used, as on a controller.
            acceleration: instead of the description's [rad/s^2 or m/s^2].
            torque: instead of the description's [N·m or N].

        Raises:
            InputError: if a limit is missing or does not fit.
        """
        if not 0.0 < override <= 1.0:
            raise InputError(f"the speed override is {override:g}: give a fraction above 0, at most 1")
        limits = [joint.limits for joint in robot.joints]
        low, high = np.array([limit.position for limit in limits]).T
        strong = _given(robot, acceleration, "acceleration", [limit.acceleration for limit in limits])
        pull = _given(robot, torque, "torque", [limit.torque for limit in limits])
        top = override * np.array([limit.speed for limit in limits])
        for name, values in (("position", high - low), ("speed", top), ("acceleration", strong)):
            missing = [str(j + 1) for j in np.flatnonzero(~np.isfinite(values))]
            if missing:
                raise InputError(
                    f"robot {robot.name!r} has no {name} limit for joint {', '.join(missing)}: "
                    "a motion cannot be designed; add it to the description"
                )
        return JointBounds(low, high, top, strong, pull)

    @property
    def middle(self) -> Array:
        """Middle of the position range [rad or m]."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def half(self) -> Array:
        """Half of the position range [rad or m]."""
        return np.asarray(0.5 * (self.high - self.low))


def _given(robot: Robot, values: Sequence[float] | None, name: str, described: Sequence[float]) -> Array:
    numbers = np.array(described if values is None else values, dtype=float)
    if numbers.shape != (robot.n,) or not (numbers > 0.0).all():
        raise InputError(
            f"{name} limits {values} do not fit: robot {robot.name!r} needs {robot.n} positive numbers"
        )
    return numbers
