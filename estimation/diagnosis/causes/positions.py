"""Joints that are counted otherwise than the robot's description counts them."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from ....model import Robot
from .misfit import Model
from .sample import Sample
from .suspect import Suspect


def backwards(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """A joint that turns the other way, in position alone or in torque too."""
    for j in range(robot.n):
        sign = np.ones(robot.n)
        sign[j] = -1.0
        turned = replace(sample, q=sample.q * sign, qd=sample.qd * sign, qdd=sample.qdd * sign)
        model = Model.of(robot, turned)
        yield Suspect(f"the sign of q{j + 1} is wrong", model.misfit())
        yield Suspect(
            f"joint {j + 1} is counted the other way, in position and torque", model.misfit(sample.torque * sign)
        )


def exchanged(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """Two joints that changed places."""
    for i, j in combinations(range(robot.n), 2):
        order = list(range(robot.n))
        order[i], order[j] = j, i
        other = replace(
            sample, q=sample.q[:, order], qd=sample.qd[:, order], qdd=sample.qdd[:, order],
            keep=sample.keep[:, order], torque=sample.torque[:, order],
        )  # fmt: skip
        model = Model.of(robot, other)
        yield Suspect(f"joints {i + 1} and {j + 1} are exchanged", model.misfit())
        yield Suspect(f"the positions of joints {i + 1} and {j + 1} are exchanged", model.misfit(sample.torque))


def zeros(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """A joint whose zero lies a quarter or half turn away."""
    for j in range(1, robot.n):
        for degrees in (90, -90, 180):
            q = np.array(sample.q)
            q[:, j] += np.radians(degrees)
            yield Suspect(
                f"the zero of q{j + 1} is off by {abs(degrees)} degrees",
                Model.of(robot, replace(sample, q=q)).misfit(),
            )


def frozen(robot: Robot, sample: Sample) -> Iterator[Suspect]:
    """An encoder that sticks while the robot moves on."""
    for j in range(robot.n):
        still = sample.stuck[:, j]
        if not still.any() or still.all():
            continue
        rest = replace(sample, keep=sample.keep & ~still[:, None])
        start, stop = sample.t[still][0], sample.t[still][-1]
        yield Suspect(
            f"the encoder of joint {j + 1} is stuck from {start:.3g} s to {stop:.3g} s",
            Model.of(robot, rest).misfit(),
        )
