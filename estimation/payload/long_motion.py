"""A payload moved by every joint: recordings reduced to the equations that the methods of section V take.

[W W_L] of (22) with payload, W without, and W_L of (29) for pairs on one trajectory, all cut in blocks of time.

An arm that sags does not run the motion it ran without payload. The difference of the torques then holds
Phi(q_L) chi - Phi(q_U) chi of the robot itself, about 100 N·m/rad at the second joint, and repeats with the motion:
no block of time shows it. It is taken off by parameters fitted to the recording without payload, but for a quarter.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...common import Array, Brief, InputError, decomposed, frozen_array, one_thread
from ...common.errors import listed
from ...common.schema import naming
from ...model import BaseParameters, InertialParameters, Pose, Processing, Recording, Robot, base_parameters
from ...model.drives import joint_of, parameter_kind
from ...model.friction import is_friction
from ...model.inertia import INERTIAL
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations, merged
from ..equations.observer import PATH, Observation, Observer, Used, known_spring, recorded, reduced, used
from ..fit import covariance
from ..fit.covariance import weighted_solution
from ..fit.estimate import Estimate, Fit, error_model
from ..fit.linear_problem import Known, SoftPrior, left_out, weighted
from ..fit.own_equations import TermChoice, check_moving, filtered, payload_observer, under_own_load, with_friction
from ..fit.settings import DEFAULTS, Settings
from ..signals.filtering import AlignedPair, aligned, check_mismatch, grid_rate, measurement
from ..signals.recordings import check_given, check_recordings, cut, origin, shortest_piece, without_dead

_TRIED = 12  # number of combinations of pieces that are aligned in search of the lag
Recordings = Sequence[Recording]


class Source(NamedTuple):
    """Recordings with and without payload, their processing, and both side by side."""

    loaded: tuple[Recording, ...]
    unloaded: tuple[Recording, ...]
    processing: Processing
    compared: tuple[AlignedPair, ...] = ()  # of one trajectory, those that method 3 refuses among them
    why_no_pair: str = ""  # why method 3 cannot be used, if it cannot
    rate: float | None = None  # Hz, at which the first loaded recording was processed
    choices: tuple[TermChoice, ...] = ()  # terms of friction that were tried on those without payload

    @property
    def pairs(self) -> tuple[AlignedPair, ...]:
        """Alignment of the recordings of method 3; none where it refuses them."""
        return () if self.why_no_pair else self.compared


@dataclass(frozen=True, eq=False, repr=False)
class LongMotion(Brief):
    """Reduced equations of recordings in which every joint moves.

    With blocks of time, those of a pair of recordings are the same stretches of one motion.
    """

    robot: Robot
    base: BaseParameters  # their columns make up W
    loaded: Equations  # [W W_L] of (22) with payload in frame n; columns base, then ``PAYLOAD``
    source: Source
    unloaded: Equations | None = None  # W without payload, for methods 1, 2 and 4
    difference: Equations | None = None  # W_L of (29) for method 3, if a pair on one trajectory is there
    runs: tuple[Equations, ...] = ()  # ``difference`` pair by pair, where there are several in blocks of time
    known: Estimate | None = None  # the robot, identified earlier: for method 1, beside ``unloaded`` too
    settings: Settings = DEFAULTS
    # Payload under whose load friction is, its ten in frame n; zero where none grows with load.
    carried: Array = field(default_factory=lambda: np.zeros(len(PAYLOAD)))
    inflation: tuple[float, ...] = ()  # of variances by the memory of each joint's errors under load
    few: bool = False  # blocks as long as that memory asks for would be too few, so that shorter ones were cut

    def __post_init__(self) -> None:
        """Refuse blocks of one motion that are not as many, and another model's robot."""
        counts = {len(part.blocks) for part in (self.loaded, self.unloaded, self.difference) if part}
        if self.difference and self.difference.blocks and self.loaded.blocks and len(counts) > 1:
            raise ValueError("paired blocks must be as many without and with payload")
        check_known(self.robot, self.base, self.known)

    @property
    def why_no_pair(self) -> str:
        """Reason why method 3 cannot be used, if it cannot."""
        if self.settings.scale_sigma > 0.0:
            free = "the scale of the loaded torques is free (--scale-sigma)"
            return f"{free}, of which a difference of torques knows nothing"
        return self.source.why_no_pair

    @cached_property
    def bare(self) -> Estimate | None:
        """Estimate the robot's own parameters by the recordings without payload."""
        with naming(listed([one.source for one in self.source.unloaded], 3) or "without payload"):
            return None if self.unloaded is None else weighted(self.unloaded)

    @property
    def robot_estimate(self) -> Estimate | None:
        """Robot's own parameters: by recordings without payload, else those of an earlier identification."""
        return self.bare or self.known

    @property
    def robot_known(self) -> Known:
        """Robot's parameters for method 1: from an earlier identification, else without payload."""
        own, unloaded = self.bare, self.unloaded
        if self.known is not None:
            return stored_robot(self.known)
        if own is None or unloaded is None:
            raise InputError(
                "method 1 needs the robot's parameters: give a recording without payload or --robot-parameters"
            )

        # Blocks of time hold the recording they come from.
        def each() -> Array:
            return np.array([x[:, 0] for x, _ in left_out(unloaded, own.names, own.weights)[:-1]])

        lasting = 0.0 * own.covariance
        return stored_robot(own)._replace(lasting=lasting, left_out=each if unloaded.blocks else None)

    @property
    def corrected(self) -> bool:
        """True if a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.friction)

    @cached_property
    def friction(self) -> Mapping[str, SoftPrior]:
        """Frictions of the robot that may be others under load, and how far."""
        with suppress(InputError):  # by method 3 the robot is not needed
            if self.inflation and (robot := self.robot_estimate) is not None:
                return friction_changes(robot, self.inflation, self.settings.friction_change)
        return {}

    @cached_property
    def both(self) -> Equations:
        """Join the equations of (30), robot and payload together, columns base, then ``PAYLOAD``."""
        return self.with_unloaded(self.loaded)

    def with_unloaded(self, loaded: Equations) -> Equations:
        """Join equations with payload and those without, whose other columns are zero."""
        if self.unloaded is None:
            raise InputError("method 4 needs a recording without payload")
        unloaded = self.unloaded.select(loaded.columns)
        if not (self.difference and unloaded.blocks and loaded.blocks):  # not of one motion
            return merged([unloaded, loaded])
        both = tuple(map(merged, zip(unloaded.blocks, loaded.blocks, strict=True)))
        return replace(merged([unloaded.whole, loaded.whole]), blocks=both, block_length=loaded.block_length)

    @property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time with payload, and without, that are left out in turn, -1 for none, group by group.

        Blocks that share no motion are left out one recording at a time, without payload first, as in method 4.
        """
        loaded, unloaded = len(self.loaded.blocks), len(self.unloaded.blocks) if self.unloaded else 0
        if self.difference:
            return (tuple((b, b if unloaded else -1) for b in range(loaded)),)
        groups = tuple((-1, b) for b in range(unloaded)), tuple((b, -1) for b in range(loaded))
        return tuple(filter(None, groups))


