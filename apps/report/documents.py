"""Documents of answers, as ``--json`` writes them, and their JSON Schema.

Each key is declared once, with the type it is read by. ``python -m dynident.apps.report.documents`` writes schemas.
"""

from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType, field

from ... import __version__
from ...common import Array, Document, Vector
from ...common.files import write_bytes
from ...common.schema import Matrix
from ...estimation import GainsResult, PayloadResult, RobotResult, measurement
from ...estimation.diagnosis.kinematics import PoseCheck, Readings
from ...estimation.equations.observer import Observer, used
from ...estimation.results.parts import Number
from ...estimation.results.payload import VisibilityDocument
from ...estimation.results.robot import Rollout
from ...model import Motion, Recording, Robot
from ...model.base import PayloadVisibility
from ...model.inertia import PayloadSpread
from ...model.motion import Measurement
from ...trajectories import Design, DesignProblem, Floor, Fourier, NearShape, Rung, Score, StaticShape, ViaPoints
from ...trajectories.design.limits import LimitCheck
from ...trajectories.design.score import Learnt, holding_torques, learnt_of, score_motion
from ...trajectories.motions.family import Samples
from ..export.motions import rests_on
from ..fleet.comparing import Compared, Fleet
from ..fleet.reduction import ReducedDocument
from ..logs.log_check import FollowingChange, LogReport, RobotFits

RECORDED, FIGURE_RATE = 250.0, 100.0
"""Hz: samples of a recording that is still to be made, and of a motion in figures."""


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
    along: tuple[int, ...]


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
    """Tool poses of one log beside those of the robot's description."""

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
    """Comparison of a description with recordings; ways to read them by torques where there are some."""

    robot: str
    poses: tuple[PoseLogDocument, ...]
    unit: str | UnsetType = UNSET
    as_recorded: Number | UnsetType = UNSET
    suggested: str | UnsetType | None = UNSET
    ranked: tuple[ReadingDocument, ...] | UnsetType = UNSET


Look = tuple[LogReport | None, RobotFits | None]
"""Check of one log, None where no robot fits, and the robots that fit where none was named."""


def check_document(robot: Robot | None, looks: Sequence[Look]) -> CheckDocument:
    """Make the document of ``dynident check --json``."""
    logs, fits = (tuple(filter(None, part)) for part in zip(*looks, strict=True))
    return CheckDocument(robot.name if robot else None, logs, fits or UNSET)


def robot_check_document(robot: Robot, poses: Sequence[PoseCheck], readings: Readings | None) -> RobotCheckDocument:
    """Make the document of ``dynident robot check --json``."""

    def ranked(readings: Readings | None) -> ReadingsDocument | None:
        if readings is None:
            return None
        best = []
        for reading, residual in islice(readings.residuals.items(), 20):
            order, zeros = tuple(k + 1 for k in reading.order), tuple(90 * quarter for quarter in reading.quarters)
            best.append(ReadingDocument(residual, order, reading.sign, zeros, reading.torque, reading.along))
        suggested = readings.suggested.described() if readings.suggested else None
        return ReadingsDocument(readings.unit, readings.as_recorded, suggested, tuple(best))

    logs = []
    for check in poses:
        base = FrameDocument(check.base.origin, check.base.rpy)
        tool = FrameDocument(check.tool.origin, check.tool.rpy if check.rms_angle is not None else None)
        logs.append(PoseLogDocument.of(check, base=base, tool=tool, readings=ranked(check.readings)))
    return RobotCheckDocument.of(ranked(readings), robot=robot.name, poses=tuple(logs))


class LimitsDocument(Document, frozen=True):
    """Limits of a motion, met or not; ``max_violation`` in units of the limit."""

    max_violation: float
    feasible: bool | UnsetType = field(default=UNSET, name="met")
    nearest: tuple[LimitCheck, ...] | UnsetType = UNSET
    torque_checked: bool | UnsetType = UNSET


class PayloadBoundsDocument(Document, frozen=True):
    """Every payload up to a mass in a region of the last link's frame; ``holding``: what brakes hold, N·m or N."""

    mass: float
    region: Literal["ball", "cube"]
    centre: Vector
    axes: Matrix
    holding: Vector = field(name="holding_torque")


class ReplayDocument(Document, frozen=True):
    """A motion as a controller's own profiles between the via points make it."""

    value: Number = field(name="criterion_value")
    condition_number: Number
    condition_number_scaled: Number
    duration: float = field(name="duration_s")
    feasible: bool = field(name="limits_met")
    violations: tuple[str, ...]


