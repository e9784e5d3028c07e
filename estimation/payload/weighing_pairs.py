"""The payload problem of one short motion without and with payload, by its torque differences (29)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, each, silent
from ...model import Motion, Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ..equations.observation import Observation
from ..equations.observer import Observer
from ..signals.alignment import AlignedPair, aligned
from ..signals.filtering import grid_rate
from ..signals.measurements import measurement
from ..signals.plausibility import check_apart
from ..signals.rows import Mask
from .constant_torques import FREE, bare_equations, coulomb_friction, held_offsets
from .equations import torque_change
from .path import robot_of
from .problem import PayloadProblem, Source
from .ripple import Wave, ripple_of
from .short_motion import at_rest, telling_rows
from .weighing import check_rows, check_usable, chosen_joints, observer_of, rms_of_torque, runs_of, weighing_problem


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
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.
        processing: settings; the robot's own by default.
        joints: numbers of the joints that move; seen in the recordings by default.

    Raises:
        InputError: if recordings cannot be used, or do not show the same motion.
    """
    processing = processing or robot.processing
    check_usable(robot, [*loaded, *unloaded], processing)
    check_apart(loaded, unloaded)
    pairs = _aligned_pairs(loaded, unloaded, processing, progress)
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = chosen_joints([heavy for _, heavy in measured], processing, joints, robot)
    still = [(at_rest(bare, moving), at_rest(heavy, moving)) for bare, heavy in measured]
    masks = [_common_rows(bare.motion, heavy.motion, moving, processing) for bare, heavy in still]
    check_rows([pair.loaded.source for pair in pairs], masks)
    rms = rms_of_torque([heavy for _, heavy in measured], masks)
    progress("the robot without payload")
    without_payload = bare_equations(robot.with_offsets(True), [bare for bare, _ in still], masks, processing)
    observations, ripples = _changes(robot, robot_of(without_payload), still, masks, moving, processing)
    runs = runs_of([pair.loaded.source for pair in pairs], observations, ripples)
    rate = measured[0][1].motion.rate
    friction = held_offsets(observations, coulomb_friction(without_payload))
    source = Source(tuple(loaded), tuple(unloaded), processing)
    return weighing_problem(
        robot, base_parameters(robot), runs, moving, friction, rms, rate, pairs=tuple(pairs), source=source
    )


def _common_rows(bare: Motion, heavy: Motion, moving: Sequence[int], processing: Processing) -> Mask:
    """Rows to use of both recordings of a pair, N x n."""
    # The filter's error at cut ends is alike in both, and a short motion needs its ends.
    rows = (telling_rows(motion, moving, processing, ends=True) for motion in (bare, heavy))
    return np.logical_and(*rows)


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
        both = (_held_as(bare.motion, heavy.motion, moving), bare.motion)
        on_loaded, on_unloaded = (whole.torques(motion, own_parameters) for motion in both)
        change = replace(torque_change(robot, bare, heavy), path=on_loaded - on_unloaded)
        equations, waves = _observed(observer, change, keep, processing.thinning(change.motion.rate))
        observations.append(equations)
        ripples.append(waves)
    return observations, ripples


def _held_as(before: Motion, after: Motion, moving: Sequence[int]) -> Motion:
    """A motion with held joints where they were before.

    No motion shows how the robot's torques change with a joint that is held; a guess would do more harm than good.
    """
    q = np.array(after.q)
    at_rest_places = [j for j in range(after.n) if j + 1 not in moving]
    q[:, at_rest_places] = before.q[:, at_rest_places]
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


def _observed(
    observer: Observer, data: Measurement, keep: Mask, decimate: int
) -> tuple[Observation, tuple[Wave, ...]]:
    """The equations of one recording, ``PATH`` their last column, and the ripple that is free in them."""
    plain = observer.observe_rows(data, keep, decimate)
    less_path = replace(plain, columns=plain.columns[:-1], W=tuple(own[:, :-1] for own in plain.W))
    waves, columns = ripple_of(less_path, data, keep, decimate)
    if not waves:
        return plain, ()
    names = tuple(f"{FREE}{k}" for k in range(columns[0].shape[1]))
    W = tuple(np.column_stack([own, wide]) for own, wide in zip(plain.W, columns, strict=True))
    return replace(plain, columns=(*plain.columns, *names), W=W), waves
