"""Where the links stand at the zero position, in the frames of the robot's own file if it has one."""

from ....model import Pose, Robot
from ....model.frames import step


def own_frame(robot: Robot, number: int) -> Pose:
    """The link's frame in modified DH frame ``number``; the base's in frame 0."""
    if number == 0:
        return robot.base
    return robot.links.poses[number - 1] if robot.links is not None else Pose()


def in_parent(robot: Robot, j: int) -> Pose:
    """Link j + 1 in the link before."""
    return joint_in_parent(robot, j) @ own_frame(robot, j + 1)


def joint_in_parent(robot: Robot, j: int) -> Pose:
    """Modified DH frame j + 1, whose z is the joint's axis, in the link before."""
    along_x, along_z = step(robot.joints[j], 0.0)
    return own_frame(robot, j).inverse() @ along_x @ along_z


def axis(robot: Robot, j: int) -> list[float]:
    """Direction of the joint's axis in link j + 1, which stands on it; shape (3,)."""
    return [float(value) for value in own_frame(robot, j + 1).R[2]]


def flange(robot: Robot) -> Pose:
    """The payload's frame in the last link."""
    return own_frame(robot, robot.n).inverse() @ robot.flange


def gravity(robot: Robot) -> list[float]:
    """Acceleration of gravity in the base's frame [m/s^2], shape (3,)."""
    return [float(value) + 0.0 for value in robot.base.R.T @ list(robot.gravity)]


def flange_name(robot: Robot) -> str:
    """Name of the flange's frame."""
    return robot.links.tip if robot.links is not None else "flange"
