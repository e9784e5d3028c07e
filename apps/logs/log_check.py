"""A look at one log before anything is identified from it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from ...common.errors import InputError
from ...common.speech import Speaks
from ...estimation.diagnosis.beside import beside_robot
from ...estimation.diagnosis.checks.nuisances import OF_ROBOT
from ...estimation.diagnosis.evidence import Evidence
from ...estimation.diagnosis.finding import Finding, error, warning
from ...estimation.diagnosis.sample import Sample
from ...estimation.diagnosis.search import likely_cause
from ...estimation.diagnosis.torque import gravity_findings, position_findings, reduced, scale_findings, to_scale
from ...estimation.fit.estimate import Estimate
from ...estimation.fit.least_squares import weighted
from ...estimation.payload.problem import Source
from ...estimation.signals.measurements import measurement
from ...estimation.signals.plausibility import implausible
from ...model import Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from .log_facts import JointFacts, TimeFacts, joint_facts, time_facts

_JITTER = 0.02  # of the mean step
_COARSE = 0.02  # torque step over the torque's range
_UNSURE = 30.0  # percent: relative sigma of a parameter that is hardly seen


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
        processing: settings; the robot's own by default.
        currents: its torques are currents [A] of unknown gain.
    """
    processing = processing or robot.processing
    findings = position_findings(robot, recording)
    try:
        data = measurement(recording, processing)
    except InputError as refusal:
        return LogCheck(robot, recording, currents, None, (), (*findings, error(str(refusal), "recording")))
    time, joints = time_facts(recording, data.motion, processing), joint_facts(recording, data.motion)
    findings += [*_time_findings(time), *_joint_findings(joints, currents)]
    check = LogCheck(robot, recording, currents, time, joints, tuple(findings))
    if check.usable:
        check = check.with_findings(_plausibility(robot, recording, currents))
    if check.usable:
        check = _modelled(robot, check, data, processing)
    return check.with_findings(_excitation_findings(check.excitation))


def _modelled(robot: Robot, check: LogCheck, data: Measurement, processing: Processing) -> LogCheck:
    """What the robot's model says of the log: causes of a bad fit, and how surely parameters are seen."""
    try:
        if check.currents:
            data = to_scale(robot, data, processing)
        problem = reduced(robot, data, processing)
        estimate = weighted(problem)
        wrong = gravity_findings(robot, data, processing, estimate.fit)
        if not wrong and not check.currents:
            wrong = scale_findings(robot, problem, data, processing)
        if not wrong:
            cause = likely_cause(robot, [Sample.of(check.recording, processing, data)], contradicted=False)
            wrong = [cause.finding("It")] if cause is not None else []
        if not wrong and not check.currents:
            wrong = _of_robot(robot, check.recording, processing, estimate)
        condition = problem.condition_numbers()[1]
    except InputError as refusal:
        return check.with_findings([warning(f"Not enough to identify the robot from: {refusal}", "recording")])
    names, spread = base_parameters(robot).names, estimate.relative_sigma_percent
    return replace(
        check.with_findings(wrong),
        excitation=tuple(map(Excited, names, estimate.values.tolist(), spread.tolist())),
        relative_residual=estimate.fit.relative,
        condition_number_scaled=condition,
    )


def _of_robot(robot: Robot, recording: Recording, processing: Processing, estimate: Estimate) -> list[Finding]:
    """Whether it is this robot's log, its joints counted as described and its torques torques."""
    beside = beside_robot(robot, Source((), (recording,), processing))
    evidence = Evidence(
        robot,
        parameters=estimate,
        rivals=beside.rivals,
        tilt=beside.tilt,
        nuisances=beside.nuisances,
        pulls=beside.pulls,
    )
    findings = (finding for look in OF_ROBOT for finding in look(evidence))
    return [finding._replace(text=f"{finding.text[:1].upper()}{finding.text[1:]}") for finding in findings]


def _plausibility(robot: Robot, recording: Recording, currents: bool) -> list[Finding]:
    """What would refuse the recording in any command."""
    # The size of a current says nothing; a usual gain makes it a torque of about the right size.
    scaled = replace(recording, torque=10.0 * recording.torque) if currents else recording
    return [error(text, "recording") for text in islice(implausible(robot, scaled), 1)]


def _time_findings(time: TimeFacts) -> list[Finding]:
    findings = []
    if time.moving is None:
        findings.append(error("No joint ever moves: record a motion of every joint", "recording"))
    if time.jitter > _JITTER:
        text = (
            f"Time steps vary from {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms: the log is resampled "
            "to an even rate before filtering"
        )
        findings.append(Finding("note", "time", text))
    return findings


def _joint_findings(joints: tuple[JointFacts, ...], currents: bool) -> list[Finding]:
    findings = []
    still = [str(j) for j, joint in enumerate(joints, 1) if not joint.moves]
    if still and len(still) < len(joints):
        text = f"Joint {', '.join(still)} never moves: its parameters cannot be seen"
        findings.append(warning(text, f"joint {', '.join(still)}"))
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


def _excitation_findings(excitation: tuple[Excited, ...]) -> list[Finding]:
    spread = np.array([entry.relative_sigma_percent for entry in excitation])
    unsure = int((~(spread < _UNSURE)).sum())
    if not unsure:
        return []
    text = (
        f"{unsure} of {len(excitation)} base parameters are uncertain by more than {_UNSURE:.0f} % from this log "
        "alone: small ones always are; for others move faster and over a wider range"
    )
    return [Finding("note", "excitation", text)]