class MotionDocument(Document, frozen=True):
    """Via points with times [s], or a Fourier series; rad or m, one column for each joint."""

    kind: Literal["via points", "fourier"]
    points: Matrix | UnsetType = UNSET
    durations: Vector | UnsetType = UNSET
    speeds: Matrix | UnsetType | None = UNSET
    accelerations: Matrix | UnsetType | None = UNSET
    segments: str | UnsetType = UNSET
    ramp: Number | UnsetType = UNSET
    offset: Vector | UnsetType = UNSET
    a: Matrix | UnsetType = UNSET
    b: Matrix | UnsetType = UNSET
    period: float | UnsetType = UNSET


class _MotionAnswer(Document, frozen=True, kw_only=True):
    """Robot, criterion and limits of a motion, and what it assumes."""

    robot: str
    kind: str = field(name="criterion")
    condition_number: Number
    condition_number_scaled: Number
    duration: float = field(name="duration_s")
    limits: LimitsDocument
    payload_bounds: PayloadBoundsDocument | None
    assumed: dict[str, str]
    noise: Vector = field(name="torque_noise")
    rate: Number = field(name="independent_rate_hz")
    noise_from: str = field(name="torque_noise_from")

    @classmethod
    def made(cls, problem: DesignProblem, score: Score, *sources: Any, **more: Any) -> Self:
        """Take fields from the sources and from the problem; payloads and assumptions are the problem's."""
        robot, bounds = problem.robot, None
        if problem.payloads is not None:
            bounds = PayloadBoundsDocument.of(problem.payloads, holding=holding_torques(problem, score.samples.q))
        more |= {"robot": robot.name, "payload_bounds": bounds, "assumed": robot.assumed(*rests_on(problem))}
        return cls.of(*sources, problem, problem.goal, problem.criterion, **more)


class DesignDocument(_MotionAnswer, frozen=True, kw_only=True):
    """A designed or judged motion: its criterion, what it would teach, its limits, what it assumes of the robot."""

    robot_fingerprint: str
    value: Number = field(name="criterion_value")
    log_det: Number
    sigma: dict[str, Number] = field(name="predicted_sigma")
    predicted_sigma_percent: dict[str, Number]
    data_length: Number = field(name="data_length_s")
    floor: Floor | None
    evaluated: str | None
    val3_replay: ReplayDocument | None
    version: str
    seed: int | UnsetType = UNSET
    starts: int | UnsetType = UNSET
    solver: str | UnsetType = UNSET
    evaluations: int | UnsetType = UNSET
    cpu_s: float | UnsetType = UNSET
    interrupted: bool | UnsetType = UNSET
    motion: MotionDocument | UnsetType = UNSET


class NearMotion(Document, frozen=True):
    """A motion near a pose or two, with ranges to either side, or poses at rest, each held after small moves.

    Ranges and moves in rad or m.
    """

    poses: Matrix
    joints: tuple[int, ...]
    ranges: Vector | UnsetType = UNSET
    period: float | UnsetType = field(default=UNSET, name="period_s")
    repeats: int | UnsetType = UNSET
    transfer: float | UnsetType = field(default=UNSET, name="transfer_s")
    approach: Vector | UnsetType = UNSET
    hold: float | UnsetType = field(default=UNSET, name="hold_s")


class NearDocument(_MotionAnswer, frozen=True, kw_only=True):
    """A motion near a pose, or poses at rest: what they show of a payload, how well, their limits."""

    near: NearMotion | UnsetType = UNSET
    static: NearMotion | UnsetType = UNSET
    visibility: VisibilityDocument
    predicted_sigma: PayloadSpread
    rehearsal_s: float | UnsetType = UNSET
    ladder: tuple[Rung, ...] | None
    cpu_s: float
    seed: int


def as_recorded(problem: DesignProblem, data: Measurement) -> Learnt:
    """Information of a motion as ``identify`` will see it: decimated, and without rows of joints that are slow."""
    motion, processing = data.motion, problem.robot.processing
    W = Observer(problem.robot, problem.names).observe(*used(data, processing)).W
    part = processing.thinning(motion.rate) / len(motion.t)
    return learnt_of(problem, W, [np.full(len(own), part) for own in W], float(motion.t[-1] - motion.t[0]))


def planned(robot: Robot, motion: Motion, source: str = "planned") -> Measurement:
    """A motion as a recording of it will be filtered, without torques."""
    return measurement(Recording(motion.t, motion.q, 0.0 * motion.q, None, source), robot.processing)


class NearResult(NamedTuple):
    """A motion near a pose or at rest: what it shows of a payload, and slower runs that go before it."""

    design: Design
    shape: NearShape | StaticShape
    visibility: PayloadVisibility
    spread: PayloadSpread
    ladder: tuple[Rung, ...] = ()

    @property
    def poses(self) -> Array:
        """Poses about which it moves, or in which it rests [rad or m], K x n."""
        plan = self.design.plan
        return plan.held[::2] if isinstance(plan, ViaPoints) else self.shape.poses


