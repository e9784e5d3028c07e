"""What controllers make of the samples in a motion's file, between them and by their own interpolation.

ROS 2: joint_trajectory_controller joins points with positions, speeds and accelerations by quintic polynomials
(control.ros.org, Trajectory Representation). URScript: servoj follows positions alone; they are joined by the
smoothest curve that rests at both ends.
"""

from collections.abc import Mapping

import numpy as np

from ...model import Motion
from ...trajectories import SampledTrajectory
from .written import WrittenMotion

_RATE = 1000.0  # Hz: at which the curves are looked at


def controller_replays(written: WrittenMotion, ros2: float | None, urscript: float | None) -> Mapping[str, Motion]:
    """Runs by the name of the controller.

    Args:
        ros2, urscript: points a second in the file for each [Hz]; None where none is written.
    """
    runs = {}
    if ros2 is not None:
        points = written.sampled(ros2)
        runs["ROS 2"] = SampledTrajectory(points.t, points.q, points.qd, points.qdd, "--ros2").motion(_RATE)
    if urscript is not None:
        q = written.cycles(urscript)
        runs["URScript"] = SampledTrajectory(np.arange(len(q)) / urscript, q, source="--urscript").motion(_RATE)
    return runs
