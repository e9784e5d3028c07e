"""JointTrajectory of ROS 2 as YAML: trajectory_msgs/msg/JointTrajectory.

Layout: header (stamp, frame_id), joint_names, and points with positions, velocities, accelerations, effort and
time_from_start (sec, nanosec, counted from the start of the trajectory). Numbers carry a decimal point and no
exponent, which YAML 1.1 would take for text. Source: docs.ros.org/en/jazzy/p/trajectory_msgs/msg/JointTrajectory
and JointTrajectoryPoint; builtin_interfaces/msg/Duration.
"""

import re
from collections.abc import Sequence
from functools import partial

from ....common.errors import InputError
from ....trajectories import SampledTrajectory
from ..format import Format
from ..motion import DENSER, WrittenMotion, listed

_SECOND = 1_000_000_000


def _replay(motion: WrittenMotion) -> SampledTrajectory:
    # Quintics between points with speeds and accelerations (control.ros.org, Trajectory Representation).
    points = motion.sampled()
    return SampledTrajectory(points.t, points.q, points.qd, points.qdd, "--ros2")


@partial(
    Format,
    title="JointTrajectory of ROS 2",
    source="trajectory_msgs/msg/JointTrajectory",
    remarks=("trajectory_msgs/msg/JointTrajectory; be at the first point before it starts.",),
    replay=_replay,
    replayed=("ROS 2 joins the samples", DENSER),
)
def _write(motion: WrittenMotion) -> str:
    samples = motion.sampled()
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:"]
    lines += [f"- '{name}'" for name in check_joint_names(motion.joint_names, motion.robot.n)]
    lines.append("points:")
    for t, q, qd, qdd in zip(samples.t, samples.q, samples.qd, samples.qdd, strict=True):
        sec, nanosec = divmod(round(float(t) * _SECOND), _SECOND)
        lines += [
            f"- positions: {listed(q)}",
            f"  velocities: {listed(qd)}",
            f"  accelerations: {listed(qdd)}",
            "  effort: []",
            f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}",
        ]
    return "\n".join(lines)


def check_joint_names(names: Sequence[str], n: int) -> tuple[str, ...]:
    """The names, or joint_1 and so on if there are none; names that do not fit ``n`` joints are refused."""
    names = tuple(names) or tuple(f"joint_{j}" for j in range(1, n + 1))
    if not len({name for name in names if re.fullmatch(r"[A-Za-z0-9_/.-]+", name)}) == len(names) == n:
        raise InputError(f"joint names {', '.join(names)}: give {n} different ones of letters, digits and _ - / .")
    return names
