"""A look at logs: what one holds, which of the shipped robots it can be of, what a controller missed in two.

A payload that is right lets the controller predict more of the torque, so that less is left to its feedback: the
following error falls. The torque itself does not tell: the same motion needs the same one.
"""

import dataclasses
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Any, Literal

import numpy as np
from msgspec import field
from msgspec.structs import replace

from ...common import Array, Document, InputError, Speaks
from ...estimation import Equations, Settings, measurement, weighted
from ...estimation.diagnosis import engine, scales, verdict
from ...estimation.diagnosis.evidence import Evidence, Finding, Severity, error, note, warning
from ...estimation.fit import covariance, own_equations
from ...estimation.payload.long_motion import Source
from ...estimation.results.parts import Number, ParameterDocument
from ...estimation.signals.filtering import aligned, moving_parts
from ...estimation.signals.recordings import cut, implausible, out_of_range, pieces, still_joints
from ...model import Motion, Processing, Recording, Robot, base_parameters, load_robot, robot_names
from .columns import Naming, choose
from .map import LogMap
from .read import LogPath, named, open_log, read_beside, read_recording, read_recordings

_JITTER = 0.02  # of the mean step
_COARSE = 0.02  # torque step over the torque's range
_UNSURE = 30.0  # percent: relative sigma of a parameter that is hardly seen
_WHOLE = 0.05  # of a step: closer differences are whole multiples of it
_MOST_LEVELS = 200_000  # distinct values that are sorted to find a step
_GAIN = 10.0  # N·m/A: a usual gain makes a current a torque of about the right size
_BLOCK = 1.0  # s: errors of neighbouring samples are alike
_FEWEST = 4  # blocks
_MOVES = 1e-2  # rad or m: a joint that spans less is held
_MISMATCH = 0.05  # rad or m: by more positions of one and the same motion do not differ
Missed = Literal["following error", "unpredicted torque", "torque"]
"""Commanded less measured position; measured torque less that which the controller predicted; the torque itself,
where the log holds neither."""
_Clear = Literal["fell", "rose", "no clear change"]
Following = tuple[Missed, Recording]
"""Errors that a controller left, in the place of torques [rad or m, N·m or N], and which."""


class TimeFacts(Document, frozen=True):
    """Time of a recording [s]."""

    samples: int
    duration: float  # from the first to the last
    rate: float  # mean [Hz]
    steps: tuple[float, float]  # shortest and longest
    jitter: float  # standard deviation of the steps over their mean
    moving: tuple[float, float] | None  # first and last moment of the motion that is used; None without motion


class JointFacts(Document, frozen=True):
    """One joint's signals: smallest and largest position [rad or m] and torque [N·m, N, or A]."""

    moves: bool
    position: tuple[float, float]
    speed: float  # largest, from filtered positions or speeds
    torque: tuple[float, float]
    position_step: float  # smallest difference of two values; 0 where none shows
    torque_step: float
    saturated: float  # share of the samples at the torque's own extreme


class Remark(Document, frozen=True):
    """Something that speaks against a log, or is worth knowing."""

    severity: Severity
    text: str = field(name="words")


class LogReport(Speaks, Document, frozen=True, kw_only=True, dict=True):
    """Contents and faults of a log; ``working``: the robot, and the log's signals in SI units, joint side."""

    source: str
    notes: tuple[str, ...]
    currents: bool  # its torques are currents [A], of unknown gain
    usable: bool = True  # nothing speaks against using it as it is
    findings: tuple[Remark, ...] = ()  # worst first
    time: TimeFacts | None = None  # None where it is too short to be filtered
    joints: tuple[JointFacts, ...] = ()
    excitation: tuple[ParameterDocument, ...] = ()  # by base parameter; empty where they cannot be estimated
    relative_residual: Number = None  # of the robot's model on this log; None without it
    condition_number_scaled: Number = None  # of the observation matrix, columns scaled to norm 1

    @property
    def headline(self) -> str:
        """The robot, the log, and what was found in a line."""
        counts = [sum(remark.severity == kind for remark in self.findings) for kind in ("error", "warning")]
        summary = f"{counts[0]} errors, {counts[1]} warnings" if any(counts) else "nothing to fix"
        robot = f"{self.working[0].name}, " if self.working is not None else ""
        return f"{robot}{self.source}, {summary}"

    def completed(self, findings: Iterable[Finding], **facts: Any) -> "LogReport":
        """Add findings, the worst first, and facts."""
        order: tuple[Severity, ...] = ("error", "warning", "note")
        more = (Remark(finding.severity, finding.text) for finding in findings)
        ranked = sorted((*self.findings, *more), key=lambda remark: order.index(remark.severity))
        usable = not any(remark.severity == "error" for remark in ranked)
        return replace(self, findings=tuple(ranked), usable=usable, **facts).made_by(self.working)


