"""The documents of ``design`` and of motions near a pose."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

from msgspec import UNSET, UnsetType, field

from .... import __version__
from ....common.schema import Document, Matrix, Vector
from ....estimation.results.parts import Number
from ....estimation.results.payload import VisibilityDocument
from ....model import Motion, Robot
from ....model.inertia import PayloadSpread
from ....model.visibility import PayloadVisibility
from ....trajectories import Design, DesignProblem, Fourier, NearShape, Score, Trapezoid, ViaPoints
from ....trajectories import NearMotion as NearPlan
from ....trajectories.design.floor import Floor
from ....trajectories.design.full_trajectory import Rung
from ....trajectories.design.score import holding_torques
from ....trajectories.motions.family import Plan
from ...export.motion import rests_on


class LimitDocument(Document, frozen=True):
    """How near a motion comes to a limit."""

    name: str
    worst: str
    value: Number
    limit: Number
    violation: Number
    relative: Number
    room: Number


class LimitsDocument(Document, frozen=True):
    """Whether a motion keeps its limits; ``max_violation`` in units of the limit."""

    max_violation: float
    feasible: bool | UnsetType = field(default=UNSET, name="met")
    nearest: tuple[LimitDocument, ...] | UnsetType = UNSET
    torque_checked: bool | UnsetType = UNSET


class PayloadBoundsDocument(Document, frozen=True):
    """Every payload up to a mass in a region of the last link's frame; ``holding``: what brakes hold, N·m or N."""

    mass: float
    region: Literal["ball", "cube"]
    centre: Vector
    axes: Matrix
    holding: Vector = field(name="holding_torque")


class FloorDocument(Document, frozen=True):
    """The best that states within the limits allow, continuity ignored."""

    value: Number = field(name="criterion_value")
    gap: Number
    states: int


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


class DesignDocument(Document, frozen=True):
    """A designed or judged motion: its criterion, what it would teach, its limits, what it assumes of the robot."""

    robot: str
    robot_fingerprint: str
    kind: str = field(name="criterion")
    value: Number = field(name="criterion_value")
    condition_number: Number
    condition_number_scaled: Number
    log_det: Number
    sigma: dict[str, Number] = field(name="predicted_sigma")
    predicted_sigma_percent: dict[str, Number]
    noise: Vector = field(name="torque_noise")
    rate: Number = field(name="independent_rate_hz")
    data_length: Number = field(name="data_length_s")
    duration: float = field(name="duration_s")
    limits: LimitsDocument
    payload_bounds: PayloadBoundsDocument | None
    floor: FloorDocument | None
    evaluated: str | None
    val3_replay: ReplayDocument | None
    assumed: dict[str, str]
    version: str
    seed: int | UnsetType = UNSET
    starts: int | UnsetType = UNSET
    solver: str | UnsetType = UNSET
    evaluations: int | UnsetType = UNSET
    cpu_s: float | UnsetType = UNSET
    interrupted: bool | UnsetType = UNSET
    motion: MotionDocument | UnsetType = UNSET


class NearMotion(Document, frozen=True):
    """A motion near a pose or two; ranges to either side [rad or m]."""

    poses: Matrix
    joints: tuple[int, ...]
    ranges: Vector
    period: float = field(name="period_s")
    repeats: int
    transfer: float = field(name="transfer_s")


class SpreadDocument(Document, frozen=True):
    """Standard deviations to come; null where not visible."""

    mass: Number
    com: Vector
    inertia_com: Matrix


class RungDocument(Document, frozen=True):
    """A run of the ladder: share of the full speed, mass that it bears and largest one after it [kg]."""

    speed: float
    mass: float = field(name="bears_kg")
    bound: float = field(name="bound_kg")
    duration: float = field(name="duration_s")


class NearDocument(Document, frozen=True):
    """A motion near a pose: what it shows of a payload, how well, its limits."""

    robot: str
    kind: str = field(name="criterion")
    near: NearMotion
    visibility: VisibilityDocument
    predicted_sigma: SpreadDocument
    condition_number: Number
    condition_number_scaled: Number
    duration: float = field(name="duration_s")
    rehearsal_s: float
    ladder: tuple[RungDocument, ...] | None
    cpu_s: float
    limits: LimitsDocument
    payload_bounds: PayloadBoundsDocument | None
    assumed: dict[str, str]
    seed: int


