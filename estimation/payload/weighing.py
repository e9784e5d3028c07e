"""The payload problem of a short motion near a pose, where not all ten are visible and friction is free."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, each, silent
from ...model import BaseParameters, Motion, Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ...model.names import parameter_kind
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns, visibility_of
from ..equations.equations import PAYLOAD
from ..equations.observation import Observation, Observer
from ..equations.reduction import Residuals, reduced
from ..fit.blocks import block_edges, in_blocks, left_over, length_by_residuals
from ..fit.estimate import Estimate
from ..recordings.plausibility import check_apart, check_recordings
from ..robot.equations import check_lengths, filtered
from ..signals.alignment import AlignedPair, aligned
from ..signals.filtering import grid_rate
from ..signals.measurements import measurement
from ..signals.rows import Mask
from .constant_torques import (
    FREE,
    HeldFriction,
    bare_equations,
    coulomb_friction,
    held_friction,
    held_offsets,
    less_robot,
)
from .constant_torques import friction_free as without_friction
from .equations import difference_observer, torque_change
from .friction import FRICTION_CHANGE, friction_sigmas
from .path import less_path, path_torque, robot_of, with_path
from .problem import PayloadProblem, Source
from .result import in_payload_frame
from .ripple import Wave, ripple_of
from .short_motion import Run, ShortMotion, at_rest, friction_free, moving_joints, telling_rows


def difference_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    processing: Processing | None = None,
    joints: Sequence[int] | None = None,
    progress: Progress = silent,
) -> PayloadProblem:
    """From torque differences (29) on one and the same motion.

    Args:
        robot: the robot.
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.
        processing: settings; the robot's own by default.
        joints: numbers of the joints that move; seen in the recordings by default.
        progress: told what is being worked on.

    Raises:
        InputError: if recordings cannot be used, or do not show the same motion.
    """
    processing = processing or robot.processing
    _check(robot, [*loaded, *unloaded], processing)
    check_apart(loaded, unloaded)
    pairs = _aligned_pairs(loaded, unloaded, processing, progress)
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = _moving([both[1] for both in measured], processing, joints, robot)
    still = [(at_rest(before, moving), at_rest(after, moving)) for before, after in measured]
    # The filter's error at cut ends is alike in both, and a short motion needs its ends.
    masks = [
        np.logical_and(*(telling_rows(one.motion, moving, processing, ends=True) for one in both)) for both in still
    ]
    _check_rows([pair.loaded.source for pair in pairs], masks)
    rms = _torque_rms([both[1] for both in measured], masks)
    progress("the robot without payload")
    free = robot.with_offsets(True)
    base, without_payload = (
        base_parameters(free),
        bare_equations(free, [pair[0] for pair in still], masks, processing),
    )
    own_parameters = robot_of(without_payload)
    payload_observer, path_observer = observer_of(robot, None), difference_observer(robot)
    observations, ripples = [], []
    for (before, after), keep in zip(still, masks, strict=True):
        after_moving = _held_as(before.motion, after.motion, moving)
        path = path_torque(free, base, own_parameters, before.motion, after_moving)
        change, taken = less_path(robot, torque_change(robot, before, after), path)
        factor = processing.thinning(change.motion.rate)
        equations, waves = _observed(payload_observer, change, keep, factor)
        taken_rows = path_observer.observe_rows(taken, keep, factor)
        observations.append(with_path(equations, taken_rows))
        ripples.append(waves)
    runs = _runs([pair.loaded.source for pair in pairs], observations, ripples)
    rate = measured[0][1].motion.rate
    held = held_offsets(observations, coulomb_friction(without_payload))
    source = Source(tuple(loaded), tuple(unloaded), processing)
    return weighing_problem(
        robot, base_parameters(robot), runs, moving, held, rms, rate, pairs=tuple(pairs), source=source
    )


def _held_as(before: Motion, after: Motion, moving: Sequence[int]) -> Motion:
    """A motion with held joints where they were before.

    No motion shows how the robot's torques change with a joint that is held; a guess would do more harm than good.
    """
    q = np.array(after.q)
    held = [j for j in range(after.n) if j + 1 not in moving]
    q[:, held] = before.q[:, held]
    return Motion(after.t, q, after.qd, after.qdd)


def _aligned_pairs(
    loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing, progress: Progress
) -> list[AlignedPair]:
    """Each recording with payload beside its partner without, in one time.

    Raises:
        InputError: if there is neither one partner for all nor one for each, or a pair is not one motion.
    """
    if len(unloaded) not in (1, len(loaded)):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload: give one without for all, or one "
            "for each in the same order"
        )
    partners = list(unloaded) * (len(loaded) if len(unloaded) == 1 else 1)
    return [
        aligned(bare, recording, grid_rate(recording, processing), processing.max_mismatch)
        for bare, recording in each(
            list(zip(partners, loaded, strict=True)), lambda pair: f"aligning {pair[1].source}", progress
        )
    ]


def known_robot_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    known: Estimate,
    processing: Processing | None = None,
    joints: Sequence[int] | None = None,
    progress: Progress = silent,
    friction_change: float = FRICTION_CHANGE,
) -> PayloadProblem:
    """From torques less those of the robot itself, whose parameters were identified earlier, (22)-(23).

    Args:
        robot: the robot.
        loaded: recordings with the payload.
        known: the robot's parameters.
        processing: as ``difference_weighing``.
        joints: as ``difference_weighing``.
        progress: as ``difference_weighing``.
        friction_change: by which share friction may differ from the robot's own (1 sigma); 0 for not at all.

    Raises:
        InputError: if recordings cannot be used, or the parameters are another model's.
    """
    processing = processing or robot.processing
    _check(robot, loaded, processing)
    progress("base parameters")
    base = base_parameters(robot)
    measured = filtered(loaded, processing, progress)
    moving = _moving(measured, processing, joints, robot)
    observer = observer_of(robot, base, friction_change > 0.0)
    still = [at_rest(data, moving) for data in measured]
    masks = [telling_rows(data.motion, moving, processing) for data in still]
    _check_rows([recording.source for recording in loaded], masks)
    # Of a single recording the robot's own ripple is what would be found: it takes weight along.
    observations = [
        observer.observe_rows(data, keep, processing.thinning(data.motion.rate))
        for data, keep in zip(still, masks, strict=True)
    ]
    runs = _runs([recording.source for recording in loaded], observations, [() for _ in loaded])
    alone = [less_robot(recording, known.values) for recording in observations]
    sigmas = friction_sigmas(known, friction_change)
    own = {name: sigma for name, sigma in sigmas.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    held = held_friction(alone, own)
    rms = _torque_rms(still, masks)
    source, rate = Source(tuple(loaded), (), processing), measured[0].motion.rate
    return weighing_problem(robot, base, runs, moving, held, rms, rate, known, source=source)


def weighing_problem(
    robot: Robot,
    base: BaseParameters,
    runs: Sequence[Run],
    moving: tuple[int, ...],
    held: HeldFriction,
    torque_rms: Array,
    rate: float | None,
    known: Estimate | None = None,
    pairs: tuple[AlignedPair, ...] = (),
    source: Source | None = None,
) -> PayloadProblem:
    """The problem of some recordings of a short motion; ``known``: the robot, where no torque was subtracted."""
    equations = friction_free(runs, held)
    factors = in_payload_frame(robot, equations).select(PAYLOAD).factors
    visibility = visibility_of(np.vstack(factors)[:, :-1], moving)
    return PayloadProblem(
        robot,
        base,
        loaded=equations,
        known=known,
        difference=equations if known is None else None,
        pairs=pairs,
        rate=rate,
        source=source,
        inflation=tuple(held.memory.tolist()),
        short=ShortMotion(moving, tuple(runs), held, torque_rms, visibility),
    )


def each_alone(problem: PayloadProblem) -> list[PayloadProblem]:
    """The problem of a short motion by each of its recordings."""
    short = problem.short
    if short is None:
        return []
    setting = short.joints, short.held, short.torque_rms, problem.rate, problem.known
    return [weighing_problem(problem.robot, problem.base, [run], *setting) for run in short.runs]


def observer_of(robot: Robot, base: BaseParameters | None, frees: bool = True) -> Observer:
    """Observer of [W, free columns, W_L]; of torque differences without base parameters and nothing viscous."""
    free = robot.with_offsets(True)
    own = base.columns if base is not None else ()
    friction = (*friction_columns(robot), *(name for name in own if parameter_kind(name) == "FV")) if frees else ()
    columns = (*own, *friction, *payload_columns(free))
    return Observer(free, columns, (*own, *(f"{FREE}{name}" for name in friction), *PAYLOAD))


def _observed(
    observer: Observer, data: Measurement, keep: Mask, decimate: int
) -> tuple[Observation, tuple[Wave, ...]]:
    """The equations of one recording, and the ripple that is free in them."""
    plain = observer.observe_rows(data, keep, decimate)
    waves, columns = ripple_of(plain, data, keep, decimate)
    if not waves:
        return plain, ()
    names = tuple(f"{FREE}{k}" for k in range(columns[0].shape[1]))
    W = tuple(np.column_stack([own, wide]) for own, wide in zip(plain.W, columns, strict=True))
    return replace(plain, columns=(*plain.columns, *names), W=W), waves


def _runs(
    sources: Sequence[str], observations: Sequence[Observation], ripples: Sequence[tuple[Wave, ...]]
) -> list[Run]:
    left = [_left(without_friction(recording)) for recording in observations]
    length = length_by_residuals(left)
    runs = []
    for source, recording, waves in zip(sources, observations, ripples, strict=True):
        edges = block_edges(recording, length)
        equations = in_blocks(reduced(recording), [[recording]], [edges], length)
        runs.append(Run(source, equations, waves))
    return runs


def _left(recording: Observation) -> list[Residuals]:
    return left_over([[recording]], reduced(recording))


def _check_rows(sources: Sequence[str], masks: Sequence[Mask]) -> None:
    for source, keep in zip(sources, masks, strict=True):
        if not keep.any():
            raise InputError(f"{source}: no joint moves fast enough: nothing can be compared")


def _torque_rms(measured: Sequence[Measurement], masks: Sequence[Mask]) -> Array:
    """Root mean square torque of each joint over the rows that are used; 0 where there are none."""
    squares = sum(
        np.where(keep, data.torque**2, 0.0).sum(axis=0) for data, keep in zip(measured, masks, strict=True)
    )
    rows = sum(keep.sum(axis=0) for keep in masks)
    return np.asarray(np.sqrt(squares / np.maximum(rows, 1)))


def _moving(
    measured: Sequence[Measurement], processing: Processing, joints: Sequence[int] | None, robot: Robot
) -> tuple[int, ...]:
    """The joints that move, or those asked for."""
    found = moving_joints([data.motion for data in measured], processing.still_speed)
    if joints is None:
        return found
    idle = sorted(set(joints) - set(found))
    if idle:
        raise InputError(
            f"joint {', '.join(map(str, idle))} of {robot.name} does not move in the recordings, or hardly; joint "
            f"{', '.join(map(str, found))} does: correct --joints"
        )
    return tuple(sorted(joints))


def _check(robot: Robot, recordings: Sequence[Recording], processing: Processing) -> None:
    check_recordings(robot, recordings)
    check_lengths(recordings, processing)
