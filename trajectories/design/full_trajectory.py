"""Full trajectory of a motion, as a controller runs it: what it misses between the samples that a search looks at.

Dry friction turns its sign with a joint's speed, so that a torque may leap between two samples. The run is looked
at on a dense grid, just before and after each turn, and close to each rest. Slower runs of a ladder are judged
by it too.
"""

from collections.abc import Callable, Sequence

import numpy as np
from msgspec import field

from ...common import Array, Document, InputError
from ...model import Motion, Robot
from ..motions.family import Plan, Samples, sample_count
from ..motions.fourier import Fourier, FreeSeries, NearShape
from .limits import Limit, LimitCheck, check, state_limits
from .payloads import PayloadSet
from .problem import DesignProblem
from .score import TOLERANCE, Score, score_of

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


Missed = tuple[tuple[LimitCheck, ...], tuple[LimitCheck, ...]]
"""Limits that a run misses, the worst first, and those that its slow rehearsal misses, where there is one."""


def missed_on_run(
    problem: DesignProblem, plan: Plan, rate: float = RUN_RATE, further: Sequence[Limit] = ()
) -> tuple[LimitCheck, ...]:
    """List torque, clearance and ``further`` limits that a run misses, between two poses too; the worst first.

    The moments just before and after each joint's turns come on top of a grid of ``rate`` [Hz].
    """
    limits, worst = (*problem.of_kind("torque", "clearance"), *further), dict[str, LimitCheck]()
    t = np.union1d(np.arange(sample_count(plan.duration, rate)) / rate, plan.duration)
    for start in range(0, max(len(t) - 1, 1), _BLOCK) if limits else ():
        own = t[start : start + _BLOCK + 1]
        all_times = np.union1d(own, _turns(problem.robot, plan, own))
        state = problem.exact(Samples.of(Motion(all_times, *plan.at(all_times))))
        for near in (check(limit, state) for limit in limits):
            if near.relative > max(TOLERANCE, worst[near.name].relative if near.name in worst else 0.0):
                worst[near.name] = near
    return tuple(sorted(worst.values(), key=lambda near: -near.relative))


def missed_on_replay(problem: DesignProblem, plan: Plan, rate: float) -> tuple[LimitCheck, ...]:
    """List limits that a run by a controller's own curves misses, positions and speeds too; the worst first."""
    low, high = (np.atleast_2d(reach) for reach in problem.family.reach)
    position, speed, _ = state_limits(problem.bounds, (low.min(axis=0), high.max(axis=0)))
    return missed_on_run(problem, plan, rate, (position, speed))


def kept_throughout(problem: DesignProblem, x: Array, score: Score) -> tuple[Array, Score, Missed]:
    """Keep a motion that keeps all limits throughout, or one slower or smaller by what torques miss that does.

    A motion whose score misses a limit on its own samples is left as it is.
    """
    run, rehearsal = missed = _missed(problem, x) if score.feasible else ((), ())
    if any(missed) and _by_torques(run + rehearsal, _BETWEEN):
        slower = max(_LEAST, *(limit.relative for limit in run + rehearsal))
        for ease in range(_EASES):
            eased = problem.family.eased(x, 1.0 + 2.0**ease * slower, 1.0)
            after = score_of(problem, eased)
            if after.feasible and not any(now := _missed(problem, eased)):
                return eased, after, now
    return x, score, missed


def harder(problem: DesignProblem, missed: Missed) -> DesignProblem | None:
    """Pose the problem to go on with where a run misses torque limits; None where a search sees what is missed."""
    # What a run misses between samples is taken off the limits, and some more.
    run, rehearsal = missed
    if not any(missed) or not _by_torques(run, _BETWEEN) or not _by_torques(rehearsal, np.inf):
        return None
    lower = problem.with_torque_share(1.0 - _BELOW * max((limit.relative for limit in run), default=0.0))
    return lower.with_slow_torques(REHEARSAL) if rehearsal else lower


def _missed(problem: DesignProblem, x: Array) -> Missed:
    family = problem.family
    rehearsal: tuple[LimitCheck, ...] = ()
    if isinstance(family, FreeSeries) and isinstance(family.shape, NearShape):
        rehearsal = missed_on_run(problem, family.plan(x).slowed(REHEARSAL), REHEARSAL * RUN_RATE)
    return missed_on_run(problem, family.plan(x)), rehearsal


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
    rungs: list[Rung] = []
    mass, last = payloads.mass, 0.0
    while last < 1.0:
        speed = _fastest(bearing(payloads.lighter(mass)), motion)
        if speed is None:
            raise InputError(
                f"at {100 * _SLOWEST:g} % of its speed the motion does not bear {mass:.3g} kg everywhere within "
                "bounds: omit --ladder, so that the motion itself holds for every payload"
            )
        if speed < min(_FASTER * last, 1.0) or len(rungs) == _RUNGS:
            raise InputError(
                f"the run at {100 * last:.0f} % of the speed bounds the mass by {mass:.3g} kg, which allows "
                "no faster one: omit --ladder, so that the motion itself holds for every payload"
            )
        run = motion if speed == 1.0 else motion.slowed(speed)
        bound = min(mass, expected + _SIGMAS * sigma(run))
        rungs.append(Rung(speed, mass, bound, run.duration))
        mass, last = bound, speed
    return tuple(rungs)


def _fastest(problem: DesignProblem, motion: Fourier) -> float | None:
    def bears(speed: float) -> bool:
        run = motion if speed == 1.0 else motion.slowed(speed)
        return not missed_on_run(problem, run, speed * _LADDER_RATE)

    if bears(1.0):
        return 1.0
    low, high = _SLOWEST, 1.0
    if not bears(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bears(middle) else (low, middle)
    return low
