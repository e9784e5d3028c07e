"""Diagnosis of recordings: the same look for ``check``, ``identify``, ``payload``, ``weigh`` and ``gains``."""

from collections.abc import Sequence

import numpy as np

from ...common.errors import InputError
from ...model import Robot
from ...model.visibility import friction_columns
from ..equations.equations import Equations
from ..fit.drive_gains import Gains
from ..fit.estimate import Estimate
from ..payload.by_joints import payload_by_joints
from ..payload.problem import PayloadProblem, Source
from ..payload.repeats import moved, reaching, widened
from ..payload.result import PREFERRED, PayloadEstimate
from .causes import alternatives
from .engine import System
from .evidence import Diagnosis, Evidence
from .finding import Verdict
from .hypotheses import MOVED, effects_of, tilt_correction
from .joints import disagreement
from .scales import LONG_ENOUGH, scales, scales_of_states, signal_scales
from .states import States, states_of
from .verdict import judge


def diagnose(
    problem: PayloadProblem, best: PayloadEstimate, gains: Gains | None = None, description: Robot | None = None
) -> Diagnosis:
    """Look at what no residual of a method shows.

    Args:
        problem: with the recordings themselves, in which faults are searched.
        best: the estimate to be used.
        gains: with whose errors joints may disagree.
        description: the robot as it was given, where gains are what is asked for: other readings are then compared
            with gains of their own; the problem's robot by default.
    """
    n, weights = problem.robot.n, best.estimate.weights
    states = states_of(problem.source) if problem.source is not None else None
    system = system_of(problem, states)
    effects = effects_of(system) if system is not None else ()
    by_joints = payload_by_joints(problem, weights)
    chance = 2.0 * float(best.estimate.sigma[best.places.index(9)]) if 9 in best.places else np.inf
    if problem.unloaded is not None:
        found = scales(problem, weights)
    else:
        found = scales_of_states(system) if system is not None else ()
    return Diagnosis(
        by_joints,
        disagreement(by_joints, gains.covariance(n) if gains else np.zeros((n, n)), problem.short is not None),
        # Bursts matter where the mass without them is another one; stretches that stand out by chance move it less.
        tuple(e for e in effects if e.name != "bursts" or abs(e.change[9]) > max(MOVED * abs(best.ten[9]), chance)),
        alternatives(description or problem.robot, states, description is not None),
        found,
    )


def system_of(problem: PayloadProblem, states: States | None) -> System | None:
    """Set up the problem on subsampled states; None without them, or where the robot is neither shown nor known."""
    source = problem.source
    if states is None or source is None or (problem.known is not None and not problem.inflation):
        return None
    changes = {name: role.weight for name, role in problem.friction.items()}
    if problem.short is not None:
        names = friction_columns(problem.robot.with_offsets(True))
        changes = dict.fromkeys(names, 0.0) | {name: role.weight for name, role in problem.short.held.held.items()}
    try:
        return System.of(problem.robot, states, changes, None if source.unloaded else problem.robot_prior)
    except InputError:  # a joint leaves the table of its spring
        return None


def allowing(estimate: PayloadEstimate, diagnosis: Diagnosis) -> PayloadEstimate:
    """Correct an estimate for a tilt, and widen its intervals for joints that disagree and for bursts."""
    lean, bursts = diagnosis.effect("tilt"), diagnosis.effect("bursts")
    if lean is not None and not estimate.from_scale:
        estimate = moved(estimate, *tilt_correction(lean, estimate.method))
    if bursts is not None:
        estimate = reaching(estimate, bursts.change)
    return widened(estimate, diagnosis.disagreement)


def best_of(estimates: Sequence[PayloadEstimate]) -> PayloadEstimate:
    """Pick the estimate by the preferred method."""
    return min(estimates, key=lambda estimate: PREFERRED.index(estimate.method))


def robot_verdict(
    robot: Robot, source: Source, equations: Equations, estimate: Estimate, free_gains: bool = False
) -> Verdict:
    """Judge a robot's parameters, identified from recordings without payload.

    Args:
        robot: as described.
        source: the recordings.
        equations: of theirs, in blocks of time.
        estimate: the parameters.
        free_gains: whether the torques are currents, brought to one unknown scale.
    """
    states = states_of(source)
    try:
        effects = effects_of(System.of(robot, states)) if states is not None else ()
    except InputError:  # a joint leaves the table of its spring
        effects = ()
    signals, length = None, sum(float(recording.t[-1] - recording.t[0]) for recording in source.unloaded)
    own_drives = robot.coupling is None and robot.spring is None  # every drive gives its own joint's torque
    if own_drives and not free_gains and length > LONG_ENOUGH:
        signals = signal_scales(equations)
    diagnosis = Diagnosis(effects=effects, alternatives=alternatives(robot, states, free_gains), signals=signals)
    return judge(Evidence(robot, source, diagnosis, parameters=estimate))
