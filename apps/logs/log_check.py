"""A look at one log before anything is identified from it, and which of the shipped robots it can be of."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.speech import Speaks
from ...estimation.diagnosis.finding import Finding, error, note, warning
from ...estimation.diagnosis.verdict import robot_verdict
from ...estimation.equations.equations import Equations
from ...estimation.fit.least_squares import weighted
from ...estimation.fit.own_equations import base_problem
from ...estimation.gains.current_side import relative_scales
from ...estimation.payload.problem import Source
from ...estimation.signals.filtering import measurement
from ...estimation.signals.plausibility import implausible, position_range, still_joints
from ...estimation.signals.rows import moving_parts
from ...model import Processing, Recording, Robot, base_parameters, load_robot, robot_names
from .columns import Naming, choose
from .map import LogMap
from .read import open_log, read_recordings
from .table import RawLog

_JITTER = 0.02  # of the mean step
_COARSE = 0.02  # torque step over the torque's range
_UNSURE = 30.0  # percent: relative sigma of a parameter that is hardly seen
_MOVES = 1e-3  # rad
_UNEVEN = 0.05  # of the mean step: larger deviations are jitter
_WHOLE = 0.05  # of a step: closer differences are whole multiples of it
_MOST_LEVELS = 200_000  # distinct values that are sorted to find a step
_GAIN = 10.0  # N·m/A: a usual gain makes a current a torque of about the right size


@dataclass(frozen=True)
class TimeFacts:
    """Time of a recording.

    Attributes:
        duration: from the first to the last [s].
        rate: mean [Hz].
        steps: shortest and longest [s].
        jitter: standard deviation of the steps over their mean.
        moving: first and last moment of the motion that is used [s]; None where nothing moves.
    """

    samples: int
    duration: float
    rate: float
    steps: tuple[float, float]
    jitter: float
    moving: tuple[float, float] | None

    @property
    def even(self) -> bool:
        """Whether the time steps are all alike."""
        mean = 1.0 / self.rate
        return max(self.steps[1] - mean, mean - self.steps[0]) < _UNEVEN * mean


@dataclass(frozen=True)
class JointFacts:
    """One joint's signals.

    Attributes:
        position: smallest and largest [rad or m].
        speed: largest [.../s], from filtered positions or speeds.
        torque: smallest and largest [N·m, N, or A].
        position_step, torque_step: smallest difference of two values; 0 where none shows.
        saturated: share of the samples at the torque's own extreme.
    """

    moves: bool
    position: tuple[float, float]
    speed: float
    torque: tuple[float, float]
    position_step: float
    torque_step: float
    saturated: float


def smallest_step(values: Array) -> float:
    """Smallest difference of two different values: the quantum of coarse numbers; 0 for numbers without one.

    Numbers count as quantised if all their differences are whole multiples of the smallest one.
    """
    levels = np.unique(values[:_MOST_LEVELS])
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * max(float(np.abs(levels).max()), 1e-300)]
    if gaps.size < 2:
        return 0.0
    multiples = (levels - levels[0]) / gaps.min()
    return float(gaps.min()) if np.abs(multiples - np.rint(multiples)).max() < _WHOLE else 0.0


def share_at_extreme(values: Array) -> float:
    """Share of the samples that stand at the largest or at the smallest value, whichever are more."""
    return float(max((values == values.max()).mean(), (values == values.min()).mean()))


@dataclass(frozen=True)
class Excited:
    """How surely this log alone shows a base parameter: its estimate and relative standard deviation [%]."""

    name: str
    value: float
    relative_sigma_percent: float


@dataclass(frozen=True, repr=False)
class LogCheck(Speaks):
    """What a log holds and what is wrong with it.

    Attributes:
        robot: that it was looked at for.
        recording: the log as it was understood, SI units, joint side.
        currents: whether its torques are currents [A], of unknown gain.
        time: facts about time; None where it is too short to be filtered.
        joints: facts about each joint.
        findings: worst first.
        excitation: per base parameter; empty where they cannot be estimated.
        relative_residual: of the robot's model on this log; None without it.
        condition_number_scaled: of the observation matrix, columns scaled to norm 1.
    """

    robot: Robot
    recording: Recording
    currents: bool
    time: TimeFacts | None
    joints: tuple[JointFacts, ...]
    findings: tuple[Finding, ...]
    excitation: tuple[Excited, ...] = ()
    relative_residual: float | None = None
    condition_number_scaled: float | None = None

    @property
    def headline(self) -> str:
        """The robot, the log, and what was found in a line."""
        counts = [sum(finding.severity == kind for finding in self.findings) for kind in ("error", "warning")]
        summary = f"{counts[0]} errors, {counts[1]} warnings" if any(counts) else "nothing to mend"
        return f"{self.robot.name}, {self.recording.source}, {summary}"

    @property
    def usable(self) -> bool:
        """Whether nothing speaks against using it as it is."""
        return not any(finding.severity == "error" for finding in self.findings)

    def with_findings(self, findings: Sequence[Finding]) -> "LogCheck":
        """More findings, the worst first."""
        order = ("error", "warning", "note")
        ranked = sorted((*self.findings, *findings), key=lambda finding: order.index(finding.severity))
        return replace(self, findings=tuple(ranked))


def check_log(
    robot: Robot, recording: Recording, processing: Processing | None = None, currents: bool = False
) -> LogCheck:
    """Look at a recording, which may be wrong in any way.

    Args:
        robot: the robot it should be of.
        recording: the log, SI units, joint side.
        processing: settings; the robot's own by default.
        currents: whether its torques are currents [A] of unknown gain.
    """
    processing = processing or robot.processing
    findings = _positions(robot, recording)
    try:
        motion = measurement(recording, processing).motion
    except InputError as refusal:
        return LogCheck(robot, recording, currents, None, (), (*findings, error(str(refusal), "recording")))
    steps, moving = np.diff(recording.t), motion.t[moving_parts(motion, processing.still_speed)]
    time = TimeFacts(
        samples=len(recording.t),
        duration=float(recording.t[-1] - recording.t[0]),
        rate=float(1.0 / steps.mean()),
        steps=(float(steps.min()), float(steps.max())),
        jitter=float(steps.std() / steps.mean()),
        moving=(float(moving[0]), float(moving[-1])) if moving.size else None,
    )
    still = still_joints([recording])
    joints = tuple(
        JointFacts(
            moves=j not in still,
            position=(float(q.min()), float(q.max())),
            speed=float(np.abs(speed).max()),
            torque=(float(torque.min()), float(torque.max())),
            position_step=smallest_step(q),
            torque_step=smallest_step(torque),
            saturated=share_at_extreme(torque),
        )
        for j, (q, torque, speed) in enumerate(zip(recording.q.T, recording.torque.T, motion.qd.T, strict=True), 1)
    )
    findings += _signals(time, joints, currents)
    check = LogCheck(robot, recording, currents, time, joints, tuple(findings))
    if check.usable:
        check = check.with_findings([error(text, "recording") for text in mistakes(robot, recording, currents)])
    return _modelled(check, processing) if check.usable else check


def mistakes(robot: Robot, recording: Recording, currents: bool) -> list[str]:
    """Say why the recording would be refused by any command; the size of a current says nothing."""
    scaled = replace(recording, torque=_GAIN * recording.torque) if currents else recording
    return list(islice(implausible(robot, scaled), 1))


def reduced(
    robot: Robot, recording: Recording, processing: Processing, currents: bool
) -> tuple[Recording, Equations]:
    """Equations of one recording in the base parameters; currents first become torques in one unknown unit.

    Raises:
        InputError: if the recording does not tell enough.
    """
    base = base_parameters(robot)
    equations = base_problem(robot, base, [recording], processing, check=False, blocks=True)
    if currents and robot.coupling is None and robot.spring is None:
        recording = replace(recording, torque=recording.torque * relative_scales(equations).ratio)
        equations = base_problem(robot, base, [recording], processing, check=False, blocks=True)
    return recording, equations


def _modelled(check: LogCheck, processing: Processing) -> LogCheck:
    """Add what the robot's model says of the log: the verdict on it, and how surely parameters are seen."""
    robot = replace(check.robot, mass=None) if check.currents else check.robot  # their size tells no weight
    try:
        recording, equations = reduced(robot, check.recording, processing, check.currents)
        estimate = weighted(equations)
        verdict = robot_verdict(robot, Source((), (recording,), processing), equations, estimate, check.currents)
    except InputError as refusal:
        return check.with_findings([warning(f"Not enough to identify the robot from: {refusal}", "recording")])
    found = [finding._replace(text=f"{finding.text[:1].upper()}{finding.text[1:]}") for finding in verdict.findings]
    spread = estimate.relative_sigma_percent
    unsure = int((~(spread < _UNSURE)).sum())
    if unsure:
        text = (
            f"{unsure} of {len(spread)} base parameters are uncertain by more than {_UNSURE:.0f} % from this log "
            "alone: small ones always are; for others move faster and over a wider range"
        )
        found.append(note(text, "excitation"))
    return replace(
        check.with_findings(found),
        excitation=tuple(map(Excited, base_parameters(robot).names, estimate.values.tolist(), spread.tolist())),
        relative_residual=estimate.fit.relative,
        condition_number_scaled=equations.condition_numbers()[1],
    )


