"""What a motion near a pose will tell of a payload, before it is made."""

from collections.abc import Sequence

import numpy as np

from ..common.arrays import Array
from ..common.linear import decomposed, without
from ..model import InertialParameters, Motion, Robot
from ..model.payload_spread import PayloadSpread, payload_spread
from ..model.regressors import payload_columns
from ..model.visibility import friction_columns, visibility_of
from .observation import regressor_kernel
from .samples import Samples

SLOW = 0.03
"""rad/s or m/s: rows of a slower joint are not used; the sign of its friction is not sure."""


def predicted_spread(
    robot: Robot,
    motion: Motion,
    joints: Sequence[int],
    noise: Array,
    rate: float,
    expected: InertialParameters,
    mass_sigma: float | None = None,
) -> PayloadSpread:
    """Standard deviations by (17)-(19) of a payload's numbers; constant torques and Coulomb friction unknown too.

    Args:
        robot: the robot.
        motion: evenly sampled.
        joints: numbers of the joints whose torques count.
        noise: standard deviation of a torque sample per joint [N·m or N], shape (n,).
        rate: independent torque samples per second [Hz].
        expected: about what the payload is.
        mass_sigma: of the scale on which it was weighed [kg]; None where it was not.
    """
    free = robot.with_offsets(True)
    kernel = regressor_kernel(free, (*payload_columns(free), *friction_columns(free)))
    count = len(motion.t)
    W = kernel.matrix(Samples(np.ones(count), motion.q, motion.qd, motion.qdd)).reshape(robot.n, count, -1)
    rows = []
    for joint in joints:
        own = W[joint - 1][np.abs(motion.qd[:, joint - 1]) >= SLOW]
        share = np.sqrt(rate / motion.rate) / noise[joint - 1]
        rows.append(share * without(own[:, :10], own[:, 10:]))
    A = np.vstack(rows)
    seen = visibility_of(A, joints)
    places, T, b = seen.resolved(mass_sigma is not None)
    C = _covariance(A[:, list(seen.chosen)], seen.chosen, mass_sigma)
    total = T @ C @ T.T + (0.0 if mass_sigma is None else np.outer(b, b) * mass_sigma**2)
    return payload_spread(expected.vector, total, places)


def _covariance(W: Array, chosen: tuple[int, ...], mass_sigma: float | None) -> Array:
    """Of least squares, with the scale as one more equation where the mass is among the parameters."""
    if mass_sigma is not None and 9 in chosen:
        W = np.vstack([W, (np.array(chosen) == 9)[None] / mass_sigma])
    return decomposed(W).covariance
