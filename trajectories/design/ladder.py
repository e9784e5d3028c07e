"""A ladder of speeds: slow runs bound a payload that is not known, faster ones need that bound.

A motion that is best for the payload expected may be too fast for others in the set. Slower, on the same way, it
holds for all of them; what that run tells bounds the mass, and the next run is as fast as the bound allows.
"""

from collections.abc import Callable
from typing import NamedTuple

from ...common.errors import InputError
from ..motions.near import NearMotion
from .payloads import PayloadSet
from .problem import DesignProblem
from .whole_run import RUN_RATE, missed_on_run

_SLOWEST = 0.02  # of the speed: a slower run takes too long
_HALVINGS = 12  # of the interval of speeds
_SIGMAS = (
    8.0  # a bound is two standard deviations of real noise, up to 4 times those of white noise, above the mass
)
_FASTER = 1.05  # a step that gains less leads nowhere
_MOST = 12  # steps


class Rung(NamedTuple):
    """One run of the ladder.

    Attributes:
        speed: of the full speed, above 0 and at most 1.
        mass: largest mass for which the run keeps the torque limits, by what the run before has told [kg].
        bound: largest mass after the run, if the payload is the one expected [kg].
        motion: the run.
    """

    speed: float
    mass: float
    bound: float
    motion: NearMotion


def speed_ladder(
    bearing: Callable[[PayloadSet], DesignProblem],
    payloads: PayloadSet,
    motion: NearMotion,
    expected: float,
    sigma: Callable[[NearMotion], float],
) -> tuple[Rung, ...]:
    """Runs of a motion, from the first that every payload allows to full speed.

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
                "bounds: leave --ladder out, so that the motion itself holds for every payload"
            )
        if speed < min(_FASTER * last, 1.0) or len(rungs) == _MOST:
            raise InputError(
                f"the run at {100 * last:.0f} % of the speed bounds the mass by {mass:.3g} kg, which allows "
                "no faster one: leave --ladder out, so that the motion itself holds for every payload"
            )
        run = motion if speed == 1.0 else motion.slowed(speed)
        bound = min(mass, expected + _SIGMAS * sigma(run))
        rungs.append(Rung(speed, mass, bound, run))
        mass, last = bound, speed
    return tuple(rungs)


def _fastest(problem: DesignProblem, motion: NearMotion) -> float | None:
    """Largest speed at which a run keeps all torque and clearance limits; None without any."""
    if _kept(problem, motion, 1.0):
        return 1.0
    low, high = _SLOWEST, 1.0
    if not _kept(problem, motion, low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _kept(problem, motion, middle) else (low, middle)
    return low


def _kept(problem: DesignProblem, motion: NearMotion, speed: float) -> bool:
    run = motion if speed == 1.0 else motion.slowed(speed)
    return not missed_on_run(problem, run, speed * RUN_RATE)
