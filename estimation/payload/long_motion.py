"""The payload problem of recordings in which every joint moves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.errors import InputError
from ...common.linear import decomposed
from ...common.progress import Progress, silent
from ...model import INERTIAL, BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..fit.estimate import Estimate
from ..fit.linear_problem import Held
from ..fit.own_equations import check_lengths, check_moving, filtered
from ..signals.alignment import AlignedPair, best_aligned, check_mismatch
from ..signals.filtering import grid_rate, measurement
from ..signals.plausibility import check_apart, check_recordings
from .equations import PairedMeasurement, payload_equations
from .friction import FRICTION_CHANGE, friction_changes
from .loaded_scale import loaded_scale
from .pairing import cut_alike
from .problem import FORMULA_ONLY, PayloadProblem, Source


def payload_problem(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: Estimate | None = None,
    processing: Processing | None = None,
    progress: Progress = silent,
    robust: bool = True,
    friction_change: float = FRICTION_CHANGE,
    scale_sigma: float = 0.0,
) -> PayloadProblem:
    """Process recordings with and without payload and reduce them.

    Args:
        unloaded: recordings without; for method 3 the k-th file is the same trajectory as the k-th of ``loaded``.
        known: the robot's identified parameters, instead of or beside ``unloaded``.
        processing: settings; the robot's own by default.
        robust: keep the equations in blocks of time as well, so that estimates get robust standard deviations;
            not with a ``known`` robot that has none itself.
        friction_change: with ``robust``, by which share the friction of the loaded recordings may differ from the
            robot's own (1 sigma); 0 takes it as the same.
        scale_sigma: by which share the scale of the loaded torques may differ from that without payload (1 sigma);
            methods 1 and 4 alone know of it.

    Raises:
        InputError: if a recording cannot be used.
    """
    processing = processing or robot.processing
    progress("base parameters")
    base = base_parameters(robot)
    _check(robot, base, loaded, unloaded, processing)
    loaded, unloaded, lags = cut_alike(loaded, unloaded, processing)
    alone = filtered(unloaded, processing, progress)
    measured = filtered(loaded, processing, progress)
    compared, together, reason = _together(loaded, unloaded, lags, measured, processing, progress)
    formula_only = FORMULA_ONLY if robust and known and known.robust is None else ""
    progress("cutting into blocks" if robust else "reducing")
    blocks = robust and not formula_only
    equations = payload_equations(robot, base, measured, alone, together, processing, blocks, known)
    if equations.unloaded and equations.unloaded.equations == 0:
        raise InputError(f"{unloaded[0].source}: no joint moves: nothing can be compared")
    problem = PayloadProblem(
        robot=robot,
        base=base,
        known=known,
        pairs=compared if together else (),
        without_difference=reason,
        rate=measured[0].motion.rate,
        no_blocks=formula_only,
        source=Source(tuple(loaded), tuple(unloaded), processing),
        compared=compared,
        **equations._asdict(),
    )
    return _with_scale(with_friction(problem, friction_change), scale_sigma)


def _check(
    robot: Robot,
    base: BaseParameters,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    processing: Processing,
) -> None:
    """Refuse recordings from which no payload can be identified."""
    check_visible(robot, base)
    for recordings in filter(None, (loaded, unloaded)):
        check_recordings(robot, recordings)
        check_lengths(recordings, processing)
        check_moving(robot, base, recordings)
    check_apart(loaded, unloaded)


def with_friction(problem: PayloadProblem, share: float = FRICTION_CHANGE) -> PayloadProblem:
    """With what friction may change by, where the robot's own is known."""
    try:
        robot = problem.alone
    except InputError:  # by method 3 it is not needed
        robot = None
    if robot is None or not problem.inflation:
        return problem
    return replace(problem, friction=friction_changes(robot, problem.inflation, share))


def _with_scale(problem: PayloadProblem, sigma: float) -> PayloadProblem:
    """With a scale of the loaded torques that is sure to ``sigma``; none for 0."""
    if not sigma > 0.0:
        return problem
    role = Held(sigma, max(problem.inflation, default=1.0))
    reason = (
        "the scale of the loaded torques is free (--scale-sigma), of which a difference of torques knows nothing"
    )
    scale = loaded_scale(problem.loaded, problem.robot_known, role)
    return replace(problem, scale=scale, without_difference=reason)


def _together(
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    lags: Sequence[float | None],
    measured: Sequence[Measurement],
    processing: Processing,
    progress: Progress,
) -> tuple[tuple[AlignedPair, ...], list[PairedMeasurement], str]:
    """Recordings side by side, and those of one trajectory filtered for method 3; none, and why not."""
    if not unloaded:
        return (), [], "no recordings without payload"
    progress("aligning recordings with and without payload")
    pairs: tuple[AlignedPair, ...] = ()
    try:
        pairs = _paired(loaded, unloaded, lags, processing)
        for pair in pairs:
            check_mismatch(pair, processing.max_mismatch)
        return pairs, [_measured(pair, data, processing) for pair, data in zip(pairs, measured, strict=True)], ""
    except InputError as error:
        return pairs, [], str(error)


def check_visible(robot: Robot, base: BaseParameters) -> None:
    """Refuse an arm on which no motion shows all ten parameters of a payload."""
    effect = base.effect_of(payload_columns(robot))
    hidden = decomposed(effect).null
    if hidden.size:
        named = [kind for kind, size in zip(INERTIAL, np.abs(hidden).max(axis=1), strict=True) if size > 1e-6]
        raise InputError(
            f"no motion of {robot.name} shows {hidden.shape[1]} of a payload's ten directions "
            f"({', '.join(named)}): its joints do not turn the payload in enough ways"
        )


def _paired(
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    lags: Sequence[float | None],
    processing: Processing,
) -> tuple[AlignedPair, ...]:
    if len(loaded) != len(unloaded):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload do not form pairs: method 3 "
            "needs each trajectory once without and once with it, in the same order"
        )
    return tuple(
        best_aligned(a, b, grid_rate(b, processing), lag) for a, b, lag in zip(unloaded, loaded, lags, strict=True)
    )


def _measured(pair: AlignedPair, loaded: Measurement, processing: Processing) -> PairedMeasurement:
    """A pair filtered; the loaded recording was filtered already unless it was cut to what both have in common."""
    whole = len(pair.loaded.t) == len(loaded.motion.t)
    heavy = loaded if whole else measurement(pair.loaded, processing)
    return PairedMeasurement(measurement(pair.unloaded, processing), heavy, pair.lag)
