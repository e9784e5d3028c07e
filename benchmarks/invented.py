"""Robots with invented parameters, payloads and recordings of them, for benchmarks and tests of the verdict.

The shipped TX40 and UR10e know their geometry only. Here they get links, drives and friction that can exist and are
of the right order; they are no figures of those arms.
"""

import functools
from dataclasses import replace

import numpy as np
from dynident.benchmarks.shared import lasting
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot
from dynident.model.stand_in import with_stand_in
from dynident.trajectories import Simulator, random_via_points

NAMES = ("rx90", "ur10e", "tx40")
PAYLOADS = ("gripper", "disc", "cube", "bar", "offset")
RATE = {"rx90": 250.0, "ur10e": 125.0, "tx40": 250.0, "panda": 250.0}
CAPACITY = {"rx90": 6.0, "ur10e": 8.0, "tx40": 1.7, "panda": 2.0}
"""Mass of a usual payload [kg]."""
RELATIVE_NOISE = 0.12
"""Standard deviation of white torque noise, of each joint's torque."""

_UR10E = (  # mass [kg], centre of mass [m], size of a box [m]
    (7.4, (0.0, 0.0, -0.03), (0.15, 0.15, 0.2)),
    (13.0, (-0.3, 0.0, 0.17), (0.7, 0.12, 0.12)),
    (4.0, (-0.28, 0.0, 0.05), (0.6, 0.1, 0.1)),
    (2.1, (0.0, -0.01, 0.01), (0.1, 0.12, 0.1)),
    (2.0, (0.0, 0.01, 0.01), (0.1, 0.12, 0.1)),
    (0.6, (0.0, 0.0, -0.03), (0.08, 0.08, 0.05)),
)
_UR10E_DRIVES = {  # per joint
    "IA": (3.5, 3.5, 1.5, 0.5, 0.5, 0.5), "FS": (8.0, 9.0, 6.0, 2.5, 2.5, 2.0),
    "FV": (12.0, 13.0, 8.0, 3.0, 3.0, 2.5), "OFF": (0.6, -0.8, 0.4, 0.2, -0.1, 0.1),
}  # fmt: skip
_TX40_SHARE = {
    **dict.fromkeys(("XX", "XY", "XZ", "YY", "YZ", "ZZ"), 0.08), **dict.fromkeys(("MX", "MY", "MZ"), 0.15),
    "M": 0.3, "IA": 0.06, **dict.fromkeys(("FS", "FV", "FVM", "FSM"), 0.2),
}  # fmt: skip
"""Fractions of the RX90's parameters, whose shape and drives the TX40 has at half the length."""


@functools.cache
def robot(name: str) -> Robot:
    """A shipped robot with standard parameters; one that is none of ``NAMES`` with those of its stand-in."""
    known = load_robot(name)
    if name == "rx90":
        return known
    if name == "ur10e":
        return replace(known, parameters=_ur10e())
    if name != "tx40":
        return with_stand_in(known)
    joints = tuple(  # with speed and acceleration limits of the RX90
        replace(own, limits=replace(own.limits, speed=like.limits.speed, acceleration=like.limits.acceleration))
        for own, like in zip(known.joints, load_robot("rx90").joints, strict=True)
    )
    whole = load_robot("rx90").parameters.items()
    values = {name: _TX40_SHARE[name.rstrip("0123456789")] * value for name, value in whole}
    processing = replace(known.processing, decimate=10, equation_rate=None)
    return replace(known, joints=joints, parameters=values, processing=processing)


def _ur10e() -> dict[str, float]:
    values: dict[str, float] = {}
    for link, (mass, com, size) in enumerate(_UR10E, 1):
        values |= box(mass, com, size).named(str(link))
        values |= {f"{kind}{link}": drives[link - 1] for kind, drives in _UR10E_DRIVES.items()}
    return values


def box(mass: float, com: tuple[float, ...], size: tuple[float, ...]) -> InertialParameters:
    """A homogeneous box [kg, m], its edges along the axes."""
    a, b, c = np.square(size)
    return InertialParameters.from_com(mass, com, mass / 12.0 * np.diag([b + c, a + c, a + b]))


def payload(name: str, kind: str, draw: np.random.Generator) -> InertialParameters:
    """A payload of one kind that suits a robot, its mass and place drawn."""
    m = CAPACITY[name] * float(draw.uniform(0.7, 1.3))
    x, y = draw.uniform(-0.02, 0.02, 2)
    size = float(np.cbrt(CAPACITY[name] / 6.0))  # small arms carry small things
    if kind == "gripper":
        return box(0.3 * m, (x, y, 0.07 * size), (0.08 * size, 0.1 * size, 0.14 * size))
    if kind == "disc":
        return box(m, (x, y, 0.14 * size), (0.3 * size, 0.3 * size, 0.03 * size))
    if kind == "cube":
        return box(m, (x, y, 0.1 * size), (0.2 * size,) * 3)
    if kind == "bar":
        return box(0.7 * m, (x, y, 0.08 * size), (1.4 * size, 0.06 * size, 0.06 * size))
    return box(m, (0.2 * size + x, -0.12 * size + y, 0.15 * size), (0.5 * size, 0.4 * size, 0.3 * size))


@functools.cache
def simulator(name: str) -> Simulator:
    """Simulator of such a robot."""
    return Simulator(robot(name))


def motion(name: str, seed: int, points: int = 14, speed: float = 0.6) -> Motion:
    """A random motion within the limits."""
    span = 0.8 if name != "ur10e" else 0.3
    return random_via_points(robot(name), points, seed, speed, span).motion(RATE[name])


def long_motion(name: str, seed: int, shortest: float) -> Motion:
    """A random motion of at least so many seconds."""
    points = 8
    while (moved := motion(name, seed, points)).t[-1] < shortest:
        points += 2
    return moved


def recorded(
    name: str,
    moved: Motion,
    load: InertialParameters | None,
    seed: int,
    noise: float = RELATIVE_NOISE,
    memory: float = 0.0,
    arm: Simulator | None = None,
) -> Recording:
    """A recording with white noise, or with a third of it that remembers ``memory`` samples (AR(1)).

    By the robot of that name, or by another ``arm`` of its kind.
    """
    exact = (arm or simulator(name)).record(moved, load)
    sigma = noise * np.sqrt(np.mean(exact.torque**2, axis=0))
    noise_steps = lasting(np.random.default_rng([seed, 77]).standard_normal(moved.q.shape), memory)
    torque = exact.torque + sigma * noise_steps / (3.0 if memory else 1.0)
    return replace(exact, torque=torque, source=f"{'loaded' if load else 'unloaded'}.csv")
