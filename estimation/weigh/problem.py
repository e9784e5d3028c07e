"""The weighing problem: recordings of a short motion with a payload, reduced once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ...model.visibility import PayloadVisibility, visibility_of
from ..equations.names import PAYLOAD
from ..equations.observation import Observation, Observer
from ..equations.problem import ReducedProblem, merged
from ..fit.blocks import block_edges, block_length, cut
from ..fit.estimate import Estimate
from ..payload.equations import torque_change
from ..recordings.plausibility import check_apart, check_recordings
from ..robot.identification import check_lengths
from ..signals.alignment import AlignedPair, aligned
from ..signals.filtering import measurement
from ..signals.rows import Mask
from .friction import coulomb_friction
from .moving import at_rest, moving_joints, telling_rows
from .offsets import held_offsets
from .ripple import Wave, ripple_of
from .run import HeldOffsets, Run, free_offsets, observed_friction_free, run_observer, with_columns


@dataclass(frozen=True, eq=False)
class WeighProblem:
    """Equations of the payload from one or several recordings of it.

    Attributes:
        robot: the robot.
        joints: numbers of the joints that move; the rows of the others are left out.
        runs: one a recording with payload.
        method: 3 where a recording without payload was subtracted, 1 where the robot's parameters are known.
        known: those parameters, for method 1.
        block_length: shortest length of a block [s].
        pairs: how recordings with and without payload were aligned.
        rate: at which the first recording was processed [Hz].
        torque_rms: root mean square of each joint's torque with payload in the rows used [N·m or N], shape (n,).
    """

    robot: Robot
    joints: tuple[int, ...]
    runs: tuple[Run, ...]
    method: int
    known: Estimate | None
    block_length: float
    pairs: tuple[AlignedPair, ...]
    rate: float
    torque_rms: Array

    @property
    def held(self) -> HeldOffsets:
        """How constant torques are held, the same in all recordings."""
        return self.runs[0].held

    @cached_property
    def problem(self) -> ReducedProblem:
        """All recordings' equations together, friction of each taken out."""
        return merged(run.problem for run in self.runs)

    @cached_property
    def visibility(self) -> PayloadVisibility:
        """What these recordings show of the payload."""
        return visibility_of_problem(self.problem, self.joints)


def visibility_of_problem(problem: ReducedProblem, joints: Sequence[int]) -> PayloadVisibility:
    """What equations, friction taken out, show of the payload."""
    return visibility_of(np.vstack(problem.select(PAYLOAD).factors)[:, :-1], joints)


def difference_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    processing: Processing | None = None,
    joints: Sequence[int] | None = None,
    progress: Progress = silent,
) -> WeighProblem:
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
    if len(unloaded) not in (1, len(loaded)):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload: give one without for all, or one "
            "for each in the same order"
        )
    partners = list(unloaded) * (len(loaded) if len(unloaded) == 1 else 1)
    pairs = []
    for bare, own in zip(partners, loaded, strict=True):
        progress(f"aligning {own.source}")
        pairs.append(aligned(bare, own, processing.rate, processing.max_mismatch))
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = _moving([both[1] for both in measured], processing, joints, robot)
    observer = run_observer(robot, None)
    observations, masks, ripples = [], [], []
    still = [(at_rest(before, moving), at_rest(after, moving)) for before, after in measured]
    for a, b in still:
        # The filter's error at cut ends is alike in both, and a short motion needs its ends.
        keep = np.logical_and(*(telling_rows(one.motion, moving, processing, ends=True) for one in (a, b)))
        change = torque_change(robot, a, b)
        equations, waves = _observed(observer, change, keep, processing.decimate)
        observations.append(equations)
        ripples.append(waves)
        masks.append(keep)
    _check_rows([pair.loaded.source for pair in pairs], masks)
    rms = _torque_rms([both[1] for both in measured], masks)
    progress("friction without payload")
    coulomb = coulomb_friction(robot, [both[0] for both in still], masks, processing.decimate)
    held = held_offsets(observations, coulomb)
    runs, length = _runs([pair.loaded.source for pair in pairs], observations, held, ripples)
    return WeighProblem(robot, moving, runs, 3, None, length, tuple(pairs), measured[0][1].motion.rate, rms)


def known_robot_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    known: Estimate,
    processing: Processing | None = None,
    joints: Sequence[int] | None = None,
    progress: Progress = silent,
) -> WeighProblem:
    """From torques less those of the robot itself, whose parameters were identified earlier, (22)-(23).

    Args:
        robot: the robot.
        loaded: recordings with the payload.
        known: the robot's parameters.
        processing: as ``difference_weighing``.
        joints: as ``difference_weighing``.
        progress: as ``difference_weighing``.

    Raises:
        InputError: if recordings cannot be used, or the parameters are another model's.
    """
    processing = processing or robot.processing
    _check(robot, loaded, processing)
    progress("base parameters")
    base = base_parameters(robot)
    _check_known(robot, base, known)
    measured = []
    for recording in loaded:
        progress(f"filtering {recording.source}")
        measured.append(measurement(recording, processing))
    moving = _moving(measured, processing, joints, robot)
    observer = run_observer(robot, base)
    still = [at_rest(data, moving) for data in measured]
    masks = [telling_rows(data.motion, moving, processing) for data in still]
    _check_rows([recording.source for recording in loaded], masks)
    pairs = [
        _observed(observer, data, keep, processing.decimate, known.values)
        for data, keep in zip(still, masks, strict=True)
    ]
    observations, ripples = [own for own, _ in pairs], [waves for _, waves in pairs]
    # The robot's parameters are of another day: constant torques are free.
    runs, length = _runs([recording.source for recording in loaded], observations, free_offsets(robot.n), ripples)
    rms = _torque_rms(still, masks)
    return WeighProblem(robot, moving, runs, 1, known, length, (), measured[0].motion.rate, rms)


def _observed(
    observer: Observer, data: Measurement, keep: Mask, decimate: int, known: Array | None = None
) -> tuple[Observation, tuple[Wave, ...]]:
    """The equations of one recording, and the ripple that is free in them."""
    plain = observer.observe_rows(data, keep, decimate)
    waves, columns = ripple_of(plain, data, keep, decimate, known)
    return (with_columns(plain, columns) if waves else plain), waves


def _runs(
    sources: Sequence[str],
    observations: Sequence[Observation],
    held: HeldOffsets,
    ripples: Sequence[tuple[Wave, ...]],
) -> tuple[tuple[Run, ...], float]:
    length = block_length([[observed_friction_free(recording)] for recording in observations])
    return tuple(
        Run(source, tuple(cut(recording, block_edges(recording, length))), held, waves)
        for source, recording, waves in zip(sources, observations, ripples, strict=True)
    ), length


def _check_rows(sources: Sequence[str], masks: Sequence[Mask]) -> None:
    for source, keep in zip(sources, masks, strict=True):
        if not keep.any():
            raise InputError(f"{source}: no joint moves fast enough: nothing can be compared")


def _torque_rms(measured: Sequence[Measurement], masks: Sequence[Mask]) -> Array:
    """Of each joint over the rows that are used; 0 where there are none."""
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


def _check_known(robot: Robot, base: BaseParameters, known: Estimate) -> None:
    if known.names != base.columns:
        other = sorted(set(known.names) ^ set(base.columns)) or ["their order"]
        raise InputError(
            f"the stored robot parameters are of another model of {robot.name}: they differ in "
            f"{', '.join(other[:8])}: identify the robot again with the same options"
        )
