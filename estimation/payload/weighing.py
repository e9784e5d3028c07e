"""Short motions near a pose, made of recordings: friction is free in them, and not all ten need be visible."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import each
from ...model import BaseParameters, Motion, Processing, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns
from ..equations.equations import PAYLOAD
from ..equations.observation import Observation
from ..equations.observer import PATH, Observer
from ..equations.reduction import reduced
from ..fit.blocks import block_edges, in_blocks, left_over, length_by_residuals
from ..fit.estimate import Estimate
from ..fit.own_equations import check_lengths, filtered
from ..fit.settings import DEFAULTS, Settings
from ..signals.alignment import aligned
from ..signals.filtering import grid_rate, measurement
from ..signals.plausibility import check_apart, check_recordings
from ..signals.rows import Mask
from .constant_torques import (
    FREE,
    bare_equations,
    coulomb_friction,
    held_friction,
    held_offsets,
    less_robot,
    without_friction,
)
from .long_motion import Source
from .problem import torque_change
from .ripple import Wave, ripple_of
from .short_motion import Run, ShortMotion, at_rest, moving_joints, telling_rows
from .under_load import friction_sigmas, robot_of


def known_robot_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    known: Estimate,
    settings: Settings = DEFAULTS,
) -> ShortMotion:
    """From torques less those of the robot itself, (22)-(23); other arguments as of ``difference_weighing``.

    Args:
        known: the robot's parameters, identified earlier.

    Raises:
        InputError: if recordings cannot be used, or the parameters are another model's.
    """
    processing, progress = settings.processing_of(robot), settings.progress
    check_recordings(robot, loaded)
    check_lengths(loaded, processing)
    progress("base parameters")
    base = base_parameters(robot)
    measured = filtered(loaded, processing, progress)
    moving = moving_joints(measured, processing, settings.joints, robot)
    observer = observer_of(robot, base, settings.friction_change > 0.0)
    still = [at_rest(data, moving) for data in measured]
    masks = [telling_rows(data.motion, moving, processing) for data in still]
    check_rows([recording.source for recording in loaded], masks)
    # Of a single recording the robot's own ripple is what would be found: it takes weight along.
    observations = [
        observer.observe_rows(data, keep, processing.thinning(data.motion.rate))
        for data, keep in zip(still, masks, strict=True)
    ]
    runs = runs_of([recording.source for recording in loaded], observations, [() for _ in loaded])
    alone = [less_robot(recording, known.values) for recording in observations]
    sigmas = friction_sigmas(known, settings.friction_change)
    own = {name: sigma for name, sigma in sigmas.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    friction = held_friction(alone, own)
    rms = rms_of_torque(still, masks)
    source = Source(tuple(loaded), (), processing, rate=measured[0].motion.rate)
    return ShortMotion(robot, base, source, moving, tuple(runs), friction, rms, known)


def observer_of(robot: Robot, base: BaseParameters | None, frees: bool = True) -> Observer:
    """Observer of [W, free columns, W_L]; of torque differences [free columns, W_L, ``PATH``], nothing viscous."""
    free = robot.with_offsets(True)
    own = base.columns if base is not None else ()
    friction = (*friction_columns(robot), *(name for name in own if parameter_kind(name) == "FV")) if frees else ()
    path = (PATH,) if base is None else ()
    columns = (*own, *friction, *payload_columns(free), *path)
    return Observer(free, columns, (*own, *(f"{FREE}{name}" for name in friction), *PAYLOAD, *path))


def runs_of(
    sources: Sequence[str], observations: Sequence[Observation], ripples: Sequence[tuple[Wave, ...]]
) -> list[Run]:
    """Each recording's equations in blocks as long as the memory of all of them asks for, with its ripple."""
    without = map(without_friction, observations)
    length = length_by_residuals([left_over([recording], reduced(recording)) for recording in without])
    runs = []
    for source, recording, waves in zip(sources, observations, ripples, strict=True):
        edges = block_edges(recording, length)
        equations = in_blocks(reduced(recording), [recording], [edges], length)
        runs.append(Run(source, equations, waves))
    return runs


def check_rows(sources: Sequence[str], masks: Sequence[Mask]) -> None:
    """Refuse recordings in which no row can be used."""
    for source, keep in zip(sources, masks, strict=True):
        if not keep.any():
            raise InputError(f"{source}: no joint moves fast enough: nothing can be compared")