class NearResult(NamedTuple):
    """A motion near a pose, and what it will tell of a payload.

    Attributes:
        design: of the series; its score tells the limits.
        shape: what was asked of the motion.
        visibility: what can be seen at all.
        spread: predicted standard deviations, of white noise.
        ladder: the runs up to full speed; none where the motion holds for every payload.
    """

    design: Design
    shape: NearShape
    visibility: PayloadVisibility
    spread: PayloadSpread
    ladder: tuple[Rung, ...] = ()

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.design.problem.robot

    @property
    def motion(self) -> NearPlan:
        """The motion with its repeats and transfers."""
        assert isinstance(self.design.plan, NearPlan)
        return self.design.plan


class JudgedMotion(NamedTuple):
    """A motion with its score.

    Attributes:
        title: of the score's table.
        reference: values that standard deviations are relative to.
        labels: how to call parameters ("ZZ1R"), by their names.
        design: the designed motion; None where one was only judged.
        floor: under the criterion, if it was asked for and found.
        replay: score of what a controller makes of the motion by its own profiles.
        source: file of a motion that was only judged.
    """

    title: str
    score: Score
    motion: Motion
    reference: Mapping[str, float] = {}
    labels: Mapping[str, str] = {}
    design: Design | None = None
    floor: Floor | None = None
    replay: Score | None = None
    source: str | None = None


def design_document(judged: JudgedMotion) -> DesignDocument:
    """Make the document of ``dynident design --json``."""
    score, design, floor, replay = judged.score, judged.design, judged.floor, judged.replay
    problem, learnt, relative = score.problem, score.learnt, score.relative_sigma(dict(judged.reference))
    nearest = tuple(map(LimitDocument.of, score.limits))
    percent = {name: 100.0 * relative[name] if name in relative else None for name in learnt.sigma}
    return DesignDocument.of(
        *(score, learnt, problem, problem.goal, problem.criterion, design),
        robot=problem.robot.name,
        robot_fingerprint=problem.robot.fingerprint,
        predicted_sigma_percent=percent,
        limits=LimitsDocument.of(score, nearest=nearest),
        payload_bounds=_payload_bounds(problem, score),
        floor=FloorDocument.of(floor) if floor else None,
        evaluated=judged.source,
        val3_replay=ReplayDocument.of(replay, replay.learnt) if replay else None,
        assumed=problem.robot.assumed(*rests_on(problem)),
        version=__version__,
        solver="augmented" if design else UNSET,
        motion=_motion(design.plan) if design else UNSET,
    )


def _payload_bounds(problem: DesignProblem, score: Score) -> PayloadBoundsDocument | None:
    if problem.payloads is None:
        return None
    return PayloadBoundsDocument.of(problem.payloads, holding=holding_torques(problem, score.samples.q))


def _motion(plan: Plan) -> MotionDocument:
    if isinstance(plan, ViaPoints):
        ramp = plan.segment.ramp if isinstance(plan.segment, Trapezoid) else None
        return MotionDocument.of(plan, kind="via points", segments=plan.segment.name, ramp=ramp)
    assert isinstance(plan, Fourier)
    return MotionDocument.of(plan, kind="fourier")


def near_document(result: NearResult) -> NearDocument:
    """Make the document of ``dynident near --json``."""
    design, motion, score = result.design, result.motion, result.design.score
    rungs = [RungDocument(rung.speed, rung.mass, rung.bound, rung.motion.duration) for rung in result.ladder]
    return NearDocument.of(
        *(score.learnt, motion, design, design.problem.criterion),
        robot=design.problem.robot.name,
        near=NearMotion.of(result.shape, motion),
        visibility=VisibilityDocument.of(result.visibility),
        predicted_sigma=SpreadDocument.of(result.spread),
        rehearsal_s=motion.slowed(0.1).duration,
        ladder=tuple(rungs) or None,
        limits=LimitsDocument(
            score.max_violation,
            torque_checked=design.problem.torque_limited,
            nearest=tuple(map(LimitDocument.of, score.limits)),
        ),
        payload_bounds=_payload_bounds(design.problem, score),
        assumed=design.problem.robot.assumed(*rests_on(design.problem)),
    )
