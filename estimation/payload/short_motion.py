"""A payload moved by some joints near a pose: friction is free in each recording, not all ten need be visible.

Left wholly free, a constant torque takes the weight of a payload for itself where gravity hardly varies, as in ten
seconds of a slow arm. It is what dry friction differs by from one direction to the other, so that it changes from
one recording to the next by a fraction of that friction, which the recording without payload shows. It enters as
one more equation for each joint of the arm, and what it may change by widens the intervals; where the recordings
say that it changed more, it is free.

Ripple is periodic in a joint's position. What changes of it with the load repeats with the motion: no block of time
shows it, and it moves the mass. Waves that a joint's equations clearly hold are therefore estimated, one after the
other, each with all that a slightly wrong wavelength would leave. Less than one wave over the joint's range is no
different from weight and is not looked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from msgspec import field
from scipy.special import chdtrc, fdtrc

from ...common import Array, Brief, Document, Float, InputError, Vector, decomposed, without
from ...common.progress import each
from ...model import BaseParameters, Motion, Recording, Robot, base_parameters
from ...model.base import PayloadVisibility, check_mass_visible, friction_columns, visibility_of
from ...model.drives import joint_of, parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.equations import FREE, PAYLOAD, Equations, compressed, merged
from ..equations.observer import PATH, Observation, Observer, Used, reduced, used
from ..fit.covariance import in_blocks, inflation, remembered, weighted_solution
from ..fit.estimate import Estimate
from ..fit.linear_problem import Known, LinearProblem, SoftPrior
from ..fit.own_equations import check_lengths, filtered, under_own_load
from ..fit.settings import DEFAULTS, Settings
from ..possible.constraints import KnownMass
from ..signals.filtering import aligned, decimated, grid_rate, measurement, moving_parts
from ..signals.recordings import check_recordings, without_dead
from . import long_motion

OFFSET_SHARE = 0.033
"""Standard deviation of the change between two recordings over a joint's Coulomb friction.

Measured without any payload (benchmarks/constant_torques.py): constant torques of the UR10e's joints 1 to 3
scatter by 2.3 % of it from 10 s to 10 s beyond their noise (90 % interval 1.1 to 4.1 %); the difference of two by
sqrt(2) more.
"""
_WRIST = 3  # last joints, always free: their torque shifts the centre of mass, and the TX40's scatter by 17 %
_CONTRADICTED = 1e-3  # probability of what the recordings say, below which the constant torques are free
_FEWEST_LEFT = 6  # rows of a joint beyond its free columns; fewer may be fitted exactly, and show no errors
_HIDDEN = 1e-6  # fraction of a friction in undetermined directions above which it is not known


@dataclass(frozen=True, eq=False, repr=False)
class HeldFriction(Brief):
    """Prior near zero on what is free in each recording."""

    held: Mapping[str, SoftPrior]  # of constant torques and frictions; the others are wholly free
    noise: Array  # of each joint's rows [N·m or N], shape (n,); 0 where too few rows tell it
    memory: Array  # by how much the memory of each joint's errors raises variances, shape (n,)

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations of what constant torques may be [N·m or N], shape (n,); 0 where they are free."""
        roles = (self.held.get(f"OFF{j}") for j in range(1, len(self.noise) + 1))
        return np.array([role.sigma if role else 0.0 for role in roles])

    @property
    def known(self) -> Known:
        """Values of the prior: zero, as far as sigma says; alike in all recordings, to be safe."""
        k, n = len(self.held), len(self.noise)
        lasting = np.diag([role.sigma**2 for role in self.held.values()])
        names = tuple(f"level of {name}" for name in self.held)
        return Known(names, np.zeros(k), np.zeros((k, k)), lasting, gain_sensitivity=np.zeros((k, n)))

    def friction_free(self, equations: Equations) -> Equations:
        """Take off all that constant torques, friction and ripple of one recording can explain, joint by joint.

        This is exact where joints have ``FREE`` columns of their own. Each prior is one more equation: the friction
        is its own ``known`` value, as sure as noise and memory allow. Blocks of time are not kept: their rests hang
        together.
        """
        names, levels = equations.columns, self.known.names
        gone, rest = ([k for k, x in enumerate(names) if x.startswith(FREE) is free] for free in (True, False))
        factors, ranks, shared = [], [], dict[tuple[int, int], Array]()
        for j, factor in enumerate(equations.factors):
            others, none = [key for key in equations.shared if key[0] == j], np.zeros((len(factor), len(levels)))
            apart = [equations.shared[key] for key in others]
            rows = np.column_stack([factor[:, [*gone, *rest]], none, factor[:, -1], *apart])
            for k, (name, role) in enumerate(self.held.items(), start=len(names)):
                if joint_of(name) == j:  # weight (friction - level) = 0
                    near, weight = np.zeros(rows.shape[1]), float(self.noise[j]) * role.weight
                    near[[gone.index(names.index(f"{FREE}{name}")), k]] = weight, -weight
                    rows = np.vstack([rows, near])
            left, parts = compressed(without(rows[:, len(gone) :], rows[:, : len(gone)]), len(others))
            factors.append(left)
            shared |= zip(others, parts.T, strict=True)
            ranks.append(len(decomposed(factor[:, gone]).singular))
        counts = tuple(max(own - rank, 0) for own, rank in zip(equations.rows, ranks, strict=True))
        effective = tuple(max(own - rank, 0.0) for own, rank in zip(equations.effective_rows, ranks, strict=True))
        return Equations((*(names[k] for k in rest), *levels), tuple(factors), counts, effective, shared)


