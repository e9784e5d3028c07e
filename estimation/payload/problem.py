"""Long motions made of recordings: paired, filtered, reduced to [W W_L] of (22) and W_L of (29), cut in blocks."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...common.errors import InputError
from ...common.linear import decomposed
from ...model import INERTIAL, BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.friction import is_friction
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import PATH, Observer, Used, known_spring, used
from ..equations.reduction import Recorded, recorded
from ..fit.blocks import (
    FEWEST,
    SHORTEST,
    Remembered,
    block_edges,
    block_length,
    in_blocks,
    remembered,
    weighted_solution,
)
from ..fit.estimate import Estimate
from ..fit.friction import TermChoice, under_own_load
from ..fit.own_equations import check_lengths, check_moving, filtered, with_friction
from ..fit.settings import DEFAULTS, Settings
from ..signals.alignment import AlignedPair, aligned, best_aligned, check_mismatch
from ..signals.filtering import grid_rate, measurement
from ..signals.plausibility import check_apart, check_recordings
from ..signals.rows import Pieces, cut, origin, shortest_piece
from .long_motion import LongMotion, Source
from .under_load import robot_of

_TRIED = 12
"""Number of combinations of pieces that are aligned in search of the lag."""
_Recordings = tuple[Recording, ...]
_Load = tuple[Equations, list[Recorded]]
_Alike = tuple[_Recordings, _Recordings, tuple[float | None, ...]]
"""Recordings with and without payload, and the lag of each pair [s] where it is known."""


class PairedMeasurement(NamedTuple):
    """Measurements of one trajectory without and with payload, on the loaded recording's time.

    ``lag`` [s]: what the loaded recording's clock shows more than the unloaded one's own.
    """

    unloaded: Measurement
    loaded: Measurement
    lag: float = 0.0


def payload_problem(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: Estimate | None = None,
    settings: Settings = DEFAULTS,
) -> LongMotion:
    """Process recordings with and without payload and reduce them.

    Args:
        unloaded: recordings without; for method 3 the k-th file is the same trajectory as the k-th of ``loaded``.
        known: the robot's identified parameters, instead of or beside ``unloaded``; without robust standard
            deviations of its own there are none of the payload.

    Raises:
        InputError: if a recording cannot be used.
    """
    processing, progress, choices = settings.processing_of(robot), settings.progress, tuple[TermChoice, ...]()
    if known is not None:
        robot = robot.of_parameters(known.names)
    elif unloaded:
        robot, choices = with_friction(robot, unloaded, settings)
    progress("base parameters")
    base = base_parameters(robot)
    hidden = decomposed(base.effect_of(payload_columns(robot))).null
    if hidden.size:
        names = [kind for kind, size in zip(INERTIAL, np.abs(hidden).max(axis=1), strict=True) if size > 1e-6]
        raise InputError(
            f"no motion of {robot.name} shows {hidden.shape[1]} of a payload's ten directions "
            f"({', '.join(names)}): its joints do not turn the payload in enough ways"
        )
    for recordings in filter(None, (loaded, unloaded)):
        check_recordings(robot, recordings)
        check_lengths(recordings, processing)
        check_moving(robot, base, recordings)
    check_apart(loaded, unloaded)
    loaded, unloaded, lags = cut_alike(loaded, unloaded, processing)
    without, under_load = filtered(unloaded, processing, progress), filtered(loaded, processing, progress)
    progress("aligning recordings with and without payload")
    compared, together, reason = _together(loaded, unloaded, lags, under_load, processing)
    progress("cutting into blocks" if settings.robust else "reducing")
    robust = settings.robust and not (known is not None and known.robust is None)
    motion = long_motion(robot, under_load, without, together, replace(settings, robust=robust), known)
    if motion.unloaded and motion.unloaded.equations == 0:
        raise InputError(f"{unloaded[0].source}: no joint moves: nothing can be compared")
    source = Source(
        tuple(loaded), tuple(unloaded), processing, compared, reason, under_load[0].motion.rate, choices
    )
    return replace(motion, source=source, settings=settings)


def _together(
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    lags: Sequence[float | None],
    measured: Sequence[Measurement],
    processing: Processing,
) -> tuple[tuple[AlignedPair, ...], list[PairedMeasurement], str]:
    """Put recordings side by side, filter those of one trajectory for method 3; none, and why not."""
    pairs = tuple[AlignedPair, ...]()
    if not unloaded:
        return (), [], "no recordings without payload"
    try:
        if len(loaded) != len(unloaded):
            raise InputError(
                f"{len(unloaded)} recordings without and {len(loaded)} with payload do not form pairs: method 3 "
                "needs each trajectory once without and once with it, in the same order"
            )
        pairs = tuple(
            best_aligned(a, b, grid_rate(b, processing), lag)
            for a, b, lag in zip(unloaded, loaded, lags, strict=True)
        )
        together = []
        for pair, under_load in zip(pairs, measured, strict=True):
            check_mismatch(pair, processing.max_mismatch)
            # The loaded recording was filtered already, unless it was cut to what both have in common.
            whole = len(pair.loaded.t) == len(under_load.motion.t)
            under_load = under_load if whole else measurement(pair.loaded, processing)
            together.append(PairedMeasurement(measurement(pair.unloaded, processing), under_load, pair.lag))
        return pairs, together, ""
    except InputError as error:
        return pairs, [], str(error)


def cut_alike(loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing) -> _Alike:
    """Cut recordings with and without payload alike where gaps split those of one file into more pieces.

    They stay as they are where they form pairs already, or where no pairs can be made of them.

    Args:
        loaded: with payload, pieces of one file one after the other.
        unloaded: without; the k-th file is of the same trajectory as the k-th of ``loaded``.
    """
    whole: _Alike = tuple(loaded), tuple(unloaded), (None,) * len(loaded)
    # Pieces of one file are cut where either file has a gap, so that they form pairs.
    loaded_files, unloaded_files = (
        [tuple(own) for _, own in groupby(files, origin)] for files in (loaded, unloaded)
    )
    if len(loaded) == len(unloaded) or len(loaded_files) != len(unloaded_files):
        return whole
    try:
        pairs = [
            pair for a, b in zip(unloaded_files, loaded_files, strict=True) for pair in _pairs(a, b, processing)
        ]
    except InputError:  # no pair of one trajectory: method 3 refuses it where it is asked for
        return whole
    unloaded_pieces, loaded_pieces, lags = zip(*pairs, strict=True) if pairs else ((), (), ())
    return (loaded_pieces, unloaded_pieces, lags) if pairs else whole


def _pairs(
    unloaded: _Recordings, loaded: _Recordings, processing: Processing
) -> list[tuple[Recording, Recording, float | None]]:
    """Pair pieces of two files between the gaps of either, on the same stretches of the motion; find their lag."""
    if len(unloaded) == len(loaded) == 1:
        return [(unloaded[0], loaded[0], None)]
    lag = _lag(unloaded, loaded, processing)
    middles = (
        0.5 * float(before.t[-1] + after.t[0]) + ahead
        for pieces, ahead in ((loaded, 0.0), (unloaded, lag))
        for before, after in pairwise(pieces)
    )
    gaps = sorted(middles)
    least = shortest_piece(processing.cutoff)
    pairs: list[tuple[Recording, Recording, float | None]] = []
    for low, high in pairwise([-np.inf, *gaps, np.inf]):
        a = _within(unloaded, low - lag, high - lag, least, loaded[0])
        b = _within(loaded, low, high, least, unloaded[0])
        if a is not None and b is not None:
            pairs.append((a, b, lag))
    return pairs


def _lag(unloaded: _Recordings, loaded: _Recordings, processing: Processing) -> float:
    """Difference of the loaded file's clock from the unloaded one's [s], by pieces that are alike, longest first.

    Raises:
        InputError: if no two are of the same stretch of the motion.
    """
    choices = sorted(product(unloaded, loaded), key=lambda pair: -min(float(np.ptp(one.t)) for one in pair))
    for first, second in choices[:_TRIED]:
        try:
            return aligned(first, second, grid_rate(second, processing), processing.max_mismatch).lag
        except InputError:
            continue
    raise InputError(f"{origin(unloaded[0])} and {origin(loaded[0])} are not the same trajectory")


def _within(pieces: _Recordings, low: float, high: float, least: float, partner: Recording) -> Recording | None:
    """Cut out what of a file lies between two times [s] and is long enough; ``partner`` is named in a note."""
    for piece in pieces:
        rows = slice(*(int(row) for row in np.searchsorted(piece.t, [low, high])))
        if rows.stop - rows.start > 1 and piece.t[rows.stop - 1] - piece.t[rows.start] >= least:
            note = f"cut where {Path(origin(partner)).name} lacks rows, so that method 3 compares what both have"
            shorter = rows != slice(0, len(piece.t))
            return next(cut(piece, Pieces((rows,), (note,) if shorter else ())))
    return None


def loaded_observer(robot: Robot, base: BaseParameters) -> Observer:
    """Make the observer of [W W_L], columns base, then ``PAYLOAD``."""
    names = (*base.columns, *PAYLOAD)
    return Observer(robot, (*base.columns, *payload_columns(robot)), names)


def torque_change(robot: Robot, unloaded: Measurement, loaded: Measurement) -> Measurement:
    """Difference of torques Y_T - Y_wL on the loaded motion.

    The observer moves the spring's torque into Y; in a difference it is there twice, and the first goes along.
    """
    torque = loaded.torque - unloaded.torque
    spring = known_spring(robot)
    if spring is None:
        return Measurement(loaded.motion, torque)
    return Measurement(loaded.motion, torque, spring.torque(unloaded.motion.q[:, spring.joint - 1]))


def long_motion(
    robot: Robot,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement] = (),
    pairs: Sequence[PairedMeasurement] = (),
    settings: Settings = DEFAULTS,
    known: Estimate | None = None,
) -> LongMotion:
    """Reduce measurements, in blocks of time where robust; those of a pair at the same points of the motion.

    Args:
        loaded: with payload, each on its own time.
        unloaded: without; where there are pairs, the k-th is that of the k-th pair.
        pairs: for method 3.
        known: the robot's parameters; without unloaded measurements the errors are those that they leave.
    """
    base, processing = base_parameters(robot), settings.processing_of(robot)
    observer = Observer(robot, (*base.columns, *payload_columns(robot), PATH))
    both = observer.only((*base.columns, *payload_columns(robot)), (*base.columns, *PAYLOAD))
    loads, chi = dict[str, _Load](), np.zeros(len(base.columns))
    if unloaded:
        loads["unloaded"], chi = under_own_load(
            observer.only(base.columns), lambda own: recorded(own, (used(data, processing) for data in unloaded))
        )
    elif known is not None:
        chi = known.values
    loads["loaded"], values = under_own_load(
        both, lambda own: recorded(own, (used(data, processing) for data in loaded)), chi
    )
    if pairs:
        loads["difference"] = _changes(observer.at(values), base, pairs, loads["unloaded"][0], processing)
    parts: dict[str, Any] = {name: equations for name, (equations, _) in loads.items()}
    source = Source((), (), processing)
    carried = values[len(base.columns) :]
    motion = LongMotion(robot, base, **parts, source=source, known=known, settings=settings, carried=carried)
    if not settings.robust:
        return motion
    # Memory is judged by what W alone leaves; of a difference, by what is left without friction.
    judged = {"loaded": base.columns, "unloaded": base.columns, "difference": (*PAYLOAD, PATH)}
    memory = {
        name: remembered(recordings, equations.select(judged[name]))
        for name, (equations, recordings) in loads.items()
    }
    spans, length = memory["loaded"].spans, block_length(list(memory.values()))
    # Where blocks that are as long as memory asks for are too few under load, shorter ones are cut.
    few = sum(len(block_edges(ends, length)) - 1 for ends in spans) < FEWEST
    length = SHORTEST if few else length
    edges = {"loaded": [block_edges(ends, length) for ends in spans]}
    edges["difference"] = edges["loaded"]
    if pairs:  # where their partners are, on the clock without payload
        edges["unloaded"] = [ends - pair.lag for ends, pair in zip(edges["loaded"], pairs, strict=True)]
    elif unloaded:
        edges["unloaded"] = [block_edges(ends, length) for ends in memory["unloaded"].spans]
    parts = {name: in_blocks(*load, edges[name], length) for name, load in loads.items()}
    inflation = memory["loaded"].inflation
    if known is not None and not unloaded:
        inflation = _inflation_of_known(known, *loads["loaded"])
    return replace(motion, **parts, inflation=inflation, few=few)


def _inflation_of_known(known: Estimate, equations: Equations, recordings: Sequence[Recorded]) -> tuple[float, ...]:
    """Inflation by memory of each joint's errors where the robot is known.

    By what it leaves of the loaded recordings, payload and friction found with it: all of its parameters, found
    anew in a few seconds, would take up the slow errors for themselves. A few seconds of load show less memory than
    the robot's own recordings did.
    """
    rigid = [k for k, name in enumerate(known.names) if not is_friction(name)]
    rest = equations.minus([known.names[k] for k in rigid], known.values[rigid])
    values = dict(zip(known.names, known.values, strict=True))
    values |= zip(rest.columns, weighted_solution(rest), strict=True)
    chi = np.array([values[name] for name in equations.columns])
    own = Remembered.of([recording.residuals(chi) for recording in recordings]).inflation
    if known.robust is None:
        return own
    before = float(np.median((known.robust.sigma / np.maximum(known.sigma, 1e-300)) ** 2))
    return tuple(max(factor, before) for factor in own)


def _changes(
    observer: Observer,
    base: BaseParameters,
    pairs: Sequence[PairedMeasurement],
    unloaded: Equations,
    processing: Processing,
) -> tuple[Equations, list[Recorded]]:
    """Equations (29) of pairs, Y_T - Y_wL, the torque that the robot needs more on the loaded path taken off.

    Friction's columns, of the loaded path, stand behind the payload's.
    """
    friction = [name for name in base.columns if is_friction(name)]
    own, chi = weighted_solution(unloaded), robot_of(unloaded)
    grows = [k for k, name in enumerate(base.columns) if parameter_kind(name) in observer.robot.drives.loaded]
    chi[grows] = own[grows]  # by which the payload's load makes friction differ
    with_load, without = observer.only(base.columns), observer.only(base.columns).at(own)

    def change(pair: PairedMeasurement) -> Used:
        loaded = used(pair.loaded, processing, pair.unloaded.motion)
        path = with_load.torques(pair.loaded.motion, chi) - without.torques(pair.unloaded.motion, chi)
        return loaded._replace(data=replace(torque_change(observer.robot, pair.unloaded, pair.loaded), path=path))

    columns = (*payload_columns(observer.robot), PATH, *friction)
    return recorded(observer.only(columns, (*PAYLOAD, PATH, *friction)), map(change, pairs))
