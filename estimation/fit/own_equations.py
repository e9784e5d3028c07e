"""Equations of the robot itself: recordings without payload, checked, filtered and reduced, with friction as asked.

Friction that grows with load needs the load first; terms of it may be chosen as the data ask for them.
"""

from collections.abc import Sequence
from itertools import chain

import numpy as np
from msgspec import UNSET, UnsetType
from numpy.linalg import norm

from ...common import Array, Document, InputError, decomposed, without
from ...common.progress import Progress, each, silent
from ...model import Processing, Recording, Robot, base_parameters
from ...model.base import random_states, stacked_regressor
from ...model.drives import joint_of, parameter_kind
from ...model.friction import Friction, terms_of
from ...model.motion import Measurement
from ...model.regressors import payload_columns, standard_columns
from ..equations.equations import Equations, merged
from ..equations.observer import PATH, Observation, Observer, Used, recorded, reduced, used
from ..signals.filtering import measurement
from ..signals.recordings import check_recordings, still_joints
from .covariance import FEWEST, in_blocks, remembered, weighted_solution
from .linear_problem import LinearProblem, left_out
from .settings import Candidates, Settings

_NAMED = 4  # parameters that a message lists
_PASSES = 10  # largest number of passes: the load is known after one, and each leaves its error times FL
_SETTLED = 1e-3  # fraction of a standard deviation: a smaller change of every parameter ends the passes
_SURE = 2.0
"""Standard errors by which the error on held-out blocks must fall: of 750 joints of simulated arms without such
friction 3 kept a term by 2; by 1 every fiftieth did."""
_OWN = 0.02  # part of a term's column that no other column can imitate, below which the data do not tell it apart


class TermChoice(Document, frozen=True):
    """Term of friction at a joint that was tried, and what held-out blocks of time say of it.

    ``fall``: of the joint's squared error on them, as a fraction; ``error``: its standard error; both null, and the
    term of no joint, where none could be held out.
    """

    name: str
    kept: bool
    fall: float | None = None
    error: float | None = None
    why_not: str | UnsetType = UNSET


def under_own_load(
    observer: Observer, recordings: Sequence[Used], known: Array | None = None
) -> tuple[tuple[Equations, list[Observation]], Array]:
    """Reduce recordings with friction under the load that their own parameters cause.

    The first pass finds the load without friction that grows with it; the next ones refresh it until no parameter
    moves by more than 1e-3 of its standard deviation. ``known``: values of the first columns, not found anew.

    Returns:
        What ``recorded`` gives by the last observer, and the parameters by which the load is.
    """
    known = np.zeros(0) if known is None else known
    values = np.concatenate([known, np.zeros(len(observer.columns) - len(known))])
    if not observer.robot.drives.loaded or len(known) == len(values):  # nothing of the load is to be found
        return recorded(observer.at(values), recordings), values
    opened = [observer.at(values).observe(*recording) for recording in recordings]
    for again in range(_PASSES):
        if again:
            observer.at(values).refresh(opened, recordings)
        result = merged(map(reduced, opened))
        own = result.minus(observer.columns[: len(known)], known)
        try:
            estimate = LinearProblem(own, own.columns).estimate()
            found, sigma = estimate.values, estimate.sigma
        except InputError:  # a parameter that is not determined may still move
            found, sigma = weighted_solution(own), np.zeros(len(own.columns))
        moved, values = found - values[len(known) :], np.concatenate([known, found])
        if (np.abs(moved) <= _SETTLED * sigma).all():
            break
    return (result, opened), values


