"""The payload problem of a short motion near a pose, where not all ten are visible and friction is free."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from ...model.names import parameter_kind
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns, visibility_of
from ..equations.equation_code import PATH
from ..equations.equations import PAYLOAD, merged
from ..equations.observation import Observation
from ..equations.observer import Observer
from ..equations.reduction import Residuals, reduced
from ..fit.blocks import block_edges, in_blocks, left_over, length_by_residuals
from ..fit.estimate import Estimate
from ..robot.equations import check_lengths, filtered
from ..signals.alignment import AlignedPair
from ..signals.plausibility import check_recordings
from ..signals.rows import Mask
from .constant_torques import FREE, HeldFriction, held_friction, less_robot, without_friction
from .friction import FRICTION_CHANGE, friction_sigmas
from .problem import PayloadProblem, Source
from .result import in_payload_frame
from .ripple import Wave
from .short_motion import Run, ShortMotion, at_rest, moving_joints, telling_rows


def known_robot_weighing(
    robot: Robot,
    loaded: Sequence[Recording],
    known: Estimate,
    processing: Processing | None = None,
    joints: Sequence[int] | None = None,
    progress: Progress = silent,
    friction_change: float = FRICTION_CHANGE,
) -> PayloadProblem:
    """From torques less those of the robot itself, (22)-(23); other arguments as of ``difference_weighing``.

    Args:
        known: the robot's parameters, identified earlier.
        friction_change: by which share friction may differ from the robot's own (1 sigma); 0 for not at all.

    Raises:
        InputError: if recordings cannot be used, or the parameters are another model's.
    """
    processing = processing or robot.processing
    check_usable(robot, loaded, processing)
    progress("base parameters")
    base = base_parameters(robot)
    measured = filtered(loaded, processing, progress)
    moving = chosen_joints(measured, processing, joints, robot)
    observer = observer_of(robot, base, friction_change > 0.0)
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
    sigmas = friction_sigmas(known, friction_change)
    own = {name: sigma for name, sigma in sigmas.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    friction = held_friction(alone, own)
    rms = rms_of_torque(still, masks)
    source, rate = Source(tuple(loaded), (), processing), measured[0].motion.rate
    return weighing_problem(robot, base, runs, moving, friction, rms, rate, known, source=source)


def weighing_problem(
    robot: Robot,
    base: BaseParameters,
    runs: Sequence[Run],
    moving: tuple[int, ...],
    friction: HeldFriction,
    torque_rms: Array,
    rate: float | None,
    known: Estimate | None = None,
    pairs: tuple[AlignedPair, ...] = (),
    source: Source | None = None,
) -> PayloadProblem:
    """The problem of some recordings of a short motion; ``known``: the robot, where no torque was subtracted."""
    equations = merged(friction.friction_free(run.equations) for run in runs)
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
        inflation=tuple(friction.memory.tolist()),
        short=ShortMotion(moving, tuple(runs), friction, torque_rms, visibility),
    )


def each_alone(problem: PayloadProblem) -> list[PayloadProblem]:
    """The problem of a short motion by each of its recordings."""
    short = problem.short
    if short is None:
        return []
    setting = short.joints, short.held, short.torque_rms, problem.rate, problem.known
    return [weighing_problem(problem.robot, problem.base, [run], *setting) for run in short.runs]


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


def chosen_joints(
    measured: Sequence[Measurement], processing: Processing, joints: Sequence[int] | None, robot: Robot
) -> tuple[int, ...]:
    """The joints that move, or those asked for."""
    moving = moving_joints([data.motion for data in measured], processing.still_speed)
    if joints is None:
        return moving
    idle = sorted(set(joints) - set(moving))
    if idle:
        raise InputError(
            f"joint {', '.join(map(str, idle))} of {robot.name} does not move in the recordings, or hardly; joint "
            f"{', '.join(map(str, moving))} does: correct --joints"
        )
    return tuple(sorted(joints))


def check_usable(robot: Robot, recordings: Sequence[Recording], processing: Processing) -> None:
    """Refuse recordings that are implausible or too short to be filtered."""
    check_recordings(robot, recordings)
    check_lengths(recordings, processing)
