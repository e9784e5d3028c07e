"""Short motions near a pose, made of recordings: friction is free in them, and not all ten need be visible."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import each
from ...model import BaseParameters, Motion, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns
from ..equations.equations import PAYLOAD, Equations, merged
from ..equations.observer import PATH, Observation, Observer
from ..equations.reduction import reduced
from ..fit.blocks import block_edges, block_length, in_blocks, remembered
from ..fit.estimate import Estimate
from ..fit.friction import under_own_load
from ..fit.own_equations import check_lengths, filtered
from ..fit.settings import DEFAULTS, Settings
from ..signals.alignment import aligned
from ..signals.filtering import grid_rate, measurement
from ..signals.plausibility import check_apart, check_recordings
from ..signals.rows import Mask
from .constant_torques import FREE, coulomb_friction, friction_prior, offset_prior
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
    """Weigh by torques less those of the robot itself, (22)-(23); other arguments as of ``difference_weighing``.

    Args:
        known: the robot's parameters, identified earlier.

    Raises:
        InputError: if recordings cannot be used, or the parameters are another model's.
    """
    processing, progress = settings.processing_of(robot), settings.progress
    robot = robot.of_parameters(known.names)
    check_recordings(robot, loaded)
    progress("base parameters")
    base, sources = base_parameters(robot), [recording.source for recording in loaded]
    measured = filtered(loaded, processing, progress)
    moving = moving_joints(measured, processing, settings.joints, robot)
    still = [at_rest(data, moving) for data in measured]
    masks = [telling_rows(data.motion, moving, processing) for data in still]
    rms = _torque_rms(sources, still, masks)

    def observed(observer: Observer) -> tuple[Equations, list[Observation]]:
        each_one = [
            observer.observe_rows(data, keep, processing.thinning(data.motion.rate))
            for data, keep in zip(still, masks, strict=True)
        ]
        return merged(map(reduced, each_one)), each_one

    observer = _observer(robot, base, settings.friction_change > 0.0)
    (_, observations), _ = under_own_load(observer, observed, known.values)
    # Of a single recording the robot's own ripple is what would be found: it takes weight along.
    runs = _runs(sources, observations, [() for _ in loaded])
    k, sigmas = len(known.values), friction_sigmas(known, settings.friction_change)
    payload_only = [  # less the torque of the robot, whose columns come first
        replace(one, columns=one.columns[k:], W=tuple(W[:, k:] for W in one.W), Y=tuple(one.errors(known.values)))
        for one in observations
    ]
    own = {name: sigma for name, sigma in sigmas.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    source = Source(tuple(loaded), (), processing, rate=measured[0].motion.rate)
    return ShortMotion(robot, base, source, moving, runs, friction_prior(payload_only, own), rms, known)


def difference_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    settings: Settings = DEFAULTS,
) -> ShortMotion:
    """Weigh by torque differences (29) on one and the same motion.

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
    together = each(list(zip(partners, loaded, strict=True)), lambda pair: f"aligning {pair[1].source}", progress)
    pairs = [
        aligned(without, recording, grid_rate(recording, processing), processing.max_mismatch)
        for without, recording in together
    ]
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = moving_joints([under_load for _, under_load in measured], processing, settings.joints, robot)
    still = [(at_rest(without, moving), at_rest(under_load, moving)) for without, under_load in measured]
    # The filter's error at cut ends is alike in both, and a short motion needs its ends.
    masks = [
        np.logical_and(*(telling_rows(data.motion, moving, processing, ends=True) for data in pair))
        for pair in still
    ]
    sources = [pair.loaded.source for pair in pairs]
    rms = _torque_rms(sources, [under_load for _, under_load in measured], masks)
    progress("the robot without payload")
    free = robot.with_offsets(True)
    whole, observer = Observer(free, base_parameters(free).columns), _observer(robot, None)
    without_payload = merged(
        reduced(whole.observe_rows(without, keep, processing.thinning(without.motion.rate)))
        for (without, _), keep in zip(still, masks, strict=True)
    )
    own, resting = robot_of(without_payload), [j for j in range(robot.n) if j + 1 not in moving]
    observations, ripples = list[Observation](), list[tuple[Wave, ...]]()
    for source, (without, under_load), keep in zip(sources, still, masks, strict=True):
        # No motion shows how torques change with a joint at rest, so that it stays where it was before.
        q = np.array(under_load.motion.q)
        q[:, resting] = without.motion.q[:, resting]
        after = Motion(under_load.motion.t, q, under_load.motion.qd, under_load.motion.qdd)
        path = whole.torques(after, own) - whole.torques(without.motion, own)
        change = replace(torque_change(robot, without, under_load), path=path)
        decimate = processing.thinning(change.motion.rate)
        plain = observer.observe_rows(change, keep, decimate)
        less_path = replace(plain, columns=plain.columns[:-1], W=tuple(W[:, :-1] for W in plain.W))
        waves, columns = ripple_of(source, less_path, change, keep, decimate)
        if waves:  # free beside the payload
            names = tuple(f"{FREE}{k}" for k in range(columns[0].shape[1]))
            W = tuple(np.column_stack(both) for both in zip(plain.W, columns, strict=True))
            plain = replace(plain, columns=(*plain.columns, *names), W=W)
        observations.append(plain)
        ripples.append(waves)
    return ShortMotion(
        robot,
        base_parameters(robot),
        Source(tuple(loaded), tuple(unloaded), processing, tuple(pairs), rate=measured[0][1].motion.rate),
        moving,
        _runs(sources, observations, ripples),
        offset_prior(observations, coulomb_friction(without_payload)),
        rms,
    )


