"""Torques that are something else: late, of other signs, without gravity, not to one scale from joint to joint."""

from dataclasses import replace

import numpy as np

from ....common.errors import InputError
from ....model import Processing, Recording, Robot, base_parameters
from ...answers.gains import gravity_acts
from ...equations.observation import Observer
from ...equations.problem import ReducedProblem
from ...equations.reduction import reduced_measurement
from ...fit.least_squares import weighted
from ...gains.scales import relative_scales
from ...payload.source import Source
from ...signals.filtering import measurement
from ..causes.search import likely_causes
from .finding import Finding

_BETTER = 0.8  # residual without gravity over that with it, below which there is none in the torque
_EXPLAINED = 0.5  # residual below which a model describes a torque at all
_SERIOUS = 0.5  # residual left over residual before, below which an assumption was wrong
_OFF_SCALE = 0.12  # relative difference of two joints' scales that is beyond friction and noise
_CERTAIN = 4.0  # standard deviations


def gravity_findings(robot: Robot, recording: Recording, processing: Processing) -> list[Finding]:
    """Whether a weightless arm explains the whole log better than one with weight.

    More sensitive than the search for causes, which weighs the mean over all joints of a thin sample.
    """
    if not any(gravity_acts(robot)):
        return []
    weightless = replace(robot, gravity=(0.0, 0.0, 0.0))
    with_gravity, without = (
        weighted(reduced(kind, recording, processing)).fit.relative for kind in (robot, weightless)
    )
    if without >= min(_BETTER * with_gravity, _EXPLAINED):
        return []
    return [
        Finding(
            "error",
            f"The torque holds no gravity: a weightless arm leaves {100 * without:.1f} % of it unexplained, "
            f"one with weight {100 * with_gravity:.1f} %. It looks gravity-compensated (an external or a "
            "feedforward torque): record the motor's torque or current",
        )
    ]


def cause_findings(robot: Robot, recording: Recording, processing: Processing) -> list[Finding]:
    """Wrong assumptions without which the robot's model would explain the log far better."""
    causes = likely_causes(robot, Source((), (recording,), processing), contradicted=False)
    return [
        Finding(
            "error" if cause.after < _SERIOUS * cause.before else "warning",
            f"It looks as if {cause.words}: with that undone the joints' mean residual falls from "
            f"{100 * cause.before:.1f} to {100 * cause.after:.1f} %",
        )
        for cause in causes
    ]


def scale_findings(robot: Robot, recording: Recording, processing: Processing) -> list[Finding]:
    """Whether the joints' torques are to one scale, as links that several joints carry show."""
    if robot.coupling is not None or robot.spring is not None:
        return []
    try:
        scales = relative_scales(reduced(robot, recording, processing))
    except InputError:
        return []
    ratio, sigma = scales.ratio, scales.sigma
    off = [
        j
        for j in range(robot.n)
        if abs(np.log(ratio[j])) > _OFF_SCALE and abs(np.log(ratio[j])) > _CERTAIN * sigma[j]
    ]
    if not off:
        return []
    reference = scales.held + 1
    told = ", ".join(f"joint {j + 1} {ratio[j]:.3g} (sigma {100 * sigma[j]:.0f} %)" for j in off)
    return [
        Finding(
            "warning",
            f"The torques are not to one scale: to agree with joint {reference}'s, they would have to be "
            f"multiplied at {told}. Looks like currents, motor-side torques or percent given as torque: give "
            "--drive-gains, gear ratios or rated values",
        )
    ]


def to_scale(robot: Robot, recording: Recording, processing: Processing) -> Recording:
    """Currents as torques in one unknown unit, so that one set of parameters explains all joints.

    Raises:
        InputError: if the recording does not tell the joints' scales.
    """
    if robot.coupling is not None or robot.spring is not None:
        return recording
    return replace(
        recording, torque=recording.torque * relative_scales(reduced(robot, recording, processing)).ratio
    )


def reduced(robot: Robot, recording: Recording, processing: Processing) -> ReducedProblem:
    """The equations of one recording in a robot's base parameters."""
    observer = Observer(robot, base_parameters(robot).columns)
    return reduced_measurement(observer, measurement(recording, processing), processing)