def check_log(
    robot: Robot, recording: Recording, processing: Processing | None = None, currents: bool = False
) -> LogReport:
    """Look at a recording, which may be wrong in any way; its torques may be ``currents`` [A] of unknown gain."""
    processing = processing or robot.processing
    check = LogReport(source=recording.source, notes=tuple(recording.notes), currents=currents)
    check = check.made_by((robot, recording)).completed(map(error, out_of_range(robot, recording)))
    try:
        motion = measurement(recording, processing).motion
    except InputError as refusal:
        return check.completed([error(str(refusal))])
    t, steps, moving = recording.t, np.diff(recording.t), motion.t[moving_parts(motion, processing.still_speed)]
    mean, span = float(steps.mean()), _range(moving) if moving.size else None
    time = TimeFacts(len(t), float(t[-1] - t[0]), 1.0 / mean, _range(steps), float(steps.std()) / mean, span)
    still = still_joints([recording])
    joints = tuple(
        JointFacts(
            moves=j not in still,
            position=_range(q),
            speed=float(np.abs(speed).max()),
            torque=_range(torque),
            position_step=smallest_step(q),
            torque_step=smallest_step(torque),
            saturated=float(max((torque == torque.max()).mean(), (torque == torque.min()).mean())),
        )
        for j, (q, torque, speed) in enumerate(zip(recording.q.T, recording.torque.T, motion.qd.T, strict=True), 1)
    )
    found = list[Finding]()
    if span is None:
        found.append(error("No joint ever moves: record a motion of every joint"))
    if time.jitter > _JITTER:
        between = "from {:.3g} to {:.3g} ms".format(*(1e3 * step for step in time.steps))
        found.append(note(f"Time steps vary {between}: the log is resampled to an even rate before filtering"))
    if 0 < len(still) < robot.n:
        resting = ", ".join(map(str, still))
        found.append(warning(f"Joint {resting} never moves: its parameters cannot be identified"))
    quantity, unit = ("current", "A") if currents else ("torque", "N·m")
    for j, joint in enumerate(joints, 1):
        width = joint.torque[1] - joint.torque[0]
        if width > 0.0 and joint.torque_step > _COARSE * width:
            coarse = f"{joint.torque_step:.3g} {unit}, {100 * joint.torque_step / width:.0f} % of its range"
            found.append(warning(f"The {quantity} of joint {j} has a resolution of only {coarse}"))
    check = check.completed(found, time=time, joints=joints)
    if check.usable and (mistake := _mistake(robot, recording, currents)):
        check = check.completed([error(mistake)])
    if not check.usable:
        return check
    source = Source((), (recording,), processing)
    nominal = scales.nominal_gravity(robot, engine.states_of(source, engine.BLOCKS)) if currents else None
    if nominal is not None and np.isfinite(nominal.ratio).any():
        ratios = {j: ratio for j, ratio in enumerate(nominal.ratio.tolist(), 1) if np.isfinite(ratio)}
        gains = ", ".join(f"{1.0 / ratio:.3g} at joint {j}" for j, ratio in ratios.items())
        bodies = f"assumed: {nominal.assumed}" if nominal.assumed else "as described"
        text = f"From the weight of the links ({bodies}) the drive gains are about {gains} (N·m or N per unit)"
        more = "within a factor of two; 'dynident gains' finds them from a known payload"
        check = check.completed([note(f"{text}, {more}")])
    # What the robot's model says of the log.
    robot = robot if currents else own_equations.with_friction(robot, [recording], Settings(processing))[0].robot
    try:
        recording, equations = _reduced(robot, recording, processing, currents)
        estimate = weighted(equations)
        evidence = Evidence(robot, source._replace(unloaded=(recording,)), parameters=estimate)
        told = verdict.robot_verdict(evidence, currents).findings
    except InputError as refusal:
        return check.completed([warning(f"The robot cannot be identified from this log alone: {refusal}")])
    found = [finding._replace(text=f"{finding.text[:1].upper()}{finding.text[1:]}") for finding in told]
    sigmas = estimate.relative_sigma_percent
    if unsure := int((~(sigmas < _UNSURE)).sum()):
        text = f"{unsure} of {len(sigmas)} base parameters are uncertain by more than {_UNSURE:.0f} % from this log"
        advice = "Small ones always are; for the others, move faster and over a wider range"
        found.append(note(f"{text} alone. {advice}"))
    seen = zip(base_parameters(robot).names, estimate.values.tolist(), sigmas.tolist(), strict=True)
    return check.completed(
        found,
        excitation=tuple(ParameterDocument(x, name, relative_sigma_percent=sigma) for name, x, sigma in seen),
        relative_residual=estimate.fit.relative,
        condition_number_scaled=equations.condition_numbers()[1],
    )


