"""The documents of ``check`` and ``robot check``."""

from collections.abc import Sequence
from itertools import islice
from typing import NamedTuple

from msgspec import UNSET, UnsetType, field

from ....common.schema import Document
from ....estimation.diagnosis.kinematics import PoseCheck, Readings
from ....estimation.results.parts import Number
from ....model import Pose, Robot
from ...logs.log_check import LogReport, RobotFits


class CheckDocument(Document, frozen=True):
    """A look at several logs of a robot, null where none was named: then ``fits`` tells which shipped ones fit."""

    robot: str | None
    logs: tuple[LogReport, ...]
    fits: tuple[RobotFits, ...] | UnsetType = UNSET


class ReadingDocument(Document, frozen=True):
    """One way to read the joint columns, and the residual it leaves."""

    residual: Number
    order: tuple[int, ...]
    sign: tuple[int, ...]
    zero_deg: tuple[int, ...]
    torque_sign: tuple[int, ...]


class ReadingsDocument(Document, frozen=True):
    """Ways to read the joint columns, best first."""

    unit: str
    as_recorded: Number
    suggested: str | None
    ranked: tuple[ReadingDocument, ...]


class FrameDocument(Document, frozen=True):
    """A frame; null where its axes are not logged."""

    xyz_m: tuple[float, ...]
    rpy_rad: tuple[float, ...] | None


class PoseLogDocument(Document, frozen=True):
    """How well the robot's description gives the tool's poses in one log."""

    source: str = field(name="log")
    reproduced: bool
    rms: float = field(name="rms_m")
    largest: float = field(name="largest_m")
    rms_angle: Number = field(name="rms_angle_rad")
    as_is: float = field(name="as_is_m")
    base: FrameDocument
    tool: FrameDocument
    determined: bool = field(name="base_and_tool_determined")
    readings: ReadingsDocument | None


class RobotCheckDocument(Document, frozen=True):
    """Whether a description agrees with recordings; ways to read them by torques where there are some."""

    robot: str
    poses: tuple[PoseLogDocument, ...]
    unit: str | UnsetType = UNSET
    as_recorded: Number | UnsetType = UNSET
    suggested: str | UnsetType | None = UNSET
    ranked: tuple[ReadingDocument, ...] | UnsetType = UNSET


class Look(NamedTuple):
    """A look at one log: its check, None where no robot fits, and the robots that fit where none was named."""

    path: str
    check: LogReport | None
    fits: RobotFits | None = None


def check_document(robot: Robot | None, looks: Sequence[Look]) -> CheckDocument:
    """Make the document of ``dynident check --json``."""
    fits = tuple(look.fits for look in looks if look.fits)
    logs = tuple(look.check for look in looks if look.check)
    return CheckDocument(robot.name if robot else None, logs, fits or UNSET)


def robot_check_document(robot: Robot, poses: Sequence[PoseCheck], readings: Readings | None) -> RobotCheckDocument:
    """Make the document of ``dynident robot check --json``."""
    logs = (
        PoseLogDocument.of(
            check,
            base=_frame(check.base),
            tool=_frame(check.tool, check.rms_angle is not None),
            readings=_ranked(check.readings),
        )
        for check in poses
    )
    return RobotCheckDocument.of(_ranked(readings), robot=robot.name, poses=tuple(logs))


def _ranked(readings: Readings | None) -> ReadingsDocument | None:
    """Tell the best twenty ways to read the joint columns."""
    if readings is None:
        return None
    ranked = []
    for reading, residual in islice(readings.residuals.items(), 20):
        order, zeros = (column + 1 for column in reading.order), (90 * quarter for quarter in reading.quarters)
        ranked.append(ReadingDocument(residual, tuple(order), reading.sign, tuple(zeros), reading.torque))
    suggested = readings.suggested.described() if readings.suggested else None
    return ReadingsDocument(readings.unit, readings.as_recorded, suggested, tuple(ranked))


def _frame(pose: Pose, axes: bool = True) -> FrameDocument:
    return FrameDocument(pose.origin, pose.rpy if axes else None)