def _observer(robot: Robot, base: BaseParameters | None, frees: bool = True) -> Observer:
    """Make the observer of [W, free columns, W_L]; of torque differences [free columns, W_L, ``PATH``]."""
    free = robot.with_offsets(True)
    own, path = (base.columns, ()) if base is not None else ((), (PATH,))
    friction = (*friction_columns(robot), *(name for name in own if parameter_kind(name) == "FV")) if frees else ()
    # FA gives way to offsets, which rows of a moving joint do not tell from it.
    known = (name.replace("FA", "OFF") if parameter_kind(name) == "FA" else name for name in own)
    columns = (*known, *friction, *payload_columns(free), *path)
    return Observer(free, columns, (*own, *(f"{FREE}{name}" for name in friction), *PAYLOAD, *path))


def _runs(
    sources: Sequence[str], observations: Sequence[Observation], ripples: Sequence[tuple[Wave, ...]]
) -> tuple[Run, ...]:
    """Cut each recording's equations in blocks as long as the memory of all of them asks for, with its ripple."""
    rest = [one.eliminate([name for name in one.columns if name.startswith(FREE)]) for one in observations]
    length = block_length([remembered([one], reduced(one)) for one in rest])
    return tuple(
        Run(source, in_blocks(reduced(one), [one], [block_edges(one, length)], length), waves)
        for source, one, waves in zip(sources, observations, ripples, strict=True)
    )


def _torque_rms(sources: Sequence[str], measured: Sequence[Measurement], masks: Sequence[Mask]) -> Array:
    """Root mean square torque of each joint over the rows that are used; 0 where there are none.

    Raises:
        InputError: if a recording has no such row.
    """
    for source, keep in zip(sources, masks, strict=True):
        if not keep.any():
            raise InputError(f"{source}: no joint moves fast enough: nothing can be compared")
    used = zip(measured, masks, strict=True)
    squares = sum(np.where(keep, data.torque**2, 0.0).sum(axis=0) for data, keep in used)
    return np.asarray(np.sqrt(squares / np.maximum(sum(keep.sum(axis=0) for keep in masks), 1)))