def friction_prior(observations: Sequence[Observation], sigmas: Mapping[str, float]) -> HeldFriction:
    """Make the prior of friction near zero with standard deviations by name [N·m or N, or per speed].

    ``observations``: with free columns of each joint, ``PAYLOAD`` and no other, or ``PATH`` besides.
    """
    left = [one.eliminate() for one in observations]
    problem = merged(map(reduced, left)).select(PAYLOAD)
    values, spare = weighted_solution(problem), np.array(problem.rows)
    noise = problem.error_norms(values) / np.sqrt(np.maximum(spare, 1))
    for one in observations:
        free = [name.startswith(FREE) for name in one.columns]
        spare -= [int(W[:, free].any(axis=0).sum()) for W in one.W]
    noise[spare < _FEWEST_LEFT] = 0.0  # too few rows, beyond the free columns that act on them, to tell it
    memory = np.array(remembered(left, values)[1])
    told = {name: sigma for name, sigma in sigmas.items() if sigma > 0.0 and noise[joint_of(name)] > 0.0}
    roles = {name: SoftPrior(sigma, float(memory[joint_of(name)])) for name, sigma in told.items()}
    return HeldFriction(roles, noise, memory)


def offset_prior(observations: Sequence[Observation], coulomb: Array) -> HeldFriction:
    """Make the prior of the arm's constant torques near zero; wholly free where the recordings contradict that.

    ``coulomb``: friction of each joint without payload [N·m or N], shape (n,); 0 where it is not known.
    """
    arm = coulomb[: max(len(coulomb) - _WRIST, 1)].tolist()
    prior = friction_prior(observations, {f"OFF{j}": OFFSET_SHARE * level for j, level in enumerate(arm, start=1)})
    weighty, n = prior.noise * np.sqrt(prior.memory), len(prior.noise)
    weights = np.divide(1.0, weighty, out=np.zeros(n), where=weighty > 0.0)
    free = HeldFriction({}, np.zeros(n), np.ones(n))
    factors, count, rise = [reduced(one) for one in observations], np.count_nonzero(prior.sigma), 0.0
    for held, sign in ((prior, 1.0), (free, -1.0)):
        left = merged(map(held.friction_free, factors)).select(PAYLOAD).stacked(weights)
        rise += sign * float(np.sum(without(left[:, -1:], left[:, :-1]) ** 2))
    return free if count and chdtrc(count, max(rise, 0.0)) < _CONTRADICTED else prior