def _range(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def smallest_step(values: Array) -> float:
    """Find the smallest difference of two different values: the quantum of coarse numbers; 0 without one.

    Numbers count as quantised if all their differences are whole multiples of the smallest one.
    """
    levels = np.unique(values[:_MOST_LEVELS])
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * max(float(np.abs(levels).max()), 1e-300)]
    if gaps.size < 2:
        return 0.0
    multiples = (levels - levels[0]) / gaps.min()
    return float(gaps.min()) if np.abs(multiples - np.rint(multiples)).max() < _WHOLE else 0.0


def longest(recordings: Sequence[Recording]) -> Recording:
    """The one of several pieces that lasts longest."""
    return max(recordings, key=lambda piece: float(piece.t[-1] - piece.t[0]))


def _mistake(robot: Robot, recording: Recording, currents: bool) -> str | None:
    """Say why the recording would be refused by any command; the size of a current says nothing."""
    scaled = dataclasses.replace(recording, torque=_GAIN * recording.torque) if currents else recording
    return next(implausible(robot, scaled), None)


def _reduced(
    robot: Robot, recording: Recording, processing: Processing, currents: bool
) -> tuple[Recording, Equations]:
    """Reduce one recording to equations; currents first become torques in one unknown unit."""
    if currents and robot.coupling is None and robot.spring is None:
        states = engine.States.of(recording, processing)
        recording = dataclasses.replace(recording, torque=recording.torque / engine.relative_scales(robot, states))
    return recording, own_equations.base_problem(
        own_equations.payload_observer(robot), [recording], Settings(processing), check=False
    )


class RobotFit(Document, frozen=True):
    """A shipped robot that a log can be of; ``residual``: what its model leaves of the torque, if that is known."""

    robot: str
    residual: float | None


class RobotFits(Document, frozen=True):
    """Shipped robots beside a log of which none was named."""

    source: str
    columns: tuple[str, ...]  # of the log
    fitting: tuple[RobotFit, ...]  # robots that it can be of, the likeliest first
    others: tuple[str, ...]  # those with as many joints that do not fit
    fault: str | None  # why it is no robot's; None where some fit


def robot_fits(path: LogPath, log_map: LogMap | None = None) -> RobotFits:
    """Try all shipped robots on a log."""
    log_map = log_map or LogMap()
    raw = open_log(path, log_map)
    read = dict[object, Recording | str]()  # read once for robots of the same columns
    fitting, others, faults = list[RobotFit](), dict[str, str](), list[str]()
    for robot in map(load_robot, robot_names()):
        try:
            log_map.check(robot.n)
            naming = Naming(raw, log_map, robot)
            currents = naming.holds_currents_only
            gains = [1.0] * robot.n if currents else None
            columns, _ = choose(naming, gains)
            key = tuple(columns.items()), robot.coupling if currents else None
            if key not in read:
                try:
                    read[key] = longest(read_recordings(path, robot, gains, log_map))
                except InputError as refusal:
                    read[key] = str(refusal)
            if isinstance(recording := read[key], str):
                raise InputError(recording)
        except InputError as refusal:
            faults.append(str(refusal))
            continue
        if mistake := _mistake(robot, recording, currents):
            others[robot.name] = mistake
            continue
        left = None
        with suppress(InputError):  # too little motion
            left = weighted(_reduced(robot, recording, robot.processing, currents)[1]).fit.relative
        fitting.append(RobotFit(robot.name, left))
    fitting.sort(key=lambda fit: (fit.residual is None, fit.residual or 0.0))
    fault = next((f"{raw.path}: {mistake}" for mistake in others.values() if not fitting), None)
    if not fitting and not others:
        # What most robots' columns meet; faults of the file come before those of the number of joints.
        fault = min(faults, key=lambda text: ("missing" in text or "joints" in text, -faults.count(text)))
    return RobotFits(str(raw.path), raw.names, tuple(fitting), tuple(others), fault)


