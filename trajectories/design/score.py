"""Score of a motion: how much it would teach, and how near it comes to its limits: exact sign, fine grid.

A controller runs the full trajectory, and dry friction turns its sign with a joint's speed: a torque may leap
between two samples. So the run is looked at on a dense grid too, just before and after each turn, and close to
each rest. Slower runs of a ladder are judged by it as well.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from msgspec import field

from ...common import Array, Brief, Document, InputError, decomposed
from ...common.linear import condition_numbers
from ...model import Motion, Robot, inverse_dynamics
from ...model.kernel.kernel import Kernel
from ..motions.family import Plan, Samples, sample_count
from ..motions.fourier import Fourier, NearShape
from .limits import LimitCheck, PayloadSet, check, excess, state_limits
from .problem import DesignProblem

FINER = 10  # ratio of the final check's grid to the optimisation's
TOLERANCE = 1e-9  # miss of a limit, in its own units, up to which it is met
REHEARSAL = 0.1
"""Fraction of the speed at which a motion near a pose is watched before it is run."""
RUN_RATE = 500.0  # Hz: at which a run at full speed is looked at
_BLOCK = 20_000  # samples at a time
_NEWTON = 4  # steps to the moment of a turn
_NEAR_TURN = 1e-7  # s: before and after a turn
_FROM_REST = 1e-4  # of a step: a speed that grows with the square of the time has its sign there
_BETWEEN = 0.05  # of a torque limit: what a search may miss between its samples, where friction leaps
_EASES = 6  # each twice as much as the last
_LEAST = 1e-3  # slower or smaller by so much at first
_BELOW = 1.5  # times what a run misses: a search below the limit leaves that free
_SLOWEST = 0.02  # of the speed: a slower run takes too long
_HALVINGS = 12  # of the interval of speeds
# A bound is two standard deviations above the mass, of noise up to 2.8 times as large as it was taken to be.
_SIGMAS = 5.6
_FASTER = 1.05  # a step of the ladder that gains less leads nowhere
_RUNGS = 12  # at most
_LADDER_RATE = 250.0  # Hz: at which a run of the ladder is looked at, its turns besides


class Learnt(NamedTuple):
    """Information that data give of a goal's parameters."""

    log_det: float  # log det of the information matrix (d) by the best weights; -inf if it is singular
    condition_number: float  # of W in SI units, rows unweighted; inf if W has not full rank
    condition_number_scaled: float  # of W with its columns scaled to norm 1
    sigma: dict[str, float]  # predicted standard deviation of each parameter; inf if W has not full rank
    # of the parameters in the order of ``sigma``, by the weights (16) of an estimate; None if W has not full rank
    covariance: Array | None = None

    def relative_sigma(self, reference: Mapping[str, float]) -> dict[str, float]:
        """Predicted standard deviations relative to reference values other than zero."""
        return {name: sigma / abs(reference[name]) for name, sigma in self.sigma.items() if reference.get(name)}


@dataclass(frozen=True, eq=False, repr=False)
class Score(Brief):
    """Score of a motion, whatever the criterion it was designed for.

    Attributes:
        value: of the goal's criterion without surrogate, for 1 s of data or the goal's data length: small is good.
        problem: by whose goal and limits it was judged.
    """

    value: float
    limits: tuple[LimitCheck, ...]
    problem: DesignProblem
    samples: Samples

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.samples.weight.sum())

    @cached_property
    def learnt(self) -> Learnt:
        """Information of the ideal motion and the earlier recordings, where these are in the weights needed."""
        problem, parts = self.problem, [self.samples.weight / self.duration] * self.problem.robot.n
        W = np.split(problem.rows(problem.kernel.state(self.samples)), problem.robot.n)
        return learnt_of(problem, W, parts, self.duration)

    @property
    def max_violation(self) -> float:
        """Largest violation of a limit, in units of the limit; 0 if all are met."""
        return max((limit.relative for limit in self.limits), default=0.0)

    @property
    def feasible(self) -> bool:
        """True if all limits are met."""
        return self.max_violation <= TOLERANCE

    @property
    def violations(self) -> tuple[str, ...]:
        """Describe each limit that is not met, one line each."""
        return tuple(str(limit) for limit in self.limits if limit.relative > TOLERANCE)