RIPPLE_CHANCE = 0.05  # probability of finding a wave in the noise of one joint in one recording
_FINER = 6  # candidates from one whole wave over the range to the next
_FURTHEST = 40  # waves over the joint's range
_MOST = 4  # waves per joint
_AT_ONCE = 1_000_000  # numbers, so that memory does not grow with the waves
_ROWS_EACH = 20  # rows for each wave: of fewer nothing is looked for
_PASSED = 0.1  # of a wave's amplitude: what decimation leaves less of is not looked for
_DEPENDENT = 0.05  # of a wave's power: explained by the payload but for this, it cannot be separated from it


class Wave(Document, frozen=True):
    """A wave over the turn of a joint in one recording, and the probability of any such wave in noise alone.

    ``joint``: number; ``waves``: [1 per 2 pi rad or 2 pi m]; ``amplitude``: as found alone [N·m or N].
    """

    source: str
    joint: int
    waves: float = field(name="waves_per_turn")
    amplitude: float
    probability_by_noise: float = RIPPLE_CHANCE


def with_ripple(source: str, recording: Observation, data: Used) -> tuple[list[Wave], Observation]:
    """Find waves that a difference of torques holds besides the payload and what is free; free are those then too.

    ``recording``: the equations of ``data``, in the columns of the payload, of what is free, and ``PATH``.
    """
    waves, found = list[Wave](), list[Array]()
    for j, (W, Y, t) in enumerate(zip(recording.W, recording.Y, recording.t, strict=True)):
        own = _waves(data, j, W[:, :-1], Y, t)
        found.append(np.hstack([W, *(columns for *_, columns in own)]))
        waves += [Wave(source, j + 1, wave, float(np.sqrt(2.0 * gain / len(Y)))) for wave, gain, _ in own]
    if not waves:
        return [], recording
    most, rest = max(W.shape[1] for W in found), (recording.t, recording.bandwidth, recording.motors)
    names = (*recording.columns, *(f"{FREE}{k}" for k in range(most - len(recording.columns))))
    wide = [np.pad(W, ((0, 0), (0, most - W.shape[1]))) for W in found]
    return waves, Observation.of(names, wide, recording.torques, *rest)


