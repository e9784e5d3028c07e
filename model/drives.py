"""Drives' part of a joint's torque: friction (2), rotor inertia (3), coupling (8)-(11), spring, offset."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from ..common import Array, InputError
from .friction import LAWS, PAPER, Friction


def parameter_kind(name: str) -> str:
    """Kind of a parameter without its joint: "XX" of "XX3"."""
    return name.rstrip("0123456789")


def joint_of(name: str) -> int:
    """Index of the joint or link, from 0, of a parameter such as "FS2"."""
    return int(name.removeprefix(parameter_kind(name))) - 1


SPRING = "SPRING"  # kind of the parameter that is 1 where a spring's torque is a column


@dataclass(frozen=True)
class Coupling:
    """Two drives coupled as in (8): motor k turns with the sum of the joint speeds j and k.

    Attributes:
        joints: numbers (j, k) of the coupled joints; rotor k feels both.
        coulomb: sign of rotor k's Coulomb friction. "sum": sign(q'j + q'k) on both joints, which is what
            the duality of (8) and (9) gives; "paper": sign(q'k) on j and sign(q'j) on k, as (10) and (11)
            are printed.
        rows: whose torques the equations are: the joints', or the motors' on the joint side, that of motor j
            being the torque of joint j less that of joint k (9).
    """

    joints: tuple[int, int]
    coulomb: Literal["sum", "paper"] = "sum"
    rows: Literal["joint", "motor"] = field(default="joint", repr=False)

    def __post_init__(self) -> None:
        if self.coulomb not in ("sum", "paper"):
            raise ValueError(f"coulomb must be 'sum' or 'paper', got {self.coulomb!r}")
        if self.joints[0] == self.joints[1]:
            raise ValueError("coupled joints must differ")

    def joint_torques(self, motors: Array) -> Array:
        """Convert torques of the motors on the joint side to those of the joints, both N x n [N·m] (9)."""
        torques, (j, k) = np.array(motors, dtype=np.float64), self.joints
        torques[:, j - 1] += torques[:, k - 1]
        return torques

    def motor_torques(self, joints: Array) -> Array:
        """Convert torques of the joints to those of the motors on the joint side, both N x n [N·m] (9)."""
        torques, (j, k) = np.array(joints, dtype=np.float64), self.joints
        torques[:, j - 1] -= torques[:, k - 1]
        return torques


@dataclass(frozen=True)
class Spring:
    """A known torque on one joint, by a table or by the law of a spring between two pivots.

    Geometric law: tau = k (1 - L0/L) a b sin(psi), L^2 = a^2 + b^2 + 2 a b cos(psi), psi = q - q0.

    Attributes:
        joint: number of the joint.
        stiffness: k [N/m]; length: L0 [m]; arms: a, b [m]; zero: q0 [rad].
        table: (q [rad], torque [N·m]) pairs with rising q, linear in between; excludes the geometric law.
        column: whether its torque is a column of the model, a parameter SPRINGj that is 1, and not on the left-hand
            side: where only currents are known, the left-hand side has no scale of its own.
    """

    joint: int
    stiffness: float = 0.0
    length: float = 0.0
    arms: tuple[float, float] = (0.0, 0.0)
    zero: float = 0.0
    table: tuple[tuple[float, float], ...] = ()
    column: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        geometric = self.stiffness > 0.0 and min(self.arms) > 0.0 and self.length >= 0.0
        if geometric == bool(self.table):
            raise ValueError("a spring needs either a table or stiffness, length and arms")
        angles = [angle for angle, _ in self.table]
        if self.table and (len(angles) < 2 or any(b <= a for a, b in pairwise(angles))):
            raise ValueError("a spring table needs at least two rows with rising angles")

    def torque(self, q: Array) -> Array:
        """Torque of the spring on its joint [N·m] at the angles ``q`` [rad], same shape.

        Raises:
            InputError: if an angle lies outside the table.
        """
        low, high = (self.table[0][0], self.table[-1][0]) if self.table else (-math.inf, math.inf)
        if q.size and (q.min() < low or q.max() > high):
            reach = f"joint {self.joint} moves from {q.min():.3f} to {q.max():.3f} rad"
            table = f"the spring's table ({low:.3f} to {high:.3f} rad)"
            raise InputError(f"{reach}, outside {table}: extend the table")
        return np.asarray(self.law(q, np))

    def law(self, q: Any, lib: Any = ca) -> Any:
        """Torque as an expression, or of arrays by NumPy; a table goes on linearly beyond its ends."""
        if self.table:
            angles, torques = np.array(self.table).T
            if lib is ca:
                return ca.pw_lin(q, angles.tolist(), torques.tolist())
            k = np.clip(np.searchsorted(angles, q) - 1, 0, len(angles) - 2)
            return torques[k] + (q - angles[k]) * (np.diff(torques) / np.diff(angles))[k]
        a, b = self.arms
        psi = q - self.zero
        stretched = lib.sqrt(a * a + b * b + 2.0 * a * b * lib.cos(psi))
        return self.stiffness * (1.0 - self.length / stretched) * a * b * lib.sin(psi)


@dataclass(frozen=True)
class Drives:
    """Drive parameters that the model has, for every joint alike.

    Attributes:
        rotor_inertia: IA of (3).
        friction: its terms; FS and FV of (2) by default.
        offsets: a constant torque OFF per joint.
        unmeasured: numbers of joints whose torques a recording does not hold, for their channels are dead.
        side: where torque is measured: at the motor, whatever its unit, or by sensors on the link side of the gear,
            which see no rotor. Bearings and seals behind them may still rub.
    """

    rotor_inertia: bool = True
    friction: tuple[Friction, ...] = PAPER
    offsets: bool = False
    coupling: Coupling | None = None
    spring: Spring | None = None
    side: Literal["motor", "link"] = field(default="motor", repr=False)
    unmeasured: tuple[int, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        order = [*LAWS, *sorted(term.kind for term in self.friction)]
        object.__setattr__(self, "friction", tuple(sorted(self.friction, key=lambda term: order.index(term.kind))))

    def check(self, n: int) -> None:
        """Refuse drives that name joints which a robot of ``n`` joints lacks."""
        named = [term.joint for term in self.friction if term.joint]
        named += self.coupling.joints if self.coupling else ()
        named += [self.spring.joint] if self.spring else []
        for joint in named:
            if not 1 <= joint <= n:
                raise InputError(f"drives name joint {joint}, the robot has joints 1 to {n}")
        for joint in range(1, n + 1):
            kinds = [term.kind for term in self.friction if term.at(joint)]
            if len(set(kinds)) < len(kinds):
                raise InputError(f"joint {joint} has a term of friction twice: {', '.join(kinds)}")
        if self.offsets and any(term.kind == "FA" for term in self.friction):
            raise InputError("friction FA and the offsets are one column of a joint that moves: leave out one")
        if self.coupling and not self.fit_for_coupling:
            raise InputError("coupled drives need rotor inertia and friction FS and FV at all joints")
        if self.side == "link" and self.rotor_inertia:
            raise ValueError("sensors on the link side see no rotor inertia")

    @staticmethod
    def on_link_side() -> "Drives":
        """Drives seen by torque sensors behind the gears: an offset of the sensor, no rotor, no friction."""
        return Drives(rotor_inertia=False, friction=(), offsets=True, side="link")

    @property
    def fit_for_coupling(self) -> bool:
        """True if they have what (8)-(11) say of coupled drives: rotor inertia, FS and FV at all joints."""
        return self.rotor_inertia and set(PAPER) <= set(self.friction)

    @property
    def loaded(self) -> tuple[str, ...]:
        """Kinds of friction that depend on the torque that a gear carries."""
        return tuple(term.kind for term in self.friction if term.loaded)

    def names(self, joint: int) -> tuple[str, ...]:
        """Names of one joint's drive parameters, in the order of (6), the offset and a spring's column last."""
        friction = tuple(term.kind for term in self.friction if term.at(joint))
        springs = self.spring is not None and self.spring.column and self.spring.joint == joint
        kinds = ("IA",) * self.rotor_inertia + friction + ("OFF",) * self.offsets + (SPRING,) * springs
        return tuple(f"{kind}{joint}" for kind in kinds)


class DriveState(NamedTuple):
    """State of the joints that drives depend on; each n x 1, or as arrays n x N."""

    q: Any
    qd: Any
    qdd: Any
    load: Any  # torques of links, payload and spring [N·m or N], which the gears carry


Sign = Callable[[Any], Any]  # function that stands for the sign in dry friction


def smooth_sign(width: Any) -> Sign:
    """Differentiable sign tanh(v / width); ``width`` in the speed's unit."""
    return lambda speed: ca.tanh(speed / width)


