"""Simulated and real recordings for the tests of estimation."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import InertialParameters, Joint, Limits, Motion, Processing, Recording, Robot, load_robot
from dynident.model.motion import Measurement
from dynident.trajectories import Fourier, Simulator, ViaPoints

Change = Callable[[Recording], Recording]
EXACT = Processing()
"""No filter, no decimation."""
TURNS, SLIDES = Limits((-2.0, 2.0), 3.0, 10.0, 100.0), Limits((-0.3, 0.3), 2.0, 10.0, 900.0)
LIFT = Robot(
    "lift",
    (
        Joint("prismatic", limits=SLIDES),
        Joint(alpha=-np.pi / 2, d=0.1, limits=TURNS),
        Joint(d=0.4, limits=TURNS),
        Joint(alpha=np.pi / 2, d=0.05, r=0.3, limits=TURNS),
        Joint(alpha=-np.pi / 2, limits=TURNS),
    ),
    mass=30.0,
    rated_payload=3.0,
)
"""An arm on a vertical slide."""


@pytest.fixture(scope="session")
def payload() -> InertialParameters:
    return InertialParameters.from_com(7.025, [0.01, -0.02, 0.143], np.diag([0.02, 0.019, 0.035]))


@pytest.fixture(scope="session")
def simulated() -> Callable[[str], Simulator]:
    """A simulator of any shipped robot; robots without known parameters get the RX90's."""
    known = load_robot("rx90").parameters

    def simulator(name: str) -> Simulator:
        robot = load_robot(name)
        extra = {f"OFF{joint}": 0.3 * joint for joint in range(1, robot.n + 1)}
        return Simulator(replace(robot, parameters={**known, **extra}))

    return simulator


@pytest.fixture(scope="session")
def wander() -> Callable[..., Motion]:
    """Random quintic motion of n joints between random points, all joints moving."""

    def motion(n: int, seed: int, points: int = 12, rate: float = 100.0) -> Motion:
        draw = np.random.default_rng(seed)
        path = draw.uniform(-1.2, 1.2, (points, n))
        return ViaPoints(path, draw.uniform(0.6, 1.2, points - 1)).motion(rate)

    return motion


@pytest.fixture(scope="session")
def exact_pair(
    payload: InertialParameters, wander: Callable[..., Motion]
) -> Callable[..., tuple[Measurement, ...]]:
    """Exact measurements (unloaded, loaded) on one motion."""

    def pair(simulator: Simulator, seed: int = 0) -> tuple[Measurement, ...]:
        motion = wander(simulator.robot.n, seed)
        return simulator.measure(motion), simulator.measure(motion, payload)

    return pair


def near_pose(joints: Sequence[int], pose: Sequence[float] = (0.0, -45.0, 90.0, 0.0, 45.0, 0.0)) -> Fourier:
    """20 s near a pose [deg], the RX90's by default: periods of 5 s of random harmonics, within 30 degrees."""
    draw, n, harmonics = np.random.default_rng(0), 6, 4
    a, b = np.zeros((2, 1, n, harmonics))
    for joint in joints:
        own = 0.6 * draw.standard_normal(harmonics)
        a[0, joint - 1] = own - own.mean()  # at rest where it begins
    return Fourier(np.radians([pose]), a, b, 5.0, 4, 0.0)


def on_torque(change: Callable[[Array], Array]) -> Change:
    """A change of a recording's torques or currents."""
    return lambda r: replace(r, torque=change(np.array(r.torque)))


def scaled(factor: float, *joints: int) -> Change:
    """Torques or currents of some joints, of all if none is named, times a factor."""

    def change(torque: Array) -> Array:
        torque[:, [joint - 1 for joint in joints] or slice(None)] *= factor
        return torque

    return on_torque(change)


def counted_backwards(joint: int) -> Change:
    def change(r: Recording) -> Recording:
        sign = np.where(np.arange(r.q.shape[1]) == joint - 1, -1.0, 1.0)
        return replace(r, q=r.q * sign, torque=r.torque * sign)

    return change