def measured_part(known: Estimate, robot: Robot) -> Estimate:
    """Take a robot known earlier in the base parameters that are left where joints' torques are not measured.

    Raises:
        InputError: if its parameters are not those of this model.
    """
    if not known.fit.rows:  # values of the user's own owe nothing to the errors of any joint's gain
        S, none = np.zeros((len(known.values), robot.n)), np.zeros(robot.n)
        known = replace(known, fit=Fit(none, none, (0,) * robot.n), gain_sensitivity=S)
    base = base_parameters(robot)
    if robot.drives.unmeasured and set(known.names) <= set(base.standard):
        return known.mapped(base.effect_of(known.names), base.columns)
    check_known(robot, base, known)
    return known


def check_known(robot: Robot, base: BaseParameters, known: Estimate | None) -> None:
    """Refuse parameters that are not those of this model."""
    if known is not None and known.names != base.columns:
        missing = sorted(set(known.names) ^ set(base.columns)) or ["their order"]
        raise InputError(
            f"the stored robot parameters are of another model of {robot.name}: they differ in "
            f"{', '.join(missing[:8])}: identify the robot again with the same options"
        )


def stored_robot(robot: Estimate) -> Known:
    """Parameters of an earlier identification; no block of time shows their error, robust where it is known."""
    C = robot.covariance
    lasting = robot.robust.covariance if robot.robust else C
    return Known(robot.names, robot.values, C, lasting, robot.degrees_of_freedom, robot.gain_sensitivity)