class JudgedMotion(NamedTuple):
    """A motion with its score."""

    title: str
    score: Score
    motion: Motion
    learnt: Learnt  # as a recording of it will show it
    reference: Mapping[str, float] = {}  # values that standard deviations are relative to
    labels: Mapping[str, str] = {}  # how to call parameters ("ZZ1R"), by their names
    design: Design | None = None  # None where a motion was only judged
    floor: Floor | None = None
    replay: Score | None = None  # of what a controller makes of the motion by its own profiles
    source: str | None = None  # file of a motion that was only judged

    @classmethod
    def of(cls, design: Design) -> Self:
        """Judge a designed motion."""
        robot, motion = design.problem.robot, design.motion(FIGURE_RATE)
        learnt = as_recorded(design.problem, planned(robot, design.motion(RECORDED)))
        return cls(f"Motion of {robot.title or robot.name}", design.score, motion, learnt, design=design)


def design_document(judged: JudgedMotion) -> DesignDocument:
    """Make the document of ``dynident design --json``."""
    score, design, replay = judged.score, judged.design, judged.replay
    problem, learnt, relative = score.problem, judged.learnt, judged.learnt.relative_sigma(judged.reference)
    percent = {name: 100.0 * relative[name] if name in relative else None for name in learnt.sigma}
    motion: MotionDocument | UnsetType = UNSET
    match design and design.plan:
        case ViaPoints() as plan:
            ramp = getattr(plan.segment, "ramp", None)
            motion = MotionDocument.of(plan, kind="via points", segments=plan.segment.name, ramp=ramp)
        case Fourier() as plan:
            motion = MotionDocument.of(plan, kind="fourier", offset=plan.offset[0], a=plan.a[0], b=plan.b[0])
    return DesignDocument.made(
        *(problem, score, score, learnt, design, judged),
        robot_fingerprint=problem.robot.fingerprint,
        noise_from=problem.goal.noise_source,
        predicted_sigma_percent=percent,
        limits=LimitsDocument.of(score, nearest=score.limits),
        evaluated=judged.source,
        val3_replay=ReplayDocument.of(replay, replay.learnt) if replay else None,
        version=__version__,
        solver="augmented" if design else UNSET,
        motion=motion,
    )


def near_document(result: NearResult) -> NearDocument:
    """Make the document of ``dynident near --json``."""
    design, shape, plan = result.design, result.shape, result.design.plan
    problem, score = design.problem, design.score
    if isinstance(plan, Fourier):
        learnt = as_recorded(problem, planned(problem.robot, design.motion(RECORDED)))
        kind: dict[str, Any] = {"near": NearMotion.of(shape, plan), "rehearsal_s": plan.slowed(0.1).duration}
    else:
        learnt = score_motion(problem, Samples.at_rest(result.poses)).learnt
        kind = {"static": NearMotion.of(result, shape)}
    return NearDocument.made(
        *(problem, score, learnt, plan, design),
        **kind,
        noise_from=problem.goal.noise_source,
        visibility=VisibilityDocument.of(result.visibility),
        predicted_sigma=result.spread,
        ladder=result.ladder or None,
        limits=LimitsDocument(score.max_violation, torque_checked=problem.torque_limited, nearest=score.limits),
    )


class RolloutsDocument(Document, frozen=True):
    """Open loop and replay on each recording."""

    robot: str
    rollouts: tuple[Rollout, ...]


DOCUMENTS: dict[str, type[Document]] = {
    "identify": RobotResult,
    "payload": PayloadResult,
    "weigh": PayloadResult,
    "gains": GainsResult,
    "design": DesignDocument,
    "near": NearDocument,
    "rollout": RolloutsDocument,
    "fleet_report": Fleet,
    "fleet_reduce": ReducedDocument,
    "compare": Compared,
    "check": CheckDocument,
    "verify": FollowingChange,
    "robot_check": RobotCheckDocument,
}
"""Each command's document by the command's name."""


def schema_text(name: str) -> bytes:
    """The JSON Schema of a command's document, as its file holds it."""
    text = msgspec.json.encode(msgspec.json.schema(DOCUMENTS[name], schema_hook=lambda _: {}), order="sorted")
    return msgspec.json.format(text, indent=1) + b"\n"


if __name__ == "__main__":
    for command in DOCUMENTS:
        write_bytes(Path(__file__).parents[2] / "docs" / "schemas" / f"{command}.schema.json", schema_text(command))
