"""Currents of simulated arms with a known weight, good ones and such as hold a mistake."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import answer_gains
from dynident.estimation.answers.gains import DriveGains
from dynident.estimation.gains.known_load import known_mass
from dynident.estimation.gains.problem import gain_problem
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot, with_stand_in
from dynident.trajectories import Simulator, random_via_points

Change = Callable[[Recording], Recording]


@cache
def arm(name: str) -> Robot:
    """A shipped robot with parameters to simulate with."""
    return with_stand_in(load_robot(name))


@cache
def simulator(name: str) -> Simulator:
    return Simulator(arm(name))


def weight(name: str, seed: int, share: float = 0.7) -> InertialParameters:
    """A weight of a share of what the arm carries, off the flange's axis."""
    draw = np.random.default_rng([seed, 3])
    mass = share * min(arm(name).rated_payload, 10.0)
    com = [draw.uniform(0.05, 0.12), draw.uniform(-0.05, 0.05), draw.uniform(0.05, 0.12)]
    return InertialParameters.from_com(mass, com, mass * np.diag([0.004, 0.005, 0.003]))


def truth(name: str, seed: int) -> Array:
    """Gains [N·m/A]."""
    return np.random.default_rng([seed, 5]).uniform(5.0, 60.0, arm(name).n)


def moved(name: str, seed: int, points: int = 14) -> Motion:
    rate = 250.0 if name in ("rx90", "tx40") else 100.0
    return random_via_points(arm(name), points, seed, 0.6, 0.5).motion(rate)


def recorded(
    name: str, motion: Motion, load: InertialParameters | None, seed: Sequence[int], noise: float = 0.05
) -> Recording:
    """Currents with white noise, a share of each."""
    robot, exact = arm(name), simulator(name).record(motion, load)
    motors = robot.coupling.motor_torques(exact.torque) if robot.coupling else exact.torque
    currents = motors / truth(name, seed[0])
    size = noise * np.sqrt(np.mean(currents**2, axis=0))
    drawn = np.random.default_rng([*seed, 7]).standard_normal(currents.shape)
    return Recording(motion.t, motion.q, currents + size * drawn, None, "loaded" if load else "unloaded")


def pair(name: str, seed: int, noise: float = 0.05, points: int = 14) -> tuple[Recording, Recording, float]:
    """Without and with the weight on one motion, and the weight's mass [kg]."""
    motion, load = moved(name, seed, points), weight(name, seed)
    bare, heavy = (recorded(name, motion, body, (seed, k), noise) for k, body in enumerate((None, load)))
    return bare, heavy, load.mass


def answered(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> DriveGains:
    load = known_mass(mass)
    return answer_gains(gain_problem(robot or load_robot(name), [bare], [heavy], load=load), load)


def said(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> tuple[str, str]:
    """The level of the answer, or "refused"; and why."""
    try:
        verdict = answered(name, bare, heavy, mass, robot).verdict
    except InputError as error:
        return "refused", str(error)
    return verdict.level, "; ".join(verdict.reasons)


def on_current(change: Callable[[Array], Array]) -> Change:
    return lambda r: replace(r, torque=change(np.array(r.torque)))


def scaled(factor: float, joint: int | None = None) -> Change:
    """All currents, or one joint's, times a factor."""

    def change(current: Array) -> Array:
        current[:, slice(None) if joint is None else joint - 1] *= factor
        return current

    return on_current(change)


def exchanged(i: int, j: int) -> Change:
    """Two columns of currents that changed places."""

    def change(current: Array) -> Array:
        current[:, [i - 1, j - 1]] = current[:, [j - 1, i - 1]]
        return current

    return on_current(change)


def counted_backwards(joint: int) -> Change:
    def change(r: Recording) -> Recording:
        sign = np.ones(r.q.shape[1])
        sign[joint - 1] = -1.0
        return replace(r, q=r.q * sign, torque=r.torque * sign)

    return change


def struck(r: Recording) -> Recording:
    """A second of contact."""
    current, middle = np.array(r.torque), 0.4 * r.t[-1]
    hit = (r.t > middle) & (r.t < middle + 1.0)
    for joint, size in ((1, 2.0), (2, 1.0)):
        current[hit, joint] += size * np.sqrt(np.mean(current[:, joint] ** 2))
    return replace(r, torque=current)
