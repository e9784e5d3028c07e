"""Equations of the robot itself: recordings without payload, checked, filtered and reduced."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ...common.progress import Progress, each, silent
from ...model import BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.base.rank import leftmost_independent, random_states, stacked_regressor
from ...model.motion import Measurement
from ...model.regressors import standard_columns
from ..equations.equations import Equations
from ..equations.observer import Observation, Observer, used
from ..equations.reduction import recorded
from ..signals.filtering import measurement
from ..signals.plausibility import check_recordings, still_joints
from .blocks import FEWEST, block_edges, block_length, in_blocks, remembered, weighted_solution
from .friction import TermChoice, chosen_terms, under_own_load
from .settings import Candidates, Settings

_NAMED = 4  # parameters that a message lists


def base_problem(
    robot: Robot,
    base: BaseParameters,
    recordings: Sequence[Recording],
    settings: Settings,
    check: bool = True,
    fitted: Array | None = None,
) -> Equations:
    """Process recordings and reduce them to equations in the base parameters, in blocks of time where robust.

    Args:
        recordings: recordings of one and the same load.
        check: refuse recordings in which some joint never moves.
        fitted: base parameters under whose load friction is; by default under that which the recordings show.
    """
    processing = settings.processing_of(robot)
    check_recordings(robot, recordings)
    if check:
        check_moving(robot, base, recordings)
    measured = filtered(recordings, processing, settings.progress)
    observer = Observer(robot, base.columns)

    def reduced(observer: Observer) -> tuple[Equations, list[Observation]]:
        return recorded(observer, (used(data, processing) for data in measured))

    if fitted is None:
        (equations, opened), _ = under_own_load(observer, reduced)
    else:
        equations, opened = reduced(observer.at(fitted))
    if equations.equations == 0:
        raise InputError(f"{recordings[0].source}: no joint moves: nothing can be compared")
    return in_own_blocks(equations, opened) if settings.robust else equations


def with_friction(
    robot: Robot, recordings: Sequence[Recording], settings: Settings
) -> tuple[Robot, tuple[TermChoice, ...]]:
    """Give a robot the friction that the settings ask for, and tell which terms were tried.

    Of candidates those are kept that recordings without payload, in blocks of time, show; none where that cannot be
    judged or no gear's friction is measured.

    Args:
        recordings: of one and the same load.
    """
    asked, own = settings.friction, robot.drives.friction
    if not isinstance(asked, Candidates):
        return robot.with_friction(asked), ()
    kinds = [term.kind for term in own]
    candidates = tuple(term for term in asked.terms if term.kind not in kinds)
    if not candidates or not own:
        return robot, ()
    settings.progress("choosing the friction's terms")
    base, wide = base_parameters(robot), robot.with_friction((*own, *candidates))
    processing = settings.processing_of(robot)
    tried = [name for name in standard_columns(wide) if name not in standard_columns(robot)]
    observer = Observer(wide, (*base.columns, *tried))
    try:
        check_recordings(robot, recordings)
        check_moving(robot, base, recordings)
        measured = [used(data, processing) for data in filtered(recordings, processing)]
        values = weighted_solution(recorded(observer.only(base.columns), measured)[0])
        equations = in_own_blocks(*recorded(observer.at(values), measured))
        if len(equations.blocks) < FEWEST:
            raise InputError(f"{len(equations.blocks)} blocks of time are too few to hold some out: record longer")
        terms, choices = chosen_terms(wide, candidates, equations)
    except InputError as error:  # what no estimate can do with either is refused there
        return robot, tuple(TermChoice(term.kind, False, why_not=f"{error}") for term in candidates)
    return robot.with_friction((*own, *terms)), choices


def in_own_blocks(equations: Equations, recordings: Sequence[Observation]) -> Equations:
    """Cut equations of one load in blocks of time as long as their memory asks for."""
    load = remembered(recordings, equations)
    length = block_length([load])
    return in_blocks(equations, recordings, [block_edges(ends, length) for ends in load.spans], length)


def filtered(
    recordings: Sequence[Recording], processing: Processing, progress: Progress = silent
) -> list[Measurement]:
    """Make recordings even in time, positions and speeds filtered; refuse what decimation leaves nothing of."""
    check_lengths(recordings, processing)
    worked_on = each(recordings, lambda recording: f"filtering {recording.source}", progress)
    return [measurement(recording, processing) for recording in worked_on]


def check_lengths(recordings: Sequence[Recording], processing: Processing) -> None:
    """Refuse recordings of which decimation leaves nothing."""
    for recording in recordings:
        factor = processing.thinning(processing.grid_rate(recording.rate))
        if len(recording.t) <= factor:
            rate, length = processing.rate, recording.t[-1] - recording.t[0]
            slow = rate is not None and rate * length <= processing.decimate
            raise InputError(
                f"{recording.source}: decimation by {factor} leaves nothing of {len(recording.t)} samples: "
                + ("raise rate" if slow else "raise equation-rate or record longer")
            )


def check_moving(robot: Robot, base: BaseParameters, recordings: Sequence[Recording]) -> None:
    """Refuse recordings in which some joint never moves."""
    still = still_joints(recordings)
    if len(still) == robot.n:
        raise InputError(f"{recordings[0].source}: no joint ever moves: record a motion of every joint")
    if still:
        hidden, length = hidden_by(robot, base, still), sum(float(np.ptp(one.t)) for one in recordings)
        names = ", ".join(hidden[:_NAMED]) + f" and {len(hidden) - _NAMED} more" * (len(hidden) > _NAMED)
        raise InputError(
            f"{recordings[0].source}: joint {', '.join(map(str, still))} never moves in {length:.2g} s: {names} "
            "cannot be identified; record a motion of every joint"
        )


def hidden_by(robot: Robot, base: BaseParameters, still: Sequence[int]) -> tuple[str, ...]:
    """Base parameters that the motion leaves undetermined, alone or in sums, while some joints stand still."""
    q, qd, qdd = random_states(robot, 12 * robot.n, seed=0)
    for joint in still:
        q[:, joint - 1], qd[:, joint - 1], qdd[:, joint - 1] = 0.3, 0.0, 0.0
    W = stacked_regressor(robot, q, qd, qdd)[:, list(base.chosen)]
    # A joint that stands still holds any torque within its friction: its rows say nothing.
    moving = np.concatenate([np.full(len(q), j + 1 not in still) for j in range(robot.n)])
    W = W[moving]
    independent = leftmost_independent(W)
    unseen = [k for k in range(W.shape[1]) if k not in independent]
    solution = least_squares(W[:, independent], W[:, unseen])
    mixed = {independent[k] for k in np.flatnonzero((np.abs(solution) > 1e-6).any(axis=1))}
    return tuple(base.names[k] for k in sorted(mixed | set(unseen)))
