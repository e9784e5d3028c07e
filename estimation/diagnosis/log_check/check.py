"""A look at one log before anything is identified from it."""

from dataclasses import dataclass, replace

import numpy as np

from ....common.errors import InputError
from ....model import Processing, Recording, Robot, base_parameters
from ...fit.least_squares import weighted
from ...recordings.plausibility import check_recordings
from .finding import Finding
from .signals import JointFacts, TimeFacts, joint_facts, time_facts
from .torque import cause_findings, gravity_findings, reduced, scale_findings, to_scale
from .units import position_findings

_JITTER = 0.02  # of the mean step
_COARSE = 0.02  # torque step over the torque's range
_UNSURE = 30.0  # percent: relative sigma of a parameter that is hardly seen


@dataclass(frozen=True)
class Excited:
    """How surely this log alone shows a base parameter: its estimate and relative standard deviation [%]."""

    name: str
    value: float
    relative_sigma_percent: float


@dataclass(frozen=True)
class LogCheck:
    """What a log holds and what is wrong with it.

    Attributes:
        recording: the log as it was understood, SI units, joint side.
        currents: whether its torques are currents [A], of unknown gain.
        time: facts about time; None where it is too short to be filtered.
        joints: facts about each joint.
        findings: worst first.
        excitation: per base parameter; empty where they cannot be estimated.
        relative_residual: of the robot's model on this log; None without it.
        condition_number_scaled: of the observation matrix, columns scaled to norm 1.
    """

    recording: Recording
    currents: bool
    time: TimeFacts | None
    joints: tuple[JointFacts, ...]
    findings: tuple[Finding, ...]
    excitation: tuple[Excited, ...] = ()
    relative_residual: float | None = None
    condition_number_scaled: float | None = None

    @property
    def usable(self) -> bool:
        """Whether nothing speaks against using it as it is."""
        return not any(finding.severity == "error" for finding in self.findings)


def check_log(
    robot: Robot, recording: Recording, processing: Processing | None = None, currents: bool = False
) -> LogCheck:
    """Look at a recording, which may be wrong in any way.

    Args:
        robot: the robot it should be of.
        recording: as it was read.
        processing: settings; the robot's own by default.
        currents: its torques are currents [A] of unknown gain.
    """
    processing = processing or robot.processing
    findings = position_findings(robot, recording)
    try:
        time = time_facts(recording, processing)
        joints = joint_facts(robot, recording, processing)
    except InputError as error:
        return LogCheck(recording, currents, None, (), (*findings, Finding("error", str(error))))
    findings += _time_findings(time) + _joint_findings(joints, currents)
    if not findings or all(finding.severity != "error" for finding in findings):
        findings += _plausibility(robot, recording, currents)
    usable = all(finding.severity != "error" for finding in findings)
    excitation: tuple[Excited, ...] = ()
    residual = condition = None
    if usable:
        try:
            shown = to_scale(robot, recording, processing) if currents else recording
            wrong = gravity_findings(robot, shown, processing)
            if not wrong and not currents:
                wrong = scale_findings(robot, recording, processing)
            findings += wrong or cause_findings(robot, shown, processing)
            problem = reduced(robot, shown, processing)
            estimate = weighted(problem)
            names = base_parameters(robot).names
            spread = estimate.relative_sigma_percent
            excitation = tuple(map(Excited, names, estimate.values.tolist(), spread.tolist()))
            residual, condition = estimate.fit.relative, problem.condition_numbers()[1]
        except InputError as error:
            findings.append(Finding("warning", f"Not enough to identify the robot from: {error}"))
    findings += _excitation_findings(excitation)
    order = ("error", "warning", "note")
    ranked = tuple(sorted(findings, key=lambda finding: order.index(finding.severity)))
    return LogCheck(recording, currents, time, joints, ranked, excitation, residual, condition)


def _plausibility(robot: Robot, recording: Recording, currents: bool) -> list[Finding]:
    """What would refuse the recording in any command."""
    # The size of a current says nothing; a usual gain makes it a torque of about the right size.
    shown = replace(recording, torque=10.0 * recording.torque) if currents else recording
    try:
        check_recordings(robot, [shown])
    except InputError as error:
        return [Finding("error", str(error).removeprefix(f"{recording.source}: "))]
    return []


def _time_findings(time: TimeFacts) -> list[Finding]:
    findings = []
    if time.moving is None:
        findings.append(Finding("error", "No joint ever moves: record a motion of every joint"))
    if time.jitter > _JITTER:
        findings.append(
            Finding(
                "note",
                f"Time steps vary from {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms: the log is "
                f"resampled to an even rate before filtering",
            )
        )
    return findings


def _joint_findings(joints: tuple[JointFacts, ...], currents: bool) -> list[Finding]:
    findings = []
    still = [str(j) for j, joint in enumerate(joints, 1) if not joint.moves]
    if still and len(still) < len(joints):
        findings.append(Finding("warning", f"Joint {', '.join(still)} never moves: its parameters cannot be seen"))
    what, unit = ("current", "A") if currents else ("torque", "N·m")
    for j, joint in enumerate(joints, 1):
        span = joint.torque[1] - joint.torque[0]
        if span > 0.0 and joint.torque_step > _COARSE * span:
            findings.append(
                Finding(
                    "warning",
                    f"The {what} of joint {j} comes in steps of {joint.torque_step:.3g} {unit}, "
                    f"{100 * joint.torque_step / span:.0f} % of its range: too coarse",
                )
            )
    return findings


def _excitation_findings(excitation: tuple[Excited, ...]) -> list[Finding]:
    spread = np.array([entry.relative_sigma_percent for entry in excitation])
    unsure = int((~(spread < _UNSURE)).sum())
    if not unsure:
        return []
    return [
        Finding(
            "note",
            f"{unsure} of {len(excitation)} base parameters are uncertain by more than {_UNSURE:.0f} % from this "
            "log alone: small ones always are; for others move faster and over a wider range",
        )
    ]
