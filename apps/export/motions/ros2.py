"""JointTrajectory of ROS 2 as YAML: trajectory_msgs/msg/JointTrajectory.

Layout: header (stamp, frame_id), joint_names, and points with positions, velocities, accelerations, effort and
time_from_start (sec, nanosec, counted from the start of the trajectory). Numbers carry a decimal point and no
exponent, which YAML 1.1 would take for text. Source: docs.ros.org/en/jazzy/p/trajectory_msgs/msg/JointTrajectory
and JointTrajectoryPoint; builtin_interfaces/msg/Duration.
"""

from collections.abc import Sequence

from ....common.errors import InputError
from .written import WrittenMotion, listed

_SECOND = 1_000_000_000


def ros2_text(written: WrittenMotion, rate: float, joint_names: Sequence[str] = ()) -> str:
    """The file.

    Args:
        rate: points per second [Hz].
        joint_names: as the controller calls them; joint_1 and so on if none are given.

    Raises:
        InputError: if the names do not fit.
    """
    names = check_joint_names(joint_names, written.robot.n)
    motion = written.sampled(rate)
    lines = [f"# {line}" for line in written.head]
    lines += ["# trajectory_msgs/msg/JointTrajectory; be at the first point before it starts."]
    lines += ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:"]
    lines += [f"- '{name}'" for name in names]
    lines.append("points:")
    for t, q, qd, qdd in zip(motion.t, motion.q, motion.qd, motion.qdd, strict=True):
        sec, nanosec = divmod(round(float(t) * _SECOND), _SECOND)
        lines += [
            f"- positions: {listed(q)}",
            f"  velocities: {listed(qd)}",
            f"  accelerations: {listed(qdd)}",
            "  effort: []",
            f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}",
        ]
    return "\n".join(lines) + "\n"


def check_joint_names(names: Sequence[str], n: int) -> list[str]:
    """The names, or joint_1 and so on if there are none.

    Raises:
        InputError: if they do not fit ``n`` joints.
    """
    names = list(names) or [f"joint_{j}" for j in range(1, n + 1)]
    if len(names) != n or len(set(names)) != n or not all(_plain(name) for name in names):
        raise InputError(
            f"joint names {', '.join(names)}: {n} different names of letters, digits and _ - / . are needed"
        )
    return names


def _plain(name: str) -> bool:
    return bool(name) and all(letter.isascii() and (letter.isalnum() or letter in "_-/.") for letter in name)
