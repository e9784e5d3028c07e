"""Signals that are something else: positions off the joint side, torques to no scale or without gravity."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...common.errors import InputError
from ...model import Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ..equations.equations import Equations
from ..equations.observer import Observer, used
from ..equations.reduction import recorded, reduced_measurement
from ..fit.estimate import Fit
from ..fit.least_squares import weighted
from ..gains.current_side import RelativeScales, relative_scales
from ..signals.plausibility import position_range
from .finding import Finding, error, warning

_MOVES = 1e-3  # rad
_BETTER = 0.8  # residual without gravity over that with it, below which there is none in the torque
_EXPLAINED = 0.5  # residual below which a model describes a torque at all
_OFF_SCALE = 0.12  # relative difference of two joints' scales that is beyond friction and noise
_CERTAIN = 4.0  # standard deviations
_PARTS = 10  # of a recording, in time
_PART = 1.0  # s: errors of the model remember about as long, so that shorter parts do not tell how they scatter


def position_findings(robot: Robot, recording: Recording) -> list[Finding]:
    """Degrees, turns of a motor, or another zero, where positions leave the robot's range."""
    revolute = [j for j, joint in enumerate(robot.joints) if joint.revolute]
    outside = [j for j in revolute if not _fits(robot, recording, j, 1.0)]
    if not outside:
        return []
    names = ", ".join(f"q{j + 1}" for j in outside)
    moving = [j for j in revolute if np.ptp(recording.q[:, j]) > _MOVES]
    if 2 * len(outside) < len(moving):
        advice = "Another zero, sense or order of joints there: give zero_deg, sign or joints in a log map"
    elif all(_fits(robot, recording, j, np.pi / 180.0) for j in revolute):
        advice = "All positions fit it as degrees: --units q=deg; if they are a motor's, give [motor] gear_ratios"
    else:
        advice = "No joint turns so far: looks like the motor side; give [motor] gear_ratios and side in a log map"
    return [error(f"{names} leave the range of {robot.name}'s joints. {advice}", "positions")]


def _fits(robot: Robot, recording: Recording, j: int, factor: float) -> bool:
    low, high = position_range(robot.joints[j])
    values = recording.q[:, j] * factor
    return bool(values.min() >= low and values.max() <= high)


def gravity_findings(robot: Robot, data: Measurement, processing: Processing, fit: Fit) -> list[Finding]:
    """Whether a weightless arm explains the whole log better than one with weight, which leaves ``fit``.

    More sensitive than the search for causes, which weighs the mean over all joints of a thin sample.
    """
    if not any(robot.gravity):
        return []
    weightless = replace(robot, gravity=(0.0, 0.0, 0.0))
    without = weighted(reduced(weightless, data, processing)).fit.relative
    if without >= min(_BETTER * fit.relative, _EXPLAINED):
        return []
    return [
        error(
            f"The torque holds no gravity: a weightless arm leaves {100 * without:.1f} % of it unexplained, "
            f"one with weight {100 * fit.relative:.1f} %. It looks gravity-compensated (an external or a "
            "feedforward torque): record the motor's torque or current",
            "torques",
        )
    ]


def scale_findings(robot: Robot, problem: Equations, data: Measurement, processing: Processing) -> list[Finding]:
    """Whether the joints' torques are to one scale, as links that several joints carry show.

    What is off by the formula for white noise must be so by the parts of the recording, too: errors of the model
    last, and look certain to a formula. A recording too short for such parts tells no scales.
    """
    if np.ptp(data.motion.t) < _PARTS * _PART:
        return []
    try:
        scales = _scales(robot, problem)
    except InputError:
        return []
    if scales is None:
        return []
    off = _off_scale(scales)
    if off.size:
        scales = relative_scales(problem, _parts(robot, data, processing))
        off = _off_scale(scales)
    if not off.size:
        return []
    ratio, sigma = scales.ratio, scales.sigma
    factors = ", ".join(f"joint {j + 1} {ratio[j]:.3g} (sigma {100 * sigma[j]:.0f} %)" for j in off)
    return [
        warning(
            f"The torques are not to one scale: to agree with joint {scales.held + 1}'s, they would have to be "
            f"multiplied at {factors}. Looks like currents, motor-side torques or percent given as torque: give "
            "--drive-gains, gear ratios or rated values",
            "torques",
        )
    ]


def _off_scale(scales: RelativeScales) -> NDArray[np.intp]:
    """Joints (from 0) whose torques are on another scale."""
    size = np.abs(np.log(scales.ratio))
    return np.flatnonzero((size > _OFF_SCALE) & (size > _CERTAIN * scales.sigma))


def _parts(robot: Robot, data: Measurement, processing: Processing) -> list[Equations]:
    """The equations of a recording, in equal parts of time."""
    observer = Observer(robot, base_parameters(robot).columns)
    _, (recording,) = recorded(observer, [used(data, processing)])
    ends = np.linspace(data.motion.t[0], data.motion.t[-1], _PARTS + 1)
    ends[[0, -1]] = -np.inf, np.inf
    return recording.cut(ends)


def to_scale(robot: Robot, data: Measurement, processing: Processing) -> Measurement:
    """Currents as torques in one unknown unit, so that one set of parameters explains all joints.

    Raises:
        InputError: if the recording does not tell the joints' scales.
    """
    scales = _scales(robot, reduced(robot, data, processing))
    return data if scales is None else Measurement(data.motion, data.torque * scales.ratio)


def _scales(robot: Robot, problem: Equations) -> RelativeScales | None:
    """None for a robot with torques that no drive of its own gives."""
    return relative_scales(problem) if robot.coupling is None and robot.spring is None else None


def reduced(robot: Robot, data: Measurement, processing: Processing) -> Equations:
    """The equations of one recording in a robot's base parameters."""
    return reduced_measurement(Observer(robot, base_parameters(robot).columns), data, processing)