def prior_of(known: Estimate | None, inflation: tuple[float, ...], loaded: Equations) -> Known:
    """Prior of a robot known earlier, by the covariance that its errors really have, of full rank.

    The memory of errors, ``inflation``, is the middle one of the joints that have equations.
    """
    assert known is not None
    factors = [factor for factor, rows in zip(inflation, loaded.rows, strict=True) if rows]
    model = error_model(replace(known, gain_covariance=None))
    return stored_robot(model)._replace(inflation=float(np.median(factors)))


class PairedMeasurement(NamedTuple):
    """Measurements of one trajectory without and with payload, on the loaded recording's time."""

    unloaded: Measurement
    loaded: Measurement
    lag: float = 0.0  # what the loaded recording's clock shows more than the unloaded one's own [s]


def torque_change(robot: Robot, unloaded: Measurement, loaded: Measurement, path: Array) -> Measurement:
    """Difference of torques Y_T - Y_wL on the loaded motion; ``path``: by which the robot's own differ there.

    The observer moves the spring's torque into Y; in a difference it is there twice, and the first goes along.
    """
    spring = known_spring(robot)
    earlier = None if spring is None else spring.torque(unloaded.motion.q[:, spring.joint - 1])
    return Measurement(loaded.motion, loaded.torque - unloaded.torque, earlier, path)


def cut_alike(
    loaded: Recordings, unloaded: Recordings, processing: Processing
) -> tuple[Recordings, Recordings, Sequence[float | None]]:
    """Cut recordings alike where gaps split those of one file into more pieces; give the known lags [s] besides.

    They stay as they are where they form pairs already, or where no pairs can be made of them. The pieces of a file
    follow each other; the k-th file without payload is of the trajectory of the k-th with it.
    """
    whole = tuple(loaded), tuple(unloaded), (None,) * len(loaded)
    files = [[[*own] for _, own in groupby(recordings, origin)] for recordings in (unloaded, loaded)]
    if len(loaded) == len(unloaded) or len(files[0]) != len(files[1]):
        return whole
    with suppress(InputError):  # no pair of one trajectory: method 3 refuses it where it is asked for
        if pairs := [pair for a, b in zip(*files, strict=True) for pair in _pieces(a, b, processing)]:
            unloaded_pieces, loaded_pieces, lags = zip(*pairs, strict=True)
            return loaded_pieces, unloaded_pieces, lags
    return whole


def _pieces(
    unloaded: Recordings, loaded: Recordings, processing: Processing
) -> Iterator[tuple[Recording, Recording, float | None]]:
    """Pair pieces of two files between the gaps of either, on the same stretches of the motion, lags besides."""
    if len(unloaded) == len(loaded) == 1:
        yield unloaded[0], loaded[0], None
        return
    # The lag of the files' clocks is that of two pieces that are alike, the longest first.
    longest = sorted(product(unloaded, loaded), key=lambda pair: -min(float(np.ptp(one.t)) for one in pair))
    for a, b in longest[:_TRIED]:
        with suppress(InputError):
            lag = aligned(a, b, grid_rate(b, processing), processing.max_mismatch).lag
            break
    else:
        raise InputError(f"{origin(unloaded[0])} and {origin(loaded[0])} are not the same trajectory")
    gaps = sorted(
        0.5 * float(before.t[-1] + after.t[0]) + ahead
        for pieces, ahead in ((loaded, 0.0), (unloaded, lag))
        for before, after in pairwise(pieces)
    )
    least = shortest_piece(processing.cutoff)

    def within(pieces: Recordings, low: float, high: float, partner: Recording) -> Recording | None:
        """Cut out what of a file lies between two times and is long enough; ``partner`` is named in a note."""
        for piece in pieces:
            rows = slice(*np.searchsorted(piece.t, [low, high]).tolist())
            if rows.stop - rows.start > 1 and np.ptp(piece.t[rows]) >= least:
                lacking = f"cut where {Path(origin(partner)).name} lacks rows"
                note = f"{lacking}, so that method 3 compares what both have"
                return next(cut(piece, [rows], [note] * (rows != slice(0, len(piece.t)))))
        return None

    for low, high in pairwise([-np.inf, *gaps, np.inf]):
        without = within(unloaded, low - lag, high - lag, loaded[0])
        if without and (under_load := within(loaded, low, high, unloaded[0])):
            yield without, under_load, lag