def _positions(robot: Robot, recording: Recording) -> list[Finding]:
    """Say what leaves the range of the robot's joints: degrees, turns of a motor, or another zero."""

    def outside(factor: float) -> list[int]:
        ends = [(position_range(robot.joints[j]), factor * recording.q[:, j]) for j in revolute]
        return [j for j, ((low, high), q) in zip(revolute, ends, strict=True) if q.min() < low or q.max() > high]

    revolute = [j for j, joint in enumerate(robot.joints) if joint.revolute]
    wrong = outside(1.0)
    if not wrong:
        return []
    names = ", ".join(f"q{j + 1}" for j in wrong)
    if 2 * len(wrong) < sum(np.ptp(recording.q[:, j]) > _MOVES for j in revolute):
        advice = "Another zero, sense or order of joints there: give zero_deg, sign or joints in a log map"
    elif not outside(np.pi / 180.0):
        advice = "All positions fit it as degrees: --units q=deg; if they are a motor's, give [motor] gear_ratios"
    else:
        advice = "No joint turns so far: looks like the motor side; give [motor] gear_ratios and side in a log map"
    return [error(f"{names} leave the range of {robot.name}'s joints. {advice}", "positions")]


def _signals(time: TimeFacts, joints: Sequence[JointFacts], currents: bool) -> list[Finding]:
    """Say what is wrong with the time stamps, with joints that rest, and with coarse torques."""
    findings = []
    if time.moving is None:
        findings.append(error("No joint ever moves: record a motion of every joint", "recording"))
    if time.jitter > _JITTER:
        text = (
            f"Time steps vary from {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms: the log is resampled "
            "to an even rate before filtering"
        )
        findings.append(note(text, "time"))
    still = [str(j) for j, joint in enumerate(joints, 1) if not joint.moves]
    names = ", ".join(still)
    if 0 < len(still) < len(joints):
        findings.append(warning(f"Joint {names} never moves: its parameters cannot be seen", f"joint {names}"))
    quantity, unit = ("current", "A") if currents else ("torque", "N·m")
    for j, joint in enumerate(joints, 1):
        span = joint.torque[1] - joint.torque[0]
        if span > 0.0 and joint.torque_step > _COARSE * span:
            text = (
                f"The {quantity} of joint {j} comes in steps of {joint.torque_step:.3g} {unit}, "
                f"{100 * joint.torque_step / span:.0f} % of its range: too coarse"
            )
            findings.append(warning(text, f"joint {j}"))
    return findings


