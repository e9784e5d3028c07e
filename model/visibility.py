"""Visibility of a payload: torques show all ten parameters, some of them, or only sums of them.

The rows of the payload's regressor span what can be seen; a parameter is seen by itself if its unit vector lies in
that span. Constant torques and Coulomb friction of the joints are unknown too, so what they can explain is taken
out first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..common import Array, InputError, without
from .base import BaseParameters, base_parameters_of
from .drives import parameter_kind
from .inertia import INERTIAL
from .regressors import payload_columns, regressor_at, standard_columns
from .robot import Robot

Shown = Literal["yes", "no", "only with a known mass", "only in combination"]  # ways to see a parameter
_STATES = 60  # random states for each moving joint: more rows than columns many times over
_FAST = 2.0  # rad/s or m/s, where a joint has no speed limit
_STRONG = 6.0  # rad/s^2 or m/s^2


@dataclass(frozen=True)
class PayloadVisibility:
    """Visibility of a payload in the torques of some joints."""

    joints: tuple[int, ...]  # numbers of the joints whose torques count
    base: BaseParameters  # what the torques show: some of ``INERTIAL``, and what is grouped into them

    @property
    def rank(self) -> int:
        """Number of independent numbers that can be seen, of ten."""
        return len(self.base.chosen)

    @property
    def parameters(self) -> dict[str, Shown]:
        """Map each of ``INERTIAL`` to how it can be seen."""
        shown: dict[str, Shown] = dict.fromkeys(INERTIAL, "no")
        for name, row in zip(self.base.columns, self.base.grouping, strict=True):
            parts = {INERTIAL[k] for k in np.flatnonzero(row)}
            shown |= dict.fromkeys(parts, "only in combination")
            if parts <= {name, "M"}:
                shown[name] = "yes" if len(parts) == 1 else "only with a known mass"
        return shown

    @property
    def combinations(self) -> tuple[str, ...]:
        """Sums of which only the value is seen: "MZ + 0.117 M"."""
        sums = zip(self.base.grouping, self.base.sums(digits=4), strict=True)
        return tuple(text for row, text in sums if np.count_nonzero(row) > 1)

    @property
    def mass_visible(self) -> bool:
        """True if the torques determine the mass without further knowledge."""
        return self.parameters["M"] == "yes"

    def resolved(self, mass_known: bool) -> tuple[tuple[int, ...], Array, Array]:
        """Map from the least-squares values of the r chosen columns to what is determined: x = A theta + b M.

        Gives indices of x among ``INERTIAL``, k, with the mass itself where it is known; A, k x r; b, (k,), zero
        where the known mass M is not needed.
        """
        answers: tuple[Shown, ...] = ("yes", "only with a known mass") if mass_known else ("yes",)
        shown, chosen = self.parameters.values(), self.base.chosen
        indices = tuple(k for k, how in enumerate(shown) if how in answers or (k == 9 and mass_known))
        A, b = np.zeros((len(indices), self.rank)), np.ones(len(indices))
        for row, k in enumerate(indices):
            if k in chosen:
                own = chosen.index(k)
                A[row, own] = 1.0
                b[row] = -self.base.grouping[own, 9] if k != 9 and 9 not in chosen else 0.0
        return indices, A, b

    def combination(self, kind: str) -> str:
        """Sums that a parameter is part of; empty where there are none."""
        k = INERTIAL.index(kind)
        sums = zip(self.base.grouping, self.base.sums(digits=4), strict=True)
        return "; ".join(text for row, text in sums if row[k] and np.count_nonzero(row) > 1)


def visibility_of(W: Array, joints: Sequence[int]) -> PayloadVisibility:
    """Find what rows of some joints show: columns of the ten on many states, friction taken out, k x 10."""
    return PayloadVisibility(tuple(joints), base_parameters_of(INERTIAL, W))


def payload_visibility(
    robot: Robot, poses: Sequence[Array], joints: Sequence[int], ranges: Sequence[float]
) -> PayloadVisibility:
    """Find what the torques of moving joints show of a payload near some poses, the other joints held.

    By rank on random states in the ranges: the rows of held joints say nothing (stiction) and do not count.
    ``poses``: each of shape (n,) [rad or m]; ``ranges``: how far each joint moves to either side [rad or m].
    """
    moving = checked_joints(robot, joints)
    draw, count = np.random.default_rng(0), _STATES * max(len(moving), 2)
    q = np.vstack([np.tile(pose, (count, 1)) for pose in poses]).astype(float)
    qd, qdd = np.zeros((2, *q.shape))
    for j, reach in zip(moving, ranges, strict=True):
        speed = robot.joints[j].limits.speed
        q[:, j] += reach * draw.uniform(-1.0, 1.0, len(q))
        qd[:, j] = (speed if np.isfinite(speed) else _FAST) * draw.uniform(-1.0, 1.0, len(q))
        qdd[:, j] = _STRONG * draw.uniform(-1.0, 1.0, len(q))
    return visibility_in_states(robot, joints, q, qd, qdd)


def visibility_in_states(robot: Robot, joints: Sequence[int], q: Array, qd: Array, qdd: Array) -> PayloadVisibility:
    """Find what the torques of joints show in states, each (N, n), constant torques and dry friction taken out."""
    names = (*payload_columns(robot), *friction_columns(robot))
    W = regressor_at(robot, names, q, qd, qdd)
    rows = [without(W[j, :10].T, W[j, 10:].T) for j in checked_joints(robot, joints)]
    return visibility_of(np.vstack(rows), joints)


def friction_columns(robot: Robot) -> tuple[str, ...]:
    """Constant torques and Coulomb friction, of the robot ``with_offsets(True)``: what changes by the day."""
    names = standard_columns(robot.with_offsets(True))
    return tuple(name for name in names if parameter_kind(name) in ("OFF", "FS", "FSM"))


def checked_joints(robot: Robot, joints: Sequence[int]) -> list[int]:
    """Indices of joints, from 0."""
    if not joints or len(set(joints)) != len(joints) or not all(1 <= joint <= robot.n for joint in joints):
        numbers = ", ".join(map(str, joints)) or "none"
        raise InputError(f"joints {numbers}: give different numbers from 1 to {robot.n}")
    return [joint - 1 for joint in joints]


def check_mass_visible(visibility: PayloadVisibility, mass_known: bool, when: str) -> None:
    """Refuse joints whose torques do not hold the mass, unless it is known."""
    if visibility.mass_visible or mass_known:
        return
    joints = ", ".join(map(str, visibility.joints))
    sums = visibility.combination("M")
    why = f"they show it only in {sums}" if sums else "they do not contain it"
    fault = f"mass not visible {when}: the torques of joint {joints} alone leave it undetermined ({why})"
    raise InputError(f"{fault}; let another joint move, or weigh the payload and give --mass KG+-KG")
