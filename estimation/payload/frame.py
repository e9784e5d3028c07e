"""From the last link's frame, in which the equations stand, to the frame in which a payload is given."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...model import InertialParameters, Pose, Robot
from ..fit.estimate import Estimate


def in_payload_frame(robot: Robot, estimate: Estimate) -> Estimate:
    """A payload in ``robot.payload_frame``, with all its covariances.

    Args:
        robot: its payload frame stands at ``robot.flange`` in frame n.
        estimate: of the payload's ten parameters in frame n.
    """
    if robot.flange.is_identity:
        return estimate
    T = frame_change(robot.flange.inverse())
    robust = estimate.robust
    if robust is not None:
        robust = replace(robust, covariance=T @ robust.covariance @ T.T)
    return replace(estimate, values=T @ estimate.values, covariance=T @ estimate.covariance @ T.T, robust=robust)


def frame_change(pose: Pose) -> Array:
    """How the ten parameters of a body change with its frame, 10 x 10.

    Args:
        pose: of the frame they are given in, in the frame they are wanted in.
    """
    return np.column_stack([InertialParameters(unit).moved(pose.R, pose.p).vector for unit in np.eye(10)])