class Change(Document, frozen=True):
    """Root mean square of a joint, or of all, before and after, and by what share it fell, with 95 % interval.

    ``clear`` tells on which side of zero the interval lies.
    """

    name: str
    before: float
    after: float
    fall: float
    interval: tuple[float, float]
    clear: _Clear


class FollowingChange(Document, frozen=True):
    """Following errors before and after a payload was entered: the document of ``verify --json``."""

    kind: Missed = field(name="compared")
    tells: bool  # it shows anything of the number entered
    lag: float = field(name="lag_s")  # what the second recording's clock shows more [s]
    joints: tuple[Change, ...]  # those that move
    total: Change = field(name="all")  # all of them


def read_following(
    path: LogPath, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Following:
    """Read a log with what the controller wanted beside the usual columns.

    By standard names: ``qref1..n`` in the unit of the positions, or ``tauref1..n`` in N·m or N; else those that the
    log map names by ``position_reference`` or ``torque_reference``.
    """
    naming = named(path, robot, log_map)
    kinds: dict[str, Missed] = {"position_reference": "following error", "torque_reference": "unpredicted torque"}
    for quantity, kind in kinds.items():
        names = naming.columns(quantity)
        there = [name for name in names if name in naming.raw.names]
        if not there and not getattr(naming.log_map, quantity):
            continue
        if missing := [name for name in names if name not in there]:
            beside = f", but {there[0]} is there: record it for every joint" if there else ""
            raise InputError(f"{naming.raw.path}: no column {', '.join(missing)}{beside}")
        recording, wanted = read_beside(naming, drive_gains, quantity)
        missed = wanted - recording.q if quantity == "position_reference" else recording.torque - wanted
        recording = dataclasses.replace(recording, torque=missed, qd=None, fingerprint="")
        rows, notes = pieces(recording.t, robot.processing.cutoff, recording.source)
        if len(rows) > 1:
            raise InputError(f"{naming.raw.path}: {notes[-1]}: give a log without gaps")
        return kind, next(cut(recording, rows, notes))
    return "torque", read_recording(path, robot, drive_gains, log_map)


def following_change(before: Following, after: Following, still_speed: float = 2e-3) -> FollowingChange:
    """Compare what was missed on one and the same motion, with the old number in the controller and the new one.

    A joint below ``still_speed`` [rad/s or m/s] stands still.
    """
    (kind, old), (new_kind, new) = before, after
    if kind != new_kind:
        held = f"{old.source} holds the {kind}, {new.source} the {new_kind}"
        raise InputError(f"{held}: log the same columns in both")
    pair = aligned(old, new, None, _MISMATCH)
    t, q, joints, block = pair.loaded.t, pair.loaded.q, list[int](), np.zeros(0, dtype=np.int_)
    if len(t) > 1:
        qd: Array = np.gradient(q, t, axis=0)
        moving = moving_parts(Motion(t, q, qd, np.zeros_like(qd)), still_speed)
        spans = q[moving].max(axis=0, initial=-np.inf) - q[moving].min(axis=0, initial=np.inf)
        joints = np.flatnonzero(spans > _MOVES).tolist()
        block = np.searchsorted(np.arange(t[0], t[-1], _BLOCK), t[moving], side="right")
    if not joints or len(np.unique(block)) < _FEWEST:
        raise InputError(f"{new.source}: less than {_FEWEST} s of common motion: give the whole recordings")
    squares = [np.square(recording.torque[moving]) for recording in (pair.unloaded, pair.loaded)]

    def change(name: str, joints: list[int]) -> Change:
        """Share by which the root mean square fell; the interval by leaving out blocks of time."""
        sums = np.array([[own[:, joints][block == b].sum() for own in squares] for b in np.unique(block)])
        total, count = sums.sum(axis=0), len(sums)
        if not (total > 0.0).all():
            raise InputError(f"{name}: nothing was missed at all: the reference is the measurement itself")
        logs = 0.5 * np.diff(np.log(np.vstack([total, total - sums])))[:, 0]
        half = covariance.student95(count - 1) * np.sqrt((count - 1.0) * np.var(logs[1:]))
        low, fall, high = (1.0 - np.exp(logs[0] + half * np.array([1.0, 0.0, -1.0]))).tolist()
        clear: _Clear = "fell" if low > 0.0 else "rose" if high < 0.0 else "no clear change"
        old_rms, new_rms = np.sqrt(total / (len(block) * len(joints))).tolist()
        return Change(name, old_rms, new_rms, fall, (low, high), clear)

    each = tuple(change(f"joint {j + 1}", [j]) for j in joints)
    return FollowingChange(kind, kind != "torque", pair.lag, each, change("all joints", joints))