def learnt_of(problem: DesignProblem, W: Sequence[Array], parts: Sequence[Array], duration: float) -> Learnt:
    """Compute what each joint's rows, each for its part of the time, teach with the earlier recordings."""
    with_earlier, recorded = problem.criterion.weighted, problem.goal.single_rate
    recorded *= problem.goal.data_length or duration
    used = np.isfinite(problem.noise)
    rows = [np.sqrt(recorded * part)[:, None] * own for own, part in zip(W, parts, strict=True)]
    weighted = [own / sigma for own, sigma in zip(rows, problem.noise, strict=True)]
    earlier = problem.earlier if with_earlier else problem.earlier[:0]
    plain = np.vstack([*rows, *([] if with_earlier else [problem.earlier])])
    R = decomposed(np.asarray(np.linalg.qr(np.vstack([*weighted, earlier]), mode="r")))
    if len(R.singular) < len(problem.names):
        return Learnt(-np.inf, *condition_numbers(plain), dict.fromkeys(problem.names, np.inf))
    # An estimate weighs joints by what ordinary least squares leave (16), which spread the errors of strong joints
    # over weak ones: no best weights where their noise is far apart.
    root = R.root
    grams = np.array([(own @ root).T @ (own @ root) for own, use in zip(rows, used, strict=True) if use])
    square, count = problem.noise[used] ** 2, recorded * np.array([*map(np.sum, parts)])[used]
    ordinary, prior = np.linalg.pinv(grams.sum(axis=0), hermitian=True), (earlier @ root).T @ (earlier @ root)
    spread = ordinary @ np.einsum("j,jab->ab", square, grams) @ ordinary
    left = square + np.einsum("ab,jab->j", spread, grams) / np.maximum(count, 1e-300)
    shown, wrong = (np.einsum("j,jab->ab", each, grams) + prior for each in (1.0 / left, square / left**2))
    root = root @ np.linalg.inv(shown)
    covariance = np.asarray(root @ wrong @ root.T)
    sigma = dict(zip(problem.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    log_det = 2.0 * float(np.log(R.singular).sum() + np.log(R.sizes).sum())
    return Learnt(log_det, *condition_numbers(plain), sigma, covariance)


def holding_torques(problem: DesignProblem, poses: Array) -> Array:
    """Largest torques [N·m or N], (n,), that hold any load at poses (N, n), by brakes too; 0 without limits."""
    state, n = problem.at_rest(poses), problem.robot.n
    torques = [np.abs(limit.values(state) * limit.unit).reshape(-1, n) for limit in problem.of_kind("torque")]
    return np.asarray(np.vstack([np.zeros((1, n)), *torques]).max(axis=0))


def check_held(problem: DesignProblem, poses: Array) -> None:
    """Refuse poses (N, n) in which a load breaks a torque limit at rest."""
    state = problem.at_rest(poses)
    for holding in (check(limit, state) for limit in problem.of_kind("torque")):
        if holding.violation > 0.0:
            fault = f"{holding.name} of {holding.worst} is {holding.value:.4g} against {holding.limit:.4g}"
            raise InputError(f"at rest in the pose: {fault}: choose another pose, or a lighter payload")


def over_time(problem: DesignProblem, motion: Motion) -> tuple[Array, Array]:
    """Room of each joint to its nearest limit in its units, (N, n), and each sample's part of information, (N,)."""
    limits = *state_limits(problem.bounds), *problem.of_kind("torque")
    state, shape = problem.kernel.state(Samples.of(motion)), (len(motion.t), -1, problem.robot.n)
    rooms = [-excess(limit, limit.values(state)).reshape(shape) for limit in limits]
    room = np.concatenate(rooms, axis=1).min(axis=1)
    if len(motion.t) < 2:  # a pose teaches no motion's parameters
        return room, np.zeros(len(motion.t))
    # The diagonal of the hat matrix, whose trace is the information.
    leverage = decomposed(problem.rows(state, problem.row_weights(state, True))).range ** 2
    return room, leverage.sum(axis=1).reshape(shape[2], -1).sum(axis=0)


def load_torques(problem: DesignProblem, motion: Motion) -> dict[str, Array]:
    """Torques on a motion [N·m or N], (N, n), by load: of the torque limits, else of the description, else none."""
    n, torques = motion.q.shape[1], dict[str, Array]()
    if problem.torque_limited:
        state = problem.kernel.state(Samples.of(motion))
        for limit in problem.of_kind("torque"):
            parts = np.split(limit.values(state) * limit.unit, len(limit.unit) // n, axis=1)
            ends = ("",) if len(parts) == 1 else ("largest ", "smallest ")  # the limit stands for many payloads
            torques |= {f"{end}{limit.name}": part for end, part in zip(ends, parts, strict=True)}
        return torques
    robot = problem.robot
    if not all(name in robot.parameters for name in robot.standard):
        return {}
    dynamics, torque = Kernel(inverse_dynamics(robot)), np.zeros(motion.q.shape)
    torque[:, dynamics.rows] = dynamics(motion.q, motion.qd, motion.qdd, robot.chi()).T
    return {"torque": torque}


def score_of(problem: DesignProblem, x: Array) -> Score:
    """Judge a motion of the problem's family on the fine grid."""
    return score_motion(problem, problem.family.sample(x, FINER))


def score_motion(problem: DesignProblem, motion: Motion | Samples) -> Score:
    """Judge any motion by a problem's goal and limits, such as one read back from a log, or its samples."""
    samples = Samples.of(motion) if isinstance(motion, Motion) else motion
    state, kind = problem.kernel.state(samples), problem.criterion.kind
    weights = problem.row_weights(samples, problem.criterion.weighted)
    if kind in ("cond", "cond-scaled"):
        W = np.vstack([problem.rows(state, weights), problem.earlier])
        value = float(np.log(condition_numbers(W)[kind == "cond-scaled"]))
    else:
        value = problem.criterion(problem.information(state.entries, weights), problem.criterion.orders[-1])[0]
    return Score(value, tuple(check(limit, state) for limit in problem.limits), problem, samples)


Missed = tuple[tuple[LimitCheck, ...], tuple[LimitCheck, ...]]
"""Limits that a run misses, the worst first, and those that its slow rehearsal misses, where there is one."""


def missed_on_run(
    problem: DesignProblem, plan: Plan, rate: float = RUN_RATE, states: bool = False
) -> tuple[LimitCheck, ...]:
    """List torque and clearance limits that a run misses, between two poses too; the worst first.

    The moments just before and after each joint's turns come on top of a grid of ``rate`` [Hz]. ``states``: look at
    positions and speeds too, which a controller's own curves may miss.
    """
    limits, missed = problem.of_kind("torque", "clearance"), list[LimitCheck]()
    if states:
        low, high = (np.atleast_2d(reach) for reach in problem.family.reach)
        limits += state_limits(problem.bounds, (low.min(axis=0), high.max(axis=0)))[:2]
    t = np.union1d(np.arange(sample_count(plan.duration, rate)) / rate, plan.duration)
    for start in range(0, max(len(t) - 1, 1), _BLOCK) if limits else ():
        own = t[start : start + _BLOCK + 1]
        all_times = np.union1d(own, _turns(problem.robot, plan, own))
        state = problem.kernel.state(Samples.of(Motion(all_times, *plan.at(all_times))))
        missed += [near for limit in limits if (near := check(limit, state)).relative > TOLERANCE]
    worst = dict[str, LimitCheck]()
    for near in sorted(missed, key=lambda near: -near.relative):
        worst.setdefault(near.name, near)
    return tuple(worst.values())


def kept_throughout(problem: DesignProblem, x: Array, score: Score) -> tuple[Array, Score, Missed]:
    """Keep a motion that keeps all limits throughout, or one slower or smaller by what torques miss that does.

    A motion whose score misses a limit on its own samples is left as it is.
    """
    run, rehearsal = missed = _missed(problem, x) if score.feasible else ((), ())
    if any(missed) and _by_torques(run + rehearsal, _BETWEEN):
        slower = max(_LEAST, *(limit.relative for limit in run + rehearsal))
        for times in 2.0 ** np.arange(_EASES):
            eased = problem.family.eased(x, 1.0 + times * slower, 1.0)
            if (after := score_of(problem, eased)).feasible and not any(now := _missed(problem, eased)):
                return eased, after, now
    return x, score, missed


def harder(problem: DesignProblem, missed: Missed) -> DesignProblem | None:
    """Pose the problem to go on with where a run misses torque limits; None where a search sees what is missed."""
    run, rehearsal = missed
    if not any(missed) or not _by_torques(run, _BETWEEN) or not _by_torques(rehearsal, np.inf):
        return None
    # What a run misses between samples is taken off the limits, and some more.
    lower = problem.with_torque_share(1.0 - _BELOW * max((limit.relative for limit in run), default=0.0))
    return lower.with_slow_torques(REHEARSAL) if rehearsal else lower


def _missed(problem: DesignProblem, x: Array) -> Missed:
    plan = problem.family.plan(x)
    run, rehearsal = missed_on_run(problem, plan), tuple[LimitCheck, ...]()
    if isinstance(plan, Fourier) and isinstance(problem.family.shape, NearShape):
        rehearsal = missed_on_run(problem, plan.slowed(REHEARSAL), REHEARSAL * RUN_RATE)
    return run, rehearsal


def _by_torques(missed: tuple[LimitCheck, ...], most: float) -> bool:
    return all(limit.name.startswith("torque") and limit.relative < most for limit in missed)


def _turns(robot: Robot, plan: Plan, t: Array) -> Array:
    """Moments next to a rest, and next to those at which a speed changes its sign, between times of a grid [s]."""
    speeds = _friction_speeds(robot, plan.at(t)[1])
    k, column = np.nonzero(speeds[:-1] * speeds[1:] < 0.0)
    low, high = t[k], t[k + 1]
    turn = low + (high - low) * speeds[k, column] / (speeds[k, column] - speeds[k + 1, column])
    for _ in range(_NEWTON if len(turn) else 0):
        _, *states = plan.at(turn)
        speed, bend = (_friction_speeds(robot, x)[np.arange(len(turn)), column] for x in states)
        step = np.divide(speed, bend, out=np.zeros_like(speed), where=bend != 0.0)
        turn = np.clip(turn - step, low, high)
    around = np.maximum(turn - _NEAR_TURN, low), np.minimum(turn + _NEAR_TURN, high)
    before, after, near = speeds[:-1] == 0.0, speeds[1:] == 0.0, _FROM_REST * np.diff(t)
    leaves, comes = (before & ~after).any(axis=1), (after & ~before).any(axis=1)
    return np.concatenate([*around, (t[:-1] + near)[leaves], (t[1:] - near)[comes]])


def _friction_speeds(robot: Robot, qd: Array) -> Array:
    """Speeds whose signs dry friction takes: of the joints (N, n), and of a coupled drive's rotor."""
    if robot.coupling is None or robot.coupling.coulomb != "sum":
        return qd
    j, k = (joint - 1 for joint in robot.coupling.joints)
    return np.column_stack([qd, qd[:, j] + qd[:, k]])


class Rung(Document, frozen=True):
    """Run of the ladder of speeds: the motion, slowed.

    Attributes:
        speed: of the full speed, above 0 and at most 1.
        mass: largest mass for which the run keeps the torque limits, by what the run before has shown [kg].
        bound: largest mass after the run, if the payload is the one expected [kg].
        duration: of the run [s].
    """

    speed: float
    mass: float = field(name="bears_kg")
    bound: float = field(name="bound_kg")
    duration: float = field(name="duration_s")


def speed_ladder(
    bearing: Callable[[PayloadSet], DesignProblem],
    payloads: PayloadSet,
    motion: Fourier,
    expected: float,
    sigma: Callable[[Fourier], float],
) -> tuple[Rung, ...]:
    """List runs of a motion, from the first that every payload allows to full speed.

    Slow runs bound a payload that is not known, which faster ones on the same way need.

    Args:
        bearing: the problem whose torque limits hold for each payload of a set.
        payloads: what is known before the first run.
        motion: at full speed.
        expected: mass of the payload expected [kg].
        sigma: predicted standard deviation of the mass after a run [kg].

    Raises:
        InputError: if even a slow run breaks a limit, or the runs do not tell enough to get faster.
    """
    rungs, mass, last = list[Rung](), payloads.mass, 0.0
    advice = "omit --ladder, so that the motion itself holds for every payload"

    def at(speed: float) -> Fourier:
        return motion if speed == 1.0 else motion.slowed(speed)

    def bears(problem: DesignProblem, speed: float) -> bool:
        return not missed_on_run(problem, at(speed), speed * _LADDER_RATE)

    while last < 1.0:
        problem, high = bearing(payloads.lighter(mass)), 1.0
        speed = next((speed for speed in (1.0, _SLOWEST) if bears(problem, speed)), None)
        if speed is None:
            fault = f"at {100 * _SLOWEST:g} % of its speed the motion does not bear {mass:.3g} kg everywhere within"
            raise InputError(f"{fault} bounds: {advice}")
        for _ in range(_HALVINGS if speed < 1.0 else 0):
            middle = 0.5 * (speed + high)
            speed, high = (middle, high) if bears(problem, middle) else (speed, middle)
        if speed < min(_FASTER * last, 1.0) or len(rungs) == _RUNGS:
            fault = f"the run at {100 * last:.0f} % of the speed bounds the mass by {mass:.3g} kg, which allows"
            raise InputError(f"{fault} no faster one: {advice}")
        bound = min(mass, expected + _SIGMAS * sigma(at(speed)))
        rungs.append(Rung(speed, mass, bound, at(speed).duration))
        mass, last = bound, speed
    return tuple(rungs)