def chosen_terms(
    robot: Robot, candidates: Sequence[Friction], equations: Equations
) -> tuple[tuple[Friction, ...], tuple[TermChoice, ...]]:
    """Keep the terms by which a joint's error on held-out blocks of ``equations`` falls by two standard errors.

    ``robot``: with all candidates at all joints; they are tried one after the other.
    """
    kinds, kept, choices = [term.kind for term in candidates], dict[str, list[str]](), dict[str, TermChoice]()
    own = [name for name in equations.columns if parameter_kind(name) not in kinds]
    plain = equations.whole.select(own)
    weights = plain.joint_weights(weighted_solution(plain))

    def held_out(names: Sequence[str]) -> tuple[Array, dict[str, float]]:
        """Squared errors of each joint on each block by the others' fit, B x n, and the values by all."""
        *each, values = (x[:, 0] for x, _ in left_out(equations, names, weights))
        chi, there = np.zeros(len(equations.columns)), [equations.columns.index(name) for name in names]
        squares = np.zeros((len(each), robot.n))
        for own, block, solution in zip(squares, equations.blocks, each, strict=True):
            chi[there] = solution
            own[:] = block.error_norms(chi) ** 2
        return squares, dict(zip(names, values.tolist(), strict=True))

    beside = dict[str, list[str]]()  # names of the other parameters with which a kind was tried
    for term in (*candidates, *candidates):  # the second time beside the others that were kept
        others = [*own, *(name for kind, names in kept.items() if kind != term.kind for name in names)]
        if term.kind in kept and others in (own, beside[term.kind]):
            continue
        names, beside[term.kind] = [name for name in equations.columns if parameter_kind(name) == term.kind], others
        there, tried = [equations.columns.index(name) for name in others], list[str]()
        for name in names:
            factor = equations.factors[joint_of(name)]
            column = factor[:, [equations.columns.index(name)]]
            if norm(without(column, factor[:, there])) > _OWN * norm(column):
                tried.append(name)
        before, after = held_out(others), held_out([*others, *tried])
        for name in names:
            joint = joint_of(name)
            falls = before[0][:, joint] - after[0][:, joint]
            total, error = float(falls.sum()), float(np.sqrt(len(falls)) * falls.std(ddof=1))
            size, why_not = max(float(before[0][:, joint].sum()), np.finfo(float).tiny), ""
            if name not in tried:
                why_not = "cannot be separated from the others"
            elif not total > _SURE * error:
                why_not = "explains no more on held-out blocks"
            elif term.loaded and after[1][name] <= 0.0:
                why_not = "would be negative"
            choices[name] = TermChoice(name, not why_not, total / size, error / size, why_not or UNSET)
        kept[term.kind] = [name for name in names if choices[name].kept]
    return terms_of([*chain.from_iterable(kept.values())], candidates, robot.n), tuple(choices.values())


def observed_columns(robot: Robot) -> tuple[str, ...]:
    """Columns of all equations: a robot's base parameters, a payload's ten, and ``PATH``."""
    return (*base_parameters(robot).columns, *payload_columns(robot), PATH)


def payload_observer(robot: Robot) -> Observer:
    """Make the observer of a robot and a payload: one code for all equations."""
    return Observer(robot, observed_columns(robot))


def base_problem(
    observer: Observer,
    recordings: Sequence[Recording],
    settings: Settings,
    check: bool = True,
    chi: Array | None = None,
) -> Equations:
    """Process recordings of one load to equations in the base parameters, in blocks of time where robust.

    ``check``: refuse recordings in which some joint never moves; ``chi``: base parameters under whose load
    friction is, by default those that the recordings show.
    """
    robot = observer.robot
    processing = settings.processing_of(robot)
    check_recordings(robot, recordings)
    if check:
        check_moving(robot, recordings)
    rows = [used(data, processing) for data in filtered(recordings, processing, settings.progress)]
    (equations, opened), _ = under_own_load(observer.only(base_parameters(robot).columns), rows, chi)
    if equations.equations == 0:
        raise InputError(f"{recordings[0].source}: no joint moves: nothing can be compared")
    # Blocks are as long as the memory of the recordings asks for.
    return in_blocks(equations, opened, remembered(opened, equations)[0]) if settings.robust else equations