def rms_of_torque(measured: Sequence[Measurement], masks: Sequence[Mask]) -> Array:
    """Root mean square torque of each joint over the rows that are used; 0 where there are none."""
    squares = sum(
        np.where(keep, data.torque**2, 0.0).sum(axis=0) for data, keep in zip(measured, masks, strict=True)
    )
    rows = sum(keep.sum(axis=0) for keep in masks)
    return np.asarray(np.sqrt(squares / np.maximum(rows, 1)))


def difference_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    settings: Settings = DEFAULTS,
) -> ShortMotion:
    """From torque differences (29) on one and the same motion.

    Args:
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.

    Raises:
        InputError: if recordings cannot be used, or do not show the same motion.
    """
    processing, progress = settings.processing_of(robot), settings.progress
    check_recordings(robot, [*loaded, *unloaded])
    check_lengths([*loaded, *unloaded], processing)
    check_apart(loaded, unloaded)
    if len(unloaded) not in (1, len(loaded)):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload: give one without for all, or one "
            "for each in the same order"
        )
    partners = list(unloaded) * (len(loaded) if len(unloaded) == 1 else 1)
    pairs = [
        aligned(bare, recording, grid_rate(recording, processing), processing.max_mismatch)
        for bare, recording in each(
            list(zip(partners, loaded, strict=True)), lambda pair: f"aligning {pair[1].source}", progress
        )
    ]
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = moving_joints([heavy for _, heavy in measured], processing, settings.joints, robot)
    still = [(at_rest(bare, moving), at_rest(heavy, moving)) for bare, heavy in measured]
    # The filter's error at cut ends is alike in both, and a short motion needs its ends.
    masks = [
        np.logical_and(*(telling_rows(data.motion, moving, processing, ends=True) for data in pair))
        for pair in still
    ]
    check_rows([pair.loaded.source for pair in pairs], masks)
    rms = rms_of_torque([heavy for _, heavy in measured], masks)
    progress("the robot without payload")
    without_payload = bare_equations(robot.with_offsets(True), [bare for bare, _ in still], masks, processing)
    observations, ripples = _changes(robot, robot_of(without_payload), still, masks, moving, processing)
    runs = runs_of([pair.loaded.source for pair in pairs], observations, ripples)
    friction = held_offsets(observations, coulomb_friction(without_payload))
    rate = measured[0][1].motion.rate
    source = Source(tuple(loaded), tuple(unloaded), processing, tuple(pairs), rate=rate)
    return ShortMotion(robot, base_parameters(robot), source, moving, tuple(runs), friction, rms)


def _changes(
    robot: Robot,
    own_parameters: Array,
    pairs: Sequence[tuple[Measurement, Measurement]],
    masks: Sequence[Mask],
    moving: Sequence[int],
    processing: Processing,
) -> tuple[list[Observation], list[tuple[Wave, ...]]]:
    """Equations (29) of each pair, the torque of paths that differ taken off, and the ripple free in them.

    Args:
        own_parameters: of the robot with offsets, by the recordings without payload.
        pairs: without and with payload, joints that are held at rest.
        masks: rows to use of each pair, N x n.
        moving: numbers of the joints that move.
    """
    free = robot.with_offsets(True)
    whole, observer = Observer(free, base_parameters(free).columns), observer_of(robot, None)
    observations, ripples = [], []
    for (bare, heavy), keep in zip(pairs, masks, strict=True):
        # No motion shows how torques change with a joint that is held, so that it stays where it was before.
        q, held = np.array(heavy.motion.q), [j for j in range(robot.n) if j + 1 not in moving]
        q[:, held] = bare.motion.q[:, held]
        after = Motion(heavy.motion.t, q, heavy.motion.qd, heavy.motion.qdd)
        path = whole.torques(after, own_parameters) - whole.torques(bare.motion, own_parameters)
        change = replace(torque_change(robot, bare, heavy), path=path)
        decimate = processing.thinning(change.motion.rate)
        plain = observer.observe_rows(change, keep, decimate)
        less_path = replace(plain, columns=plain.columns[:-1], W=tuple(own[:, :-1] for own in plain.W))
        waves, columns = ripple_of(less_path, change, keep, decimate)
        if waves:
            names = tuple(f"{FREE}{k}" for k in range(columns[0].shape[1]))
            W = tuple(np.column_stack([own, wide]) for own, wide in zip(plain.W, columns, strict=True))
            plain = replace(plain, columns=(*plain.columns, *names), W=W)
        observations.append(plain)
        ripples.append(waves)
    return observations, ripples
