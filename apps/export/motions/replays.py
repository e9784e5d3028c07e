"""What controllers make of a motion's file, between its points and by their own interpolation.

ROS 2: joint_trajectory_controller joins points with positions, speeds and accelerations by quintic polynomials
(control.ros.org, Trajectory Representation). URScript: servoj follows positions alone; they are joined by the
smoothest curve that rests at both ends. VAL3: an estimate, trapezoids of speed; see val3_moves.py.
"""

from typing import NamedTuple

import numpy as np

from ....trajectories import SampledTrajectory
from ....trajectories.motions.family import Plan
from .val3 import val3_replay
from .written import WrittenMotion

_DENSER = "write more of them a second, or leave more room by --torque-margin"
_SHAPED = "design with --segments trapezoid, or leave more room by --torque-margin"


class Replay(NamedTuple):
    """A motion as a controller runs it.

    Attributes:
        plan: the run.
        words: what the controller does.
        advice: where the run does not keep a limit.
    """

    plan: Plan
    words: str
    advice: str


class Rates(NamedTuple):
    """Points a second in a motion's files [Hz]; None where none is written."""

    ros2: float | None = None
    urscript: float | None = None


def controller_replays(written: WrittenMotion, rates: Rates, val3: bool = False) -> list[Replay]:
    """Runs by the controllers whose files are written.

    Args:
        written: the motion.
        rates: of its files.
        val3: whether a VAL3 application is written.
    """
    runs: list[Replay] = []
    if rates.ros2 is not None:
        points = written.sampled(rates.ros2)
        curve = SampledTrajectory(points.t, points.q, points.qd, points.qdd, "--ros2")
        runs.append(Replay(curve, "ROS 2 joins the samples", _DENSER))
    if rates.urscript is not None:
        # It stands in the first pose before, and in the last one afterwards.
        t = np.arange(-1, int(np.ceil(written.plan.duration * rates.urscript - 1e-9)) + 2) / rates.urscript
        curve = SampledTrajectory(t, written.plan.at(t)[0], source="--urscript")
        runs.append(Replay(curve, "URScript joins the samples", _DENSER))
    if val3:
        runs.append(Replay(val3_replay(written), "VAL3 may move from point to point", _SHAPED))
    return runs