@one_thread()
def payload_problem(
    robot: Robot,
    loaded: Recordings,
    unloaded: Recordings = (),
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

    >>> payload_problem(robot, loaded, unloaded).base.columns[0]
    'ZZ1'
    """
    check_given(robot, loaded, unloaded)
    processing, progress, choices = settings.processing_of(robot), settings.progress, tuple[TermChoice, ...]()
    robot = without_dead(robot, [*loaded, *unloaded])
    if unloaded and known is None:
        observer, choices = with_friction(robot, unloaded, settings)
    else:
        observer = payload_observer(robot if known is None else robot.of_parameters(known.names))
    robot = observer.robot
    progress("base parameters")
    base = base_parameters(robot)
    known = None if known is None else measured_part(known, robot)
    hidden = decomposed(base.effect_of(payload_columns(robot))).null
    if hidden.size:
        names = ", ".join(np.array(INERTIAL)[np.abs(hidden).max(axis=1) > 1e-6])
        raise InputError(
            f"no motion of {robot.name} shows {hidden.shape[1]} of a payload's ten directions ({names}): its "
            "joints do not turn the payload in enough ways"
        )
    check_recordings(robot, *filter(None, (loaded, unloaded)))
    loaded, unloaded, lags = cut_alike(loaded, unloaded, processing)
    without, under_load = filtered(unloaded, processing, progress), filtered(loaded, processing, progress)
    progress("aligning recordings with and without payload")
    compared, together, reason = tuple[AlignedPair, ...](), list[PairedMeasurement](), ""
    try:
        if not unloaded:
            raise InputError("no recordings without payload")
        if len(loaded) != len(unloaded):
            raise InputError(
                f"{len(unloaded)} recordings without and {len(loaded)} with payload do not form pairs: method 3 "
                "needs each trajectory once without and once with it, in the same order"
            )
        each = zip(unloaded, loaded, lags, strict=True)
        compared = tuple(aligned(a, b, grid_rate(b, processing), near=lag) for a, b, lag in each)
        for pair, data in zip(compared, under_load, strict=True):
            check_mismatch(pair, processing.max_mismatch)
            # The loaded recording was filtered already, unless it was cut to what both have in common.
            whole = len(pair.loaded.t) == len(data.motion.t)
            with_load = data if whole else measurement(pair.loaded, processing)
            together.append(PairedMeasurement(measurement(pair.unloaded, processing), with_load, pair.lag))
    except InputError as error:
        together, reason = [], str(error)
        if 3 in (settings.methods or ()):
            raise InputError(f"method 3 cannot be used: {reason}") from None
    for recordings in filter(None, (loaded, unloaded)):
        check_moving(robot, recordings)
    progress("cutting into blocks" if settings.robust else "reducing")
    robust = settings.robust and (known is None or known.robust is not None)
    motion = long_motion(observer, under_load, without, together, replace(settings, robust=robust), known)
    if motion.unloaded and motion.unloaded.equations == 0:
        raise InputError(f"{unloaded[0].source}: no joint moves: nothing can be compared")
    rate = under_load[0].motion.rate
    source = Source(tuple(loaded), tuple(unloaded), processing, compared, reason, rate, choices)
    return replace(motion, source=source, settings=settings)


def long_motion(
    observer: Observer,
    loaded: Sequence[Measurement],
    unloaded: Sequence[Measurement] = (),
    pairs: Sequence[PairedMeasurement] = (),
    settings: Settings = DEFAULTS,
    known: Estimate | None = None,
) -> LongMotion:
    """Reduce measurements, in blocks of time where robust; those of a pair at the same points of the motion.

    ``observer``: of robot, payload and ``PATH``; ``known``: the robot. Where there are ``pairs``, the k-th unloaded
    measurement is that of the k-th pair.
    """
    robot = observer.robot
    base, processing, ten = base_parameters(robot), settings.processing_of(robot), payload_columns(robot)
    both = observer.only((*base.columns, *ten), (*base.columns, *PAYLOAD))
    loads, chi = dict[str, tuple[Equations, list[Observation]]](), np.zeros(len(base.columns))
    of_unloaded, of_loaded = ([used(data, processing) for data in group] for group in (unloaded, loaded))
    if unloaded:
        loads["unloaded"], chi = under_own_load(observer.only(base.columns), of_unloaded)
    elif known is not None:
        chi = known.values
    loads["loaded"], values = under_own_load(both, of_loaded, chi)
    if pairs:
        # (29), Y_T - Y_wL, the torque that the robot needs more on the loaded path taken off.
        bare, under_load, changes = loads["unloaded"][0], observer.at(values), list[Used]()
        own, more, friction = weighted_solution(bare), robot_of(bare), list(filter(is_friction, base.columns))
        grows = [k for k, name in enumerate(base.columns) if parameter_kind(name) in robot.drives.loaded]
        more[grows] = own[grows]  # by which the payload's load makes friction differ
        with_load, without = under_load.only(base.columns), under_load.only(base.columns).at(own)
        for pair in pairs:
            path = with_load.torques(pair.loaded.motion, more) - without.torques(pair.unloaded.motion, more)
            data = torque_change(robot, pair.unloaded, pair.loaded, path)
            changes.append(used(pair.loaded, processing, pair.unloaded.motion)._replace(data=data))
        names = (*PAYLOAD, PATH, *friction)
        loads["difference"] = recorded(under_load.only((*ten, PATH, *friction), names), changes)
    parts: dict[str, Any] = {name: equations for name, (equations, _) in loads.items()}
    source, carried = Source((), (), processing), values[len(base.columns) :]
    motion = LongMotion(robot, base, **parts, source=source, known=known, settings=settings, carried=carried)
    if not settings.robust:
        return motion
    # Memory is judged by what W alone leaves; of a difference, by what is left without friction.
    judged, memory = {"difference": (*PAYLOAD, PATH)}, dict[str, tuple[float, tuple[float, ...]]]()
    for name, (equations, recordings) in loads.items():
        memory[name] = covariance.remembered(recordings, equations.select(judged.get(name, base.columns)))
    length = max(own for own, _ in memory.values())
    # Where blocks that are as long as memory asks for are too few under load, shorter ones are cut.
    few = sum(len(covariance.block_edges(one, length)) - 1 for one in loads["loaded"][1]) < covariance.FEWEST
    length = covariance.SHORTEST if few else length
    edges = {name: [covariance.block_edges(one, length) for one in load[1]] for name, load in loads.items()}
    if pairs:  # where their partners are, on the clock without payload
        edges["difference"] = edges["loaded"]
        edges["unloaded"] = [ends - pair.lag for ends, pair in zip(edges["loaded"], pairs, strict=True)]
    parts = {name: covariance.in_blocks(*load, length, edges[name]) for name, load in loads.items()}
    if len(pairs) > 1:
        each = zip(loads["difference"][1], edges["difference"], strict=True)
        parts["runs"] = tuple(covariance.in_blocks(reduced(own), [own], length, [ends]) for own, ends in each)
    _, inflation = memory["loaded"]
    if known is not None and not unloaded:
        # By what a known robot leaves of the loaded recordings, payload and friction found with it: all of its
        # parameters, found anew in a few seconds, would take up the slow errors for themselves.
        equations, recordings = loads["loaded"]
        rigid = [k for k, name in enumerate(known.names) if not is_friction(name)]
        rest = equations.minus([known.names[k] for k in rigid], known.values[rigid])
        chi = np.append(known.values, np.zeros(len(PAYLOAD)))
        chi[[equations.columns.index(name) for name in rest.columns]] = weighted_solution(rest)
        _, inflation = covariance.remembered(recordings, chi)
        if known.robust is not None:  # a few seconds of load show less memory than its own recordings did
            before = float(np.median((known.robust.sigma / np.maximum(known.sigma, 1e-300)) ** 2))
            inflation = tuple(max(factor, before) for factor in inflation)
    return replace(motion, **parts, inflation=inflation, few=few)


_UNSURE = 0.25  # fraction of the path's correction that may be wrong (1 sigma)
_SMALL = 1e-3  # smallest singular value over the largest, columns scaled, that recordings without payload show
_OFFSETS = 0.012  # sigma of a constant torque's change, of the arm's largest Coulomb friction: .2 N·m on a UR10e
_NONE = 1e-9  # fraction of the arm's largest friction below which a joint has none


def robot_of(unloaded: Equations) -> Array:
    """Estimate the robot's parameters, (c,), by a recording without payload, as far as shown, friction zero.

    Joints weigh by their torques: weights by residuals would fall for a joint that is explained by chance.
    """
    rms = unloaded.torque_norms / np.sqrt(np.maximum(unloaded.rows, 1))
    factor = unloaded.stacked(np.divide(1.0, rms, out=np.zeros_like(rms), where=rms > 0.0))
    W = factor[:, :-1]
    largest = np.full(W.shape[1], np.linalg.norm(W, axis=0).max(initial=0.0))  # beside which rounding is nothing
    values = decomposed(W, largest, _SMALL).solution(factor[:, -1])
    return np.where([is_friction(name) for name in unloaded.columns], 0.0, values)


def known_path(joints: int) -> Known:
    """Prior of the torque of paths that differ: nothing of it is left, but for a quarter."""
    zero = np.zeros((1, 1))
    return Known((PATH,), zero[0], zero, zero + _UNSURE**2, gain_sensitivity=np.zeros((1, joints)))


def friction_changes(robot: Estimate, inflation: Sequence[float], ratio: float) -> dict[str, SoftPrior]:
    """Priors that keep frictions near the robot's own, by the memory of errors; without a ``ratio`` none changes.

    Coulomb and viscous friction change with the day and the oil's temperature: left as it was, what it changed by
    goes into the payload; wholly free, it takes most of what a motion tells of the mass. What grows with load is
    known; free as well, it would take weight along. What a joint lacks cannot change.
    """
    every = [(name, parameter_kind(name), abs(robot[name])) for name in robot.names]
    largest = max((size for _, kind, size in every if kind == "FS"), default=0.0)
    sigmas = {name: ratio * size for name, kind, size in every if kind in ("FS", "FV", "FSM", "FVM")}
    if ratio > 0.0:
        sigmas |= {name: _OFFSETS * largest for name, kind, _ in every if kind == "OFF"}
    least = _NONE * largest
    return {name: SoftPrior(sigma, inflation[joint_of(name)]) for name, sigma in sigmas.items() if sigma > least}


def in_payload_frame(robot: Robot, equations: Equations) -> Equations:
    """Transform equations whose payload stands in frame n to the ten parameters about ``robot.payload_frame``."""
    if robot.flange.is_identity:
        return equations
    indices, M = [equations.columns.index(name) for name in PAYLOAD], np.eye(len(equations.columns))
    M[np.ix_(indices, indices)] = frame_change(robot.flange)
    return equations.transformed(M, equations.columns)


@lru_cache(maxsize=64)
def frame_change(pose: Pose) -> Array:
    """Matrix that changes the frame of a body's ten parameters, 10 x 10; ``pose``: of theirs in the one wanted."""
    columns = [InertialParameters(unit).moved(pose.R, pose.p).vector for unit in np.eye(10)]
    return frozen_array(np.column_stack(columns), (10, 10), "change of frame")