def with_friction(
    robot: Robot, recordings: Sequence[Recording], settings: Settings
) -> tuple[Observer, tuple[TermChoice, ...]]:
    """Give a robot the friction that the settings ask for: its payload observer, and which terms were tried.

    Of candidates those are kept that recordings show in blocks of time; none without blocks or measured friction.
    """
    asked, own = settings.friction, robot.drives.friction
    if not isinstance(asked, Candidates):
        return payload_observer(robot.with_friction(asked)), ()
    candidates = tuple(term for term in asked.terms if term.kind not in [one.kind for one in own])
    if not candidates or not own:
        return payload_observer(robot), ()
    settings.progress("choosing the friction's terms")
    base, wide = base_parameters(robot), robot.with_friction((*own, *candidates))
    processing, standard = settings.processing_of(robot), standard_columns(robot)
    columns = (*base.columns, *(name for name in standard_columns(wide) if name not in standard))
    every = Observer(wide, (*columns, *payload_columns(robot), PATH))
    observer = every.only(columns)
    try:
        check_recordings(robot, recordings)
        check_moving(robot, recordings)
        measured = [used(data, processing) for data in filtered(recordings, processing)]
        values = weighted_solution(recorded(observer.only(base.columns), measured)[0])
        equations, opened = recorded(observer.at(values), measured)
        equations = in_blocks(equations, opened, remembered(opened, equations)[0])
        if len(equations.blocks) < FEWEST:
            raise InputError(f"{len(equations.blocks)} blocks of time are too few to hold some out: record longer")
        terms, choices = chosen_terms(wide, candidates, equations)
    except InputError as error:  # what no estimate can do with either is refused there
        tried = (TermChoice(term.kind, False, why_not=f"{error}") for term in candidates)
        return payload_observer(robot), tuple(tried)
    robot = robot.with_friction((*own, *terms))
    return every.of(robot, observed_columns(robot)), choices


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
            slow = processing.rate is not None and processing.rate * np.ptp(recording.t) <= processing.decimate
            nothing = f"decimation by {factor} leaves nothing of {len(recording.t)} samples"
            advice = "raise rate" if slow else "raise equation-rate or record longer"
            raise InputError(f"{recording.source}: {nothing}: {advice}")


def check_moving(robot: Robot, recordings: Sequence[Recording]) -> None:
    """Refuse recordings in which some joint never moves."""
    still = still_joints(recordings)
    if len(still) == robot.n:
        raise InputError(f"{recordings[0].source}: no joint ever moves: record a motion of every joint")
    if still:
        hidden, length = hidden_by(robot, still), sum(float(np.ptp(one.t)) for one in recordings)
        names = ", ".join(hidden[:_NAMED]) + f" and {len(hidden) - _NAMED} more" * (len(hidden) > _NAMED)
        rest = f"joint {', '.join(map(str, still))} does not move within its {length:.2g} s"
        advice = "record 20 s or more in which every joint moves"
        raise InputError(f"{recordings[0].source}: {rest}, and {names} cannot be identified: {advice}")


def hidden_by(robot: Robot, still: Sequence[int]) -> tuple[str, ...]:
    """Base parameters that the motion leaves undetermined, alone or in sums, while some joints stand still."""
    base, rest = base_parameters(robot), np.array(still) - 1
    q, qd, qdd = random_states(robot, 12 * robot.n, seed=0)
    q[:, rest], qd[:, rest], qdd[:, rest] = 0.3, 0.0, 0.0
    W = stacked_regressor(robot, q, qd, qdd)[:, list(base.chosen)]
    # A joint that stands still holds any torque within its friction: its rows say nothing.
    moving = np.concatenate([np.full(len(q), j + 1 not in still) for j in range(robot.n)])
    hidden = decomposed(W[moving]).hidden
    return tuple(name for name, part in zip(base.names, hidden, strict=True) if part > 1e-12)