class RobotFit(NamedTuple):
    """A robot that a log can be of; ``residual``: what its model leaves of the torque, None if not known."""

    robot: str
    residual: float | None


class RobotFits(NamedTuple):
    """The shipped robots beside one log.

    ``fitting``: robots that it can be of, the likeliest first; ``others``: those with as many joints that do not
    fit, and why; ``columns`` of the log; ``fault``: why it is no robot's, empty where some fit.
    """

    columns: tuple[str, ...]
    fitting: tuple[RobotFit, ...]
    others: tuple[tuple[str, str], ...]
    fault: str


def robot_fits(path: str | Path, log_map: LogMap | None = None) -> RobotFits:
    """Try all shipped robots on a log.

    Args:
        path: the file or folder.
        log_map: which columns, units, side and signs.

    Raises:
        InputError: if the log cannot be opened at all.
    """
    log_map = log_map or LogMap()
    raw = open_log(path, log_map)
    taken: dict[object, Recording | str] = {}  # read once for all robots of the same columns
    fitting, others, faults = list[RobotFit](), list[tuple[str, str]](), list[str]()
    for robot in map(load_robot, robot_names()):
        try:
            log_map.check(robot.n)
            naming = Naming(raw, log_map, robot)
            currents = naming.holds("current") and not naming.holds("torque")
            gains = [1.0] * robot.n if currents else None
            key = choose(raw, log_map, robot, gains), robot.coupling if currents else None
            if key not in taken:
                taken[key] = _longest(raw, robot, gains, log_map)
            recording = taken[key]
            if isinstance(recording, str):
                raise InputError(recording)
        except InputError as refusal:
            faults.append(str(refusal))
            continue
        wrong = mistakes(robot, recording, currents)
        if wrong:
            others.append((robot.name, wrong[0]))
            continue
        try:
            left = weighted(reduced(robot, recording, robot.processing, currents)[1]).fit.relative
        except InputError:  # too little motion
            left = None
        fitting.append(RobotFit(robot.name, left))
    fitting.sort(key=lambda fit: (fit.residual is None, fit.residual or 0.0))
    fault = ""
    if not fitting and others:
        fault = f"{path}: {others[0][1]}"
    elif (
        not fitting
    ):  # what most robots' columns meet; faults of the file come before those of the number of joints
        fault = min(faults, key=lambda text: ("missing" in text or "joints" in text, -faults.count(text)))
    return RobotFits(raw.names, tuple(fitting), tuple(others), fault)


def _longest(raw: RawLog, robot: Robot, gains: list[float] | None, log_map: LogMap) -> Recording | str:
    """The longest piece of the log by one robot's columns, or why it cannot be read so."""
    try:
        pieces = read_recordings(raw.path, robot, gains, log_map)
    except InputError as refusal:
        return str(refusal)
    return max(pieces, key=lambda piece: float(piece.t[-1] - piece.t[0]))
