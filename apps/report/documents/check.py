"""The documents of ``check``, ``verify`` and ``robot check``."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

from msgspec import UNSET, UnsetType, field, structs

from ....common.schema import Document
from ....estimation.diagnosis.kinematics import KinematicsCheck, PoseCheck
from ....model import Pose, Robot
from ...logs.following import FollowingChange
from ...logs.log_check import Excited, JointFacts, LogCheck, RobotFits, TimeFacts
from ...results.parts import Number


class FindingDocument(Document, frozen=True):
    """Something that speaks against a log, or is worth knowing."""

    severity: Literal["error", "warning", "note"]
    text: str = field(name="words")


class LogDocument(Document, frozen=True):
    """A look at one log."""

    source: str
    notes: tuple[str, ...]
    currents: bool
    usable: bool
    findings: tuple[FindingDocument, ...]
    time: TimeFacts | None
    joints: tuple[JointFacts, ...]
    excitation: tuple[Excited, ...]
    relative_residual: Number
    condition_number_scaled: Number


class FitDocument(Document, frozen=True):
    """A shipped robot that a log can be of, and what its model leaves of the torque."""

    robot: str
    residual: Number


class FitsDocument(Document, frozen=True):
    """Shipped robots beside a log of which none was named; ``fault``: why none fits, null where one does."""

    source: str
    columns: tuple[str, ...]
    fitting: tuple[FitDocument, ...]
    others: tuple[str, ...]
    fault: str | None


class CheckDocument(Document, frozen=True):
    """A look at several logs of a robot, null where none was named: then ``fits`` tells which shipped ones fit."""

    robot: str | None
    logs: tuple[LogDocument, ...]
    fits: tuple[FitsDocument, ...] | UnsetType = UNSET


class ChangeDocument(Document, frozen=True):
    """Root mean square before and after, and by what share it fell, with 95 % interval."""

    name: str
    before: float
    after: float
    fall: Number
    interval: tuple[Number, Number]
    clear: str


class FollowingDocument(Document, frozen=True):
    """What the controller missed before and after a payload was entered."""

    kind: str = field(name="compared")
    tells: bool
    lag: float = field(name="lag_s")
    joints: tuple[ChangeDocument, ...]
    total: ChangeDocument = field(name="all")


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

    log: str
    reproduced: bool
    rms: float = field(name="rms_m")
    largest_m: float
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
    check: LogCheck | None
    fits: RobotFits | None = None


class PoseLook(NamedTuple):
    """A log with tool poses: what forward kinematics leaves, and readings where that is much."""

    source: str
    check: PoseCheck
    readings: KinematicsCheck | None = None

    @property
    def wrong_unit(self) -> str:
        """The unit that the positions seem to be in; empty where theirs is plausible."""
        for factor, words in ((1e3, "mm that are read as m"), (1e-3, "m that are read as mm")):
            if 0.3 < self.check.scale / factor < 3.0:
                return words
        return ""


def check_document(robot: Robot | None, looks: Sequence[Look]) -> CheckDocument:
    """Make the document of ``dynident check --json``."""
    logs = (
        LogDocument.of(
            look.check,
            source=look.check.recording.source,
            notes=tuple(look.check.recording.notes),
            findings=tuple(map(FindingDocument.of, look.check.findings)),
        )
        for look in looks
        if look.check
    )
    fits = tuple(_fits(look.path, look.fits) for look in looks if look.fits)
    return CheckDocument(robot.name if robot else None, tuple(logs), fits or UNSET)


def _fits(path: str, fits: RobotFits) -> FitsDocument:
    fitting = tuple(FitDocument(fit.robot, fit.residual) for fit in fits.fitting)
    return FitsDocument(path, fits.columns, fitting, tuple(name for name, _ in fits.others), fits.fault or None)


def following_document(change: FollowingChange) -> FollowingDocument:
    """Make the document of ``dynident verify --json``."""
    joints = tuple(map(ChangeDocument.of, change.joints))
    return FollowingDocument.of(change, joints=joints, total=ChangeDocument.of(change.total))


def readings_document(check: KinematicsCheck) -> ReadingsDocument:
    """The best twenty ways to read the joint columns."""
    ranked = (
        ReadingDocument(
            entry.residual,
            tuple(column + 1 for column in entry.reading.order),
            entry.reading.sign,
            tuple(90 * quarter for quarter in entry.reading.quarters),
            entry.reading.torque,
        )
        for entry in check.ranked[:20]
    )
    suggested = check.suggested.reading.described() if check.suggested else None
    return ReadingsDocument(check.unit, check.as_recorded.residual, suggested, tuple(ranked))


def pose_document(look: PoseLook) -> PoseLogDocument:
    """The comparison of one log's tool poses with forward kinematics."""
    check = look.check
    return PoseLogDocument.of(
        check,
        log=look.source,
        largest_m=check.errors.max(),
        base=_frame(check.base),
        tool=_frame(check.tool, check.angles is not None),
        readings=readings_document(look.readings) if look.readings else None,
    )


def robot_check_document(
    robot: Robot, poses: Sequence[PoseLogDocument], check: KinematicsCheck | None
) -> RobotCheckDocument:
    """Make the document of ``dynident robot check --json``."""
    ranked = structs.asdict(readings_document(check)) if check else {}
    return RobotCheckDocument(robot.name, tuple(poses), **ranked)


def _frame(pose: Pose, axes: bool = True) -> FrameDocument:
    return FrameDocument(pose.origin, pose.rpy if axes else None)