def _waves(seen_by: Used, j: int, W: Array, torque: Array, t: Array) -> list[tuple[float, float, Array]]:
    """Find the clearest wave of a joint, its gain and its columns, then the next; none that may be memory alone."""
    (data, keep, decimate), most = seen_by, min(_MOST, len(torque) // _ROWS_EACH)
    position = data.motion.q[:, j] - data.motion.q[:, j].mean()
    span, speed = float(np.ptp(position)), float(np.abs(data.motion.qd[keep[:, j], j]).max(initial=0.0))
    # From one wave over the range to the most that the samples resolve.
    waves = 2.0 * np.pi / max(span, 1e-9) * (1.0 + np.arange(_FINER * (_FURTHEST - 1) + 1) / _FINER)
    waves = waves[waves * speed / data.motion.rate < np.pi]
    if not (most and span and speed and len(waves)):
        return []

    def seen(signals: Sequence[Array]) -> Array:  # as the equations see them
        given = np.hstack([*decimated([np.array(signals)], len(signals), decimate)])
        return np.asarray(given[:, keep[::decimate, j]].T)

    def chance(gain: float, rest: float, spare: int) -> float:
        """Probability that white noise lowers the sum of squares to ``rest`` by as much by any wave (F test)."""
        one = float(fdtrc(2, spare, 0.5 * gain / rest * spare)) if spare > 0 and rest > 0.0 else 1.0
        return one * len(waves)

    def falls(some: Array, Q: Array, left: Array) -> Array:
        """Fall of the sum of squares by each of some waves beside Q; 0 where it hardly stands out."""
        turning = np.outer(some, position)
        pairs = seen([*np.sin(turning), *np.cos(turning)])
        passed = np.sum(pairs**2, axis=0).reshape(2, -1).sum(axis=0) > _PASSED**2 * len(left)
        pairs = (pairs - Q @ (Q.T @ pairs)).reshape(len(left), 2, -1)
        N, b = np.einsum("riw,rjw->wij", pairs, pairs), np.einsum("riw,r->wi", pairs, left)
        clear = passed & (np.linalg.det(N) > (_DEPENDENT * 0.5 * len(left)) ** 2)
        N[~clear] = np.eye(2)
        return np.where(clear, np.einsum("wi,wij,wj->w", b, np.linalg.inv(N), b), 0.0)

    groups = np.array_split(waves, 1 + len(waves) * len(position) // _AT_ONCE)
    Q, found = decomposed(W).range, list[tuple[float, float, Array]]()
    left = torque - Q @ (Q.T @ torque)
    while len(found) < most:
        gains = np.concatenate([falls(some, Q, left) for some in groups])
        gain, wave = float(gains.max()), float(waves[np.argmax(gains)])
        if chance(gain, float(left @ left - gain), len(torque) - Q.shape[1] - 2) > RIPPLE_CHANCE:
            break
        # Sine and cosine of a wave, and their slopes by the wavelength, which is not known exactly.
        shapes = [np.sin(wave * position), np.cos(wave * position)]
        found.append((wave, gain, seen([*shapes, *(wave * position * shape for shape in shapes)])))
        Q = decomposed(np.column_stack([Q, found[-1][2]])).range
        left = torque - Q @ (Q.T @ torque)
    rest, spare = inflation([(t, left)]) * float(left @ left), len(torque) - Q.shape[1]
    return [wave for wave in found if chance(wave[1], rest, spare) <= RIPPLE_CHANCE]


SLOW = 0.03
"""Speed [rad/s or m/s] of a joint below which rows are not used; the sign of its friction is not sure there."""
_LEAST = 0.1  # of the moving time: a joint that moves less is at rest
_AT_REST = 5e-3  # rad or m: a joint at rest's positions spread no more; a wider one went to another pose


@dataclass(frozen=True, eq=False, repr=False)
class ShortMotion(Brief):
    """Recordings of a short motion, friction free in each, and what they show of the ten.

    Method 3, (29), where the torque without payload was subtracted; else method 1, (22) and (23), with a robot
    that was identified earlier.
    """

    robot: Robot
    base: BaseParameters
    source: long_motion.Source
    joints: tuple[int, ...]  # numbers of those that move; the rows of the others are left out
    # Of each recording with payload: the robot's base parameters (none where the unloaded torque was subtracted),
    # what is free in it, waves of ``ripple`` among that, and ``PAYLOAD``, in blocks of time.
    runs: tuple[Equations, ...]
    held: HeldFriction  # the same in all recordings
    torque_rms: Array  # of each joint's torque with payload in the rows used [N·m or N], (n,)
    known: Estimate | None = None  # the robot, where no torque was subtracted
    settings: Settings = DEFAULTS
    scale: KnownMass | None = None  # the payload was weighed; counts only where torques do not show the mass
    ripple: tuple[Wave, ...] = ()

    def __post_init__(self) -> None:
        """Refuse another model's robot."""
        long_motion.check_known(self.robot, self.base, self.known)

    @cached_property
    def loaded(self) -> Equations:
        """Join the equations less all that is free in each recording, its blocks of time among them."""
        length = max(run.block_length for run in self.runs)
        return replace(merged(map(self.held.friction_free, self.runs)), block_length=length)

    @property
    def method(self) -> int:
        """Number of the paper's method."""
        return 1 if self.known is not None else 3

    @property
    def robot_estimate(self) -> Estimate | None:
        """Robot's own parameters, where they are known."""
        return self.known

    @property
    def inflation(self) -> tuple[float, ...]:
        """Inflation of variances by the memory of each joint's errors under load."""
        return tuple(self.held.memory.tolist())

    @property
    def corrected(self) -> bool:
        """True if a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.held.held)

    @cached_property
    def visibility(self) -> PayloadVisibility:
        """Visibility of the payload in all recordings together."""
        factors = long_motion.in_payload_frame(self.robot, self.loaded).select(PAYLOAD).factors
        return visibility_of(np.vstack(factors)[:, :-1], self.joints)

    def posed(self, wanted: Sequence[str] | None = None) -> LinearProblem:
        """Pose (29): Y_T - Y_wL = W_L chi_L, or (23): Y_T - W chi = W_L chi_L.

        Wanted: by default those of chi_L that stand for all that is visible. Fixed: friction's prior; for (29) the
        difference of the paths, for (23) chi with its robust covariance. Soft prior: chi, where friction has one.
        """
        wanted = tuple(wanted or (PAYLOAD[k] for k in self.visibility.base.chosen))

        def shown(equations: Equations) -> Equations:
            columns = [name for name in equations.columns if name in wanted or name not in PAYLOAD]
            return long_motion.in_payload_frame(self.robot, equations).select(columns)

        equations, prior = shown(self.loaded), None
        fixed: tuple[Known, ...] = (self.held.known,)
        if self.known is None:
            fixed += (long_motion.known_path(self.robot.n),)
        elif self.corrected:
            prior = long_motion.prior_of(self.known, self.inflation, self.loaded)
        else:
            robot = long_motion.stored_robot(self.known)
            fixed = (robot._replace(covariance=robot.lasting), *fixed)
        parts = tuple(map(shown, self.without_each))
        # Against the robot's torque the payload's own is what the joints of a short motion are compared by.
        return LinearProblem(equations, wanted, fixed, prior=prior, own_torque=True, parts=parts)

    @cached_property
    def without_each(self) -> tuple[Equations, ...]:
        """Leave out each block of time of ``loaded``."""
        runs, left = [replace(self.held.friction_free(run), shared={}) for run in self.runs], list[Equations]()
        for k, run in enumerate(self.runs):
            others = [*runs[:k], *runs[k + 1 :]]
            if len(run.blocks) > 1:
                parts = map(self.held.friction_free, run.without_each())
                left += [merged([*others, part]) for part in parts]
            elif others:
                left.append(merged(others))
        return tuple(left)

    @property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time that are left out in turn, none with them, as one group."""
        return (tuple((b, -1) for b in range(len(self.without_each))),)

    @property
    def needed_scale(self) -> KnownMass | None:
        """Scale, where torques do not show the mass; else it takes no part in the free estimate."""
        check_mass_visible(self.visibility, self.scale is not None, "by this motion")
        return None if self.visibility.mass_visible else self.scale

    def resolved(self, estimate: Estimate) -> Estimate:
        """Determine parameters from those posed; a ``needed_scale`` makes others follow from sums."""
        scale = self.needed_scale
        indices, A, by_mass = self.visibility.resolved(scale is not None)
        mass, variance = (scale.mass, scale.sigma**2) if scale is not None else (0.0, 0.0)
        payload = estimate.mapped(A, [PAYLOAD[k] for k in indices], by_mass * mass)
        shared, robust = variance * np.outer(by_mass, by_mass), payload.robust
        robust = robust and replace(robust, covariance=robust.covariance + shared)
        return replace(payload, covariance=payload.covariance + shared, robust=robust)


class Rests(NamedTuple):
    """R rests of one recording of n joints, each after a motion."""

    q: Array  # mean once settled [rad or m], R x n
    torque: Array  # mean once settled [N·m or N], R x n
    side: Array  # way a joint came, 1, -1 or 0, R x n
    moving: Array  # deviation of the torques on the way, (n,)
    held: tuple[Array, ...]  # torques at rest, m x n
    rate: float  # of those [Hz]


class Drift(Document, frozen=True):
    """Drift of the torques that is linear in time, per hour where files share a clock, else per recording.

    ``offset``, ``friction``: of each joint's constant torque and Coulomb level [N·m or N], both with ``sigma``;
    ``mass``: what it would add to the mass [kg] from one recording to the next, were it not known; ``ratio``: its
    part of the mass's variance.
    """

    per: str
    offset: Vector
    friction: Vector
    sigma: Vector
    mass: Float
    ratio: float


class Standing(Document, frozen=True):
    """Number of poses, order of recordings, scatter of each joint's torque over approaches, and drift, if seen."""

    poses: int
    order: str
    scatter: Vector
    drift: Drift | None = None


@dataclass(frozen=True, eq=False, repr=False)
class StaticMotion(ShortMotion):
    """Recordings that rest in poses: a short motion whose rows are rests, and whose blocks are poses."""

    rests: tuple[Rests, ...] = ()  # of each recording, those without payload first
    one_sided: tuple[int, ...] = ()  # numbers of poses that are reached from one side only
    standing: Standing | None = None


def known_robot_weighing(
    robot: Robot, loaded: Sequence[Recording], known: Estimate, settings: Settings = DEFAULTS
) -> ShortMotion:
    """Weigh by torques less those of a robot identified earlier, (22)-(23); else as ``difference_weighing``."""
    processing, progress = settings.processing_of(robot), settings.progress
    robot = without_dead(robot.of_parameters(known.names), loaded)
    check_recordings(robot, loaded)
    progress("base parameters")
    known, base = long_motion.measured_part(known, robot), base_parameters(robot)
    measured = filtered(loaded, processing, progress)
    moving, rows, rms = used_near(robot, loaded, [[data] for data in measured], settings)
    observer = observer_of(robot, base, settings.friction_change > 0.0)
    (_, observations), _ = under_own_load(observer, [own for (own,) in rows], known.values)
    k, changes = len(known.values), long_motion.friction_changes(known, [1.0] * robot.n, settings.friction_change)
    payload_only = [  # less the torque of the robot, whose columns come first
        Observation.of(one.columns[k:], [W[:, k:] for W in one.W], one.errors(known.values), one.t, one.bandwidth)
        for one in observations
    ]
    own = {name: one.sigma for name, one in changes.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    source = long_motion.Source(tuple(loaded), (), processing, rate=measured[0].motion.rate)
    held = friction_prior(payload_only, own)
    # Of a single recording the robot's own ripple is what would be found: it takes weight along.
    return ShortMotion(robot, base, source, moving, _runs(observations), held, rms, known, settings)


def difference_weighing(
    robot: Robot, loaded: Sequence[Recording], unloaded: Sequence[Recording], settings: Settings = DEFAULTS
) -> ShortMotion:
    """Weigh by torque differences (29) on one and the same motion.

    ``unloaded``: recordings without payload; one for all, or one for each of ``loaded`` in the same order.
    """
    processing, progress = settings.processing_of(robot), settings.progress
    robot = without_dead(robot, [*loaded, *unloaded])
    check_recordings(robot, *filter(None, (loaded, unloaded)))
    check_lengths([*loaded, *unloaded], processing)
    if len(unloaded) not in (1, len(loaded)):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload: give one without for all, or one "
            "for each in the same order"
        )
    partners = list(unloaded) * (len(loaded) if len(unloaded) == 1 else 1)
    together = each(list(zip(partners, loaded, strict=True)), lambda pair: f"aligning {pair[1].source}", progress)
    pairs = [aligned(a, b, grid_rate(b, processing), processing.max_mismatch) for a, b in together]
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving, rows, rms = used_near(robot, [pair.loaded for pair in pairs], measured, settings)
    progress("the robot without payload")
    free = robot.with_offsets(True)
    whole, observer = Observer(free, base_parameters(free).columns), observer_of(robot, None)
    without_payload = merged(reduced(whole.observe(*unloaded)) for unloaded, _ in rows)
    own, resting = long_motion.robot_of(without_payload), [j for j in range(robot.n) if j + 1 not in moving]
    observations, ripple = list[Observation](), list[Wave]()
    for pair, ((bare, *_), under_load) in zip(pairs, rows, strict=True):
        # No motion shows how torques change with a joint at rest, so that it stays where it was before.
        motion, q = under_load.data.motion, np.array(under_load.data.motion.q)
        q[:, resting] = bare.motion.q[:, resting]
        path = whole.torques(Motion(motion.t, q, motion.qd, motion.qdd), own) - whole.torques(bare.motion, own)
        change = under_load._replace(data=long_motion.torque_change(robot, bare, under_load.data, path))
        waves, one = with_ripple(pair.loaded.source, observer.observe(*change), change)
        observations.append(one)
        ripple += waves
    rate = measured[0][1].motion.rate
    source = long_motion.Source(tuple(loaded), tuple(unloaded), processing, tuple(pairs), rate=rate)
    # Coulomb friction without payload; 0 where the motion, or the model, does not show it.
    values, hidden = weighted_solution(without_payload), decomposed(without_payload.stacked()[:, :-1]).hidden
    shown = dict(zip(without_payload.columns, np.where(hidden < _HIDDEN, values, 0.0).tolist(), strict=True))
    coulomb = np.array([max(shown.get(f"FS{j}", 0.0), 0.0) for j in range(1, robot.n + 1)])
    base, held = base_parameters(robot), offset_prior(observations, coulomb)
    runs, found = _runs(observations), tuple(ripple)
    return ShortMotion(robot, base, source, moving, runs, held, rms, settings=settings, ripple=found)


def observer_of(robot: Robot, base: BaseParameters | None, frees: bool = True) -> Observer:
    """Make the observer of [W, free columns, W_L]; of torque differences [free columns, W_L, ``PATH``]."""
    free = robot.with_offsets(True)
    own, path = (base.columns, ()) if base is not None else ((), (PATH,))
    friction = (*friction_columns(robot), *(name for name in own if parameter_kind(name) == "FV")) if frees else ()
    # FA gives way to offsets, which rows of a moving joint do not tell from it.
    known = (name.replace("FA", "OFF") if parameter_kind(name) == "FA" else name for name in own)
    columns = (*known, *friction, *payload_columns(free), *path)
    return Observer(free, columns, (*own, *(f"{FREE}{name}" for name in friction), *PAYLOAD, *path))


def _runs(observations: Sequence[Observation]) -> tuple[Equations, ...]:
    """Cut each recording's equations in blocks as long as the memory of all of them asks for."""
    rest = [one.eliminate() for one in observations]
    length = max(remembered([one], reduced(one))[0] for one in rest)
    return tuple(in_blocks(reduced(one), [one], length) for one in observations)


def used_near(
    robot: Robot, loaded: Sequence[Recording], groups: Sequence[Sequence[Measurement]], settings: Settings
) -> tuple[tuple[int, ...], list[list[Used]], Array]:
    """Find the joints that move, or check those asked for, the rows that say something, and the torques' rms there.

    Others that do not go elsewhere are set exactly at rest: what encoders flicker is no motion. ``groups``:
    measurements of one motion, that of each of ``loaded`` last.
    """
    processing, asked = settings.processing_of(robot), settings.joints
    motions = [group[-1].motion for group in groups]
    fast = np.vstack([np.abs(motion.qd[moving_parts(motion, processing.still_speed)]) > SLOW for motion in motions])
    moving = tuple((np.flatnonzero(fast.sum(axis=0) > _LEAST * len(fast)) + 1).tolist())
    if not moving:
        raise InputError("no joint moves: record the short motion that 'dynident near' gives")
    if idle := sorted(set(asked or ()) - set(moving)):
        raise InputError(
            f"joint {', '.join(map(str, idle))} of {robot.name} hardly moves in the recordings; those that "
            f"move are {', '.join(map(str, moving))}: correct --joints"
        )
    moving, found = moving if asked is None else tuple(sorted(asked)), list[list[Used]]()
    resting = [j for j in range(robot.n) if j + 1 not in moving]
    for recording, group in zip(loaded, groups, strict=True):
        # The filter's error at cut ends is alike in both of a pair, and a short motion needs its ends.
        still, own = list[Used](), processing if len(group) < 2 else replace(processing, cutoff=None)
        for data in group:
            q, qd, qdd = (np.array(x) for x in (data.motion.q, data.motion.qd, data.motion.qdd))
            for j in resting:
                if np.ptp(q[:, j]) < _AT_REST:
                    q[:, j], qd[:, j], qdd[:, j] = q[:, j].mean(), 0.0, 0.0
            still.append(used(Measurement(Motion(data.motion.t, q, qd, qdd), data.torque), own))
        keep = np.all([one.keep & (np.abs(one.data.motion.qd) >= SLOW) for one in still], axis=0)
        keep[:, resting] = False
        if not keep.any():
            raise InputError(f"{recording.source}: no joint moves fast enough: nothing can be compared")
        found.append([one._replace(keep=keep) for one in still])
    torque, kept = np.vstack([own[-1].data.torque for own in found]), np.vstack([own[-1].keep for own in found])
    return moving, found, np.sqrt(np.sum(torque**2 * kept, axis=0) / np.maximum(kept.sum(axis=0), 1))