def drive_terms(drives: Drives, state: DriveState, sign: Sign = ca.sign) -> dict[str, dict[int, Any]]:
    """Factors of each drive parameter, row by row: {"FV2": {1: qd2}}.

    ``sign``: what stands for the sign in dry friction; NumPy's where the state is of arrays.
    Source: (2), (3) and, for coupled drives, (10) and (11). Of these, terms other than the paper's are of
    the motors' gears: motor j turns with joint j and carries its torque less joint k's (9), motor k turns with both
    and carries joint k's, and what it needs more stands in both joints' torques.
    """
    (q, qd, qdd, load), terms = state, dict[str, dict[int, Any]]()
    pair = [joint - 1 for joint in drives.coupling.joints] if drives.coupling else []
    for row in range(qd.shape[0]):
        if drives.rotor_inertia:
            terms[f"IA{row + 1}"] = {row: qdd[row]}
        for term in drives.friction:
            if not term.at(row + 1):
                continue
            speed, carried, rows = qd[row], load[row], [row]
            if row in pair and term not in PAPER:
                j, k = pair
                if row == j:
                    carried = load[j] - load[k]
                else:
                    speed, rows = qd[j] + qd[k], pair
            value = term.value(speed, sign(speed), q[row], carried)
            terms[f"{term.kind}{row + 1}"] = dict.fromkeys(rows, value)
        if drives.offsets:
            terms[f"OFF{row + 1}"] = {row: 1.0}
    if drives.coupling:
        j, k = pair
        terms[f"IA{k + 1}"][j] = qdd[k]
        terms[f"IA{k + 1}"][k] = qdd[k] + qdd[j]
        terms[f"FVM{k + 1}"] = {j: qd[k], k: qd[j]}
        both, printed = sign(qd[j] + qd[k]), {j: sign(qd[k]), k: sign(qd[j])}
        terms[f"FSM{k + 1}"] = {j: both, k: both} if drives.coupling.coulomb == "sum" else printed
    return terms
