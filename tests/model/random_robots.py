"""Serial robots of every kind the grouping rules know: seeded random ones, and all small ones of a grid."""

import math
from collections.abc import Iterator
from itertools import product
from typing import Literal

import numpy as np
from dynident.model import Joint, Robot
from dynident.model.drives import Drives
from dynident.model.frames import step

_Kind = Literal["revolute", "prismatic"]
_SPECIAL = (0.0, 90.0, -90.0, 180.0)


def random_robot(seed: int) -> Robot:
    """A robot of 2 to 8 joints: special and general angles, zero and other lengths, any gravity."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(2, 9))
    sliding = draw.choice([0.0, 0.2, 0.5, 0.8])
    special = draw.choice([1.0, 0.9, 0.6])
    joints = tuple(_random_joint(draw, sliding, special) for _ in range(n))
    drives = Drives(rotor_inertia=bool(draw.random() < 0.95), offsets=bool(draw.random() < 0.25))
    return Robot(f"random {seed}", joints, _random_gravity(draw, joints), drives)


def _random_joint(draw: np.random.Generator, sliding: float, special: float) -> Joint:
    def angle() -> float:
        if draw.random() < special:
            return math.radians(draw.choice(_SPECIAL))
        return math.radians(draw.choice(_SPECIAL) + draw.uniform(10.0, 80.0))

    def length() -> float:
        # Equal and opposite lengths too, so that offsets cancel at q = 0 and nowhere else.
        return float(draw.choice([0.0, 0.3, -0.3, draw.uniform(0.1, 1.0)], p=[0.5, 0.15, 0.15, 0.2]))

    kind: _Kind = "prismatic" if draw.random() < sliding else "revolute"
    theta = angle() if kind == "prismatic" or draw.random() < 0.3 else 0.0
    return Joint(kind, angle(), length(), theta, length())


def _random_gravity(draw: np.random.Generator, joints: tuple[Joint, ...]) -> tuple[float, float, float]:
    kind = draw.choice(["axis", "general", "first revolute axis"])
    if kind == "axis":
        direction = np.eye(3)[draw.integers(3)] * draw.choice([-1.0, 1.0])
    elif kind == "general":
        direction = draw.uniform(0.2, 1.0, 3) * draw.choice([-1.0, 1.0], 3)
    else:
        R = np.eye(3)
        for joint in joints:
            along_x, along_z = step(joint, 0.0)
            R = R @ along_x.R @ along_z.R
            if joint.revolute:
                break
        direction = R[:, 2]
    x, y, z = 9.81 * direction / np.linalg.norm(direction)
    return float(x), float(y), float(z)


def small_robots() -> Iterator[Robot]:
    """Every robot of one and two joints of a grid of special and some general geometries."""
    kinds: tuple[_Kind, ...] = ("revolute", "prismatic")
    angles = [math.radians(angle) for angle in (0.0, 90.0, 180.0, 35.0)]
    thetas = [math.radians(angle) for angle in (0.0, 90.0, 25.0)]
    gravities = ((0.0, 0.0, -9.81), (9.81, 0.0, 0.0), (3.0, -4.0, 8.0))
    firsts = [Joint(kind, alpha, 0.2, 0.0, 0.1) for kind, alpha in product(kinds, angles)]
    seconds = [
        Joint(kind, alpha, d, theta, r)
        for kind, alpha, d, theta, r in product(kinds, angles, (0.0, 0.4), thetas, (0.0, 0.3))
    ]
    for first, gravity, offsets in product(firsts, gravities, (False, True)):
        drives = Drives(offsets=offsets)
        yield Robot("one joint", (first,), gravity, drives)
        for second in seconds:
            yield Robot("two joints", (first, second), gravity, drives)
