"""Base parameters: combinations of standard parameters that torques determine, and their regressors (13).

They are found numerically, by QR of the regressor on random states (Gautier 1991), or by closed-form rules, as (12)
for the RX90 (Gautier and Khalil 1990). The rules go through the joints from the tip to the base. r1 is the first
revolute joint, r2 the next revolute one whose axis is not parallel to that of r1 (0 and 180 degrees are parallel).
To move a parameter to link j-1 is to add the same body, seen from frame j-1 at q = 0.

- Revolute j: YYj (with XXj - YYj left behind), MZj and Mj go to link j-1. For r1 <= j < r2: XXj, XYj, XZj and YZj
  have no effect; nor MXj and MYj where axis j coincides with that of r1, lies along gravity, and all earlier axes
  are parallel to it.
- Prismatic j: the inertia matrix goes to link j-1. j < r1: MXj, MYj and MZj have no effect. r1 < j < r2: parallel
  to r1, MZj has none, MXj and MYj go to link j-1; else the first moment along the axis of r1 has none.
- Coupled drives: IAk, FVMk and FSMk of rotor k, which turns with joints j and k, are base parameters of their own,
  whatever k is; but where j = k-1 is r1, or r2 orthogonal to it, and both axes are one direction, IAk goes into ZZk
  while ZZj loses it.
- Rotors: IA of r1 goes into ZZ of r1, IA of r2 into ZZ of r2 if and only if the two axes are orthogonal. For a
  prismatic j before r2 whose axis is parallel to every earlier revolute axis and orthogonal to every earlier
  prismatic one: if orthogonal to gravity, IAj goes into Mj while link j-1 loses a mass IAj; else that combination
  feels gravity alone, as a constant force, and a drive offset OFFj is grouped into it.

The rotor rule for prismatic joints is often stated for j = 1 only. That leaves a valid set that is not minimal; the
smallest case is two orthogonal prismatic joints, the second horizontal. With joint 1 vertical,

    Gamma1 = (M1 + M2) (q1'' + g) + IA1 q1'',    Gamma2 = (M2 + IA2) q2'',

M1, IA1, M2 and IA2 have three combinations only: M1R = M1 - IA2, IA1 and M2R = M2 + IA2.

The rules hold for any non-zero gravity and for coupled drives of joints that turn; QR covers the rest.
The geometry is taken as exact: from the angles that are snapped to a multiple of 90 degrees (1e-4 rad) up to
about 3e-3 rad from one, effects of the angle squared can be too small for QR to see.

The visibility of a payload is the question of the same kind: torques show all of its ten, some, or only sums.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from typing import Literal

import casadi as ca
import numpy as np

from ..common import Array, Brief, InputError, Mask, frozen_array, without
from ..common.linear import RANK_TOLERANCE
from .drives import parameter_kind
from .frames import frames_at, step
from .inertia import INERTIAL, InertialParameters, Pose
from .regressors import payload_columns, regressor, regressor_at, standard_columns
from .robot import Robot, check_robot

STATES_PER_JOINT = 12  # random states for each joint: n rows each, so 12 n^2 rows for at most 14 n columns
_PRECISION = 1e-15
_ROUNDING = 1e-10  # factor in a grouping below which it is rounding


@dataclass(frozen=True, eq=False, repr=False)
class BaseParameters(Brief):
    """The minimal parameters chi of (13).

    Attributes:
        standard: names of the standard parameters, N_s.
        chosen: positions in ``standard`` of those that stand for a base parameter, N_b, rising.
        grouping: G, N_b x N_s: base parameters = G @ standard parameters, and W_s = W_base @ G.
        decided_by: what found them.
        expressions: each base parameter written with the robot's own lengths, "D3^2*(M3+M4) + ZZ1", N_b texts;
            empty where nothing symbolic is known.
    """

    standard: tuple[str, ...]
    chosen: tuple[int, ...]
    grouping: Array
    decided_by: Literal["closed form", "QR"] = "QR"
    expressions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shape = (len(self.chosen), len(self.standard))
        exact = np.where(np.abs(self.grouping) < _ROUNDING, 0.0, self.grouping)
        object.__setattr__(self, "grouping", frozen_array(exact, shape, "grouping"))
        if self.expressions and len(self.expressions) != len(self.chosen):
            raise ValueError(f"{len(self.expressions)} expressions for {len(self.chosen)} base parameters")

    @property
    def columns(self) -> tuple[str, ...]:
        """Standard parameters whose columns make up W_base, N_b names ("XX2")."""
        return tuple(self.standard[k] for k in self.chosen)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, with R where others are grouped in ("XX2R")."""
        grouped = (np.abs(self.grouping) > 0).sum(axis=1) > 1
        return tuple(f"{name}R" if more else name for name, more in zip(self.columns, grouped, strict=True))

    @property
    def unidentifiable(self) -> tuple[str, ...]:
        """Standard parameters without any effect on the torques."""
        return tuple(name for name, column in zip(self.standard, self.grouping.T, strict=True) if not column.any())

    @property
    def eliminated(self) -> tuple[str, ...]:
        """Standard parameters that stand for no base parameter: grouped into others or without effect."""
        return tuple(name for name in self.standard if name not in self.columns)

    def groupings(self, symbolic: bool = False) -> tuple[str, ...]:
        """Write each base parameter as a sum: "XX2R = XX2 - YY2 - 0.2025 M3".

        Args:
            symbolic: with the robot's own lengths instead: "XX2R = -D3^2*(M3+M4) + XX2 - YY2".

        Raises:
            ValueError: if symbolic text is asked for and there is none.
        """
        if symbolic and not self.expressions:
            fault = f"base parameters decided by {self.decided_by} have no symbolic text"
            raise ValueError(f"{fault}: use closed_form_base_parameters")
        texts = self.expressions if symbolic else self.sums()
        return tuple(f"{name} = {text}" for name, text in zip(self.names, texts, strict=True))

    def sums(self, digits: int = 6) -> tuple[str, ...]:
        """Write what each base parameter is: "XX2 - YY2 - 0.2025 M3"."""
        rows = zip(self.chosen, self.grouping, strict=True)
        return tuple(sum_text(self.standard[k], self.standard, row, digits) for k, row in rows)

    def value(self, parameters: Mapping[str, float]) -> Array:
        """Evaluate the base parameters of a robot with the given standard parameters, shape (N_b,).

        Raises:
            KeyError: if a standard parameter is missing.
        """
        return np.asarray(self.grouping @ np.array([parameters[name] for name in self.standard]))

    def effect_of(self, columns: tuple[str, ...]) -> Array:
        """Derivatives of the base parameters by some standard parameters, N_b x ``len(columns)``.

        With the last link's ten it is the map from a payload to base parameters behind (25)-(28).
        """
        return self.grouping[:, [self.standard.index(name) for name in columns]]


def sum_text(first: str, names: Sequence[str], factors: Array, digits: int = 6) -> str:
    """Write a sum of parameters, ``first`` with a factor of 1: "XX2 - YY2 - 0.2025 M3"."""
    text = first
    for name, factor in zip(names, factors.tolist(), strict=True):
        if factor and name != first:
            size = "" if abs(abs(factor) - 1.0) < 1e-9 else f"{abs(factor):.{digits}g} "
            text += f" {'-' if factor < 0.0 else '+'} {size}{name}"
    return text


def base_regressor(robot: Robot, base: BaseParameters) -> ca.Function:
    """``base_regressor(q, qd, qdd) -> Phi``, n x N_b, columns as ``base.columns`` (13)."""
    return regressor(robot, base.columns, "base_regressor")


@lru_cache(maxsize=32)
def base_parameters(robot: Robot, seed: int = 0) -> BaseParameters:
    """Base parameters of a robot, drives included, as a left-to-right choice of columns.

    Columns are taken base to tip in the order of (6); a column that depends on those before it is grouped
    into them. This finds the same names as Khalil's closed-form rules. They are kept: a command asks for those of
    one robot several times.

    >>> base_parameters(robot).groupings()[3]
    'XX2R = XX2 - YY2 - 0.2025 M3 - 0.2025 M4 - 0.2025 M5 - 0.2025 M6'
    """
    check_robot(robot)
    count = STATES_PER_JOINT * robot.n
    W = stacked_regressor(robot, *random_states(robot, count, seed))
    for joint in robot.drives.unmeasured:
        W[(joint - 1) * count : joint * count] = 0.0
    return base_parameters_of(standard_columns(robot), W)


def base_parameters_of(columns: tuple[str, ...], W: Array) -> BaseParameters:
    """Find the base parameters that a standard regressor W on many states shows, at least N_s rows x N_s."""
    R = np.asarray(np.linalg.qr(W, mode="r"))
    residuals = left_residuals(R)
    chosen = np.flatnonzero(residuals > RANK_TOLERANCE)
    grouping = np.zeros((len(chosen), W.shape[1]))
    rest = np.setdiff1d(np.arange(W.shape[1]), chosen)
    grouping[:, chosen] = np.eye(len(chosen))
    size = np.linalg.norm(R[:, chosen], axis=0)
    grouping[:, rest] = np.linalg.lstsq(R[:, chosen] / size, R[:, rest], rcond=None)[0] / size[:, None]
    # What is nearly dependent is known to so many digits less.
    grouping[np.abs(grouping) < _PRECISION / residuals[chosen].min(initial=1.0)] = 0.0
    return BaseParameters(columns, tuple(chosen.tolist()), grouping, "QR")


def random_states(robot: Robot, count: int, seed: int) -> tuple[Array, Array, Array]:
    """Random q, qd, qdd of shape (count, n), of the order of 1 in SI units."""
    draw = np.random.default_rng(seed)
    span = np.array([np.pi if joint.revolute else 1.0 for joint in robot.joints])
    q = draw.uniform(-1.0, 1.0, (count, robot.n)) * span
    qd, qdd = draw.uniform(-3.0, 3.0, (2, count, robot.n))
    return q, qd, qdd


def stacked_regressor(robot: Robot, q: Array, qd: Array, qdd: Array) -> Array:
    """Evaluate the standard regressor on all states, one below the other: (count * n) x N_s."""
    # Friction may depend on load, which any parameters may cause.
    load = np.random.default_rng(len(q)).uniform(-1.0, 1.0, q.shape)
    W = regressor_at(robot, robot.standard, q, qd, qdd, load).transpose(0, 2, 1).reshape(q.size, -1)
    if not np.isfinite(W).all():
        names = [robot.standard[k] for k in np.flatnonzero(~np.isfinite(W).all(axis=0))]
        raise InputError(f"{', '.join(names)}: the law is no number at some speed, position or load: correct it")
    return W


def leftmost_independent(W: Array) -> list[int]:
    """Indices of the columns of ``W`` that do not depend on those to their left."""
    return [int(k) for k in np.flatnonzero(left_residuals(W) > RANK_TOLERANCE)]


def left_residuals(W: Array) -> Array:
    """Residual of each column without those to its left, over the largest column; ``RANK_TOLERANCE`` decides."""
    largest = np.linalg.norm(W, axis=0).max(initial=0.0) or 1.0
    residuals, basis = np.zeros(W.shape[1]), W[:, :0]
    for k, column in enumerate(W.T):
        # Orthogonalised twice, so that the decision does not hang on rounding.
        residual = column - basis @ (basis.T @ column)
        residual -= basis @ (basis.T @ residual)
        size = np.linalg.norm(residual)
        residuals[k] = size / largest
        if residuals[k] > RANK_TOLERANCE:
            basis = np.column_stack([basis, residual / size])
    return residuals


Shown = Literal["yes", "no", "only with a known mass", "only in combination"]  # ways to see a parameter
_STATES = 60  # random states for each moving joint: more rows than columns many times over
_FAST = 2.0  # rad/s or m/s, where a joint has no speed limit
_STRONG = 6.0  # rad/s^2 or m/s^2


@dataclass(frozen=True)
class PayloadVisibility:
    """Visibility of a payload in the torques of some joints, constant torques and Coulomb friction taken out first.

    A parameter is seen by itself if its unit vector lies in what the rows of the payload's regressor span.
    """

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


_ZERO = 1e-9  # cosine, sine or length that is rounding: nearly special geometry was snapped when the robot was made
_ROUNDED = 1e-12  # factor of a parameter that comes from rounded sines and cosines
_Monomial = tuple[str, ...]  # factors of a product of lengths in alphabetical order: D3^2 is ("D3", "D3")


Move = tuple[str, int, dict[str, float], bool]
"""Application of one rule: its name, the joint from 0, what has no effect on the torques when added to the joint's
parameters, by kind, of which the first ("YY") is grouped away, and whether link j-1 has to lose the same body."""


def closed_form_base_parameters(robot: Robot) -> BaseParameters:
    """Base parameters of a serial robot by the rules above, with symbolic expressions.

    Raises:
        InputError: without gravity, if one name stands for two lengths, or for coupled drives that no rule covers.
    """
    lengths: dict[str, float] = {}
    for number, joint in enumerate(robot.joints, 1):
        for name, value in zip(joint.names, (joint.d, joint.r), strict=True):
            if name and not math.isclose(lengths.setdefault(name, value), value):
                fault = f"joint {number} has length {name!r} = {value:g}, an earlier one {lengths[name]:g}"
                raise InputError(f"robot {robot.name!r}: {fault}: give them different names")
    columns, regroupings = standard_columns(robot), moves(robot)
    dropped = {f"{next(iter(change))}{j + 1}" for _, j, change, _ in regroupings}
    chosen = [k for k, name in enumerate(columns) if name not in dropped]

    def at(**sizes: float) -> Array:
        return _grouping(robot, regroupings, dict.fromkeys(lengths, 0.0) | sizes)

    # A grouping is of second degree in the lengths, so some of its values give all coefficients: Steiner's theorem
    # has squares, and what was moved once has no longer terms.
    names, constant = sorted(lengths), at()
    plus, minus = ({name: at(**{name: size}) for name in names} for size in (1.0, -1.0))
    terms: dict[_Monomial, Array] = {(): constant} | {(x,): 0.5 * (plus[x] - minus[x]) for x in names}
    terms |= {(x, x): 0.5 * (plus[x] + minus[x]) - constant for x in names}
    for a, b in combinations(names, 2):
        terms[a, b] = at(**{a: 1.0, b: 1.0}) - plus[a] - plus[b] + constant
    texts = (_sum_text(columns, {product: part[row] for product, part in terms.items()}) for row in chosen)
    exact = _grouping(robot, regroupings, {})[chosen]
    return BaseParameters(columns, tuple(chosen), exact, "closed form", tuple(texts))


def moves(robot: Robot) -> list[Move]:
    """List all applications of the rules to a robot, tip to base; errors as ``closed_form_base_parameters``."""
    if not any(robot.gravity):
        fault = f"robot {robot.name!r} has no gravity, which the closed-form rules need"
        raise InputError(f"{fault}: use base_parameters")
    n, turns = robot.n, np.array([joint.revolute for joint in robot.joints])
    frames = frames_at(replace(robot, base=Pose()), [0.0] * n)[1:-1]
    axes, origins = np.array([frame.R[:, 2] for frame in frames]), np.array([frame.p for frame in frames])
    parallel, orthogonal = _lie_along(axes[:, None], axes), np.abs(axes @ axes.T) < _ZERO
    # First revolute joint, and the next one whose axis is not parallel to its; n where there is none.
    r1 = next(iter(np.flatnonzero(turns).tolist()), n)
    r2 = next((j for j in range(r1, n) if turns[j] and not parallel[j, r1]), n)
    # Every revolute axis on the way has to coincide: two offsets may cancel at q = 0 only.
    apart = turns & ~_lie_along(origins - origins[min(r1, n - 1)], axes[min(r1, n - 1)])
    gravity, weight = np.array(robot.gravity), math.hypot(*robot.gravity)
    about_gravity = np.logical_and.accumulate(_lie_along(axes, gravity / weight) & ~apart)
    rotors = {r1: "r1", r2: "r2"} if r2 < n and orthogonal[r2, r1] else {r1: "r1"}
    if robot.coupling:  # rotor k turns with both joints, next to each other like ZZ of link k less ZZ of link j
        k, (a, b) = robot.coupling.joints[1] - 1, sorted(joint - 1 for joint in robot.coupling.joints)
        follows = a in rotors and not turns[a + 1 : b].any()
        alike = follows and bool(axes[a] @ axes[b] > 1.0 - _ZERO)
        if not (turns[a] and turns[b]) or (follows and k == a) or (alike and b > a + 1):
            raise InputError(f"robot {robot.name!r} has coupled drives that no rule covers: use base_parameters")
        rotors[k] = "beside" if alike else ""
    regroupings: list[Move] = []
    for j in reversed(range(n)):
        before_r2, rotor, drives = j < r2, rotors.get(j), [*map(parameter_kind, robot.drives.names(j + 1))]
        rules: list[tuple[str, bool, Sequence[str | dict[str, float]], bool]]
        if turns[j]:
            rules = [
                ("revolute: YY to link j-1", True, [{"YY": 1.0, "XX": 1.0}], True),
                ("revolute: MZ to link j-1", True, ["MZ"], True),
                ("revolute: M to link j-1", True, ["M"], True),
                ("revolute before r2: no XX, XY, XZ, YZ", before_r2, ["XX", "XY", "XZ", "YZ"], False),
                ("revolute about gravity: no MX, MY", before_r2 and bool(about_gravity[j]), ["MX", "MY"], False),
                (f"rotor of {rotor} into ZZ", bool(rotor), [{"IA": 1.0, "ZZ": -1.0}], rotor == "beside"),
            ]
        else:
            first = np.zeros(3) if j < r1 else frames[j].R.T @ axes[r1]  # axis of r1 in frame j
            reverse = zip(INERTIAL[8:5:-1], first[::-1].tolist(), strict=True)
            along = {kind: x for kind, x in reverse if abs(x) > _ZERO}
            last, between = next(iter(along), ""), r1 < j < r2
            beside = between and bool(np.hypot(*first[:2]) < _ZERO)
            # A rotor without its mass, on a link that is lighter by as much: only gravity can still tell.
            alone = before_r2 and bool(np.where(turns[:j], parallel[:j, j], orthogonal[:j, j]).all())
            pull = float(axes[j] @ gravity)
            level, pulled = abs(pull) <= _ZERO * weight, alone and robot.drives.rotor_inertia
            # FA is 1 for a joint that moves, as OFF is; a robot has one of them.
            lighter = {"FA" if "FA" in drives else "OFF": pull, "M": 1.0, "IA": -1.0}
            rules = [
                ("prismatic: inertia to link j-1", True, INERTIAL[:6], True),
                ("prismatic before r1: no MX, MY, MZ", j < r1, INERTIAL[6:9], False),
                ("prismatic parallel to r1: no MZ", beside, ["MZ"], False),
                ("prismatic parallel to r1: MX, MY to link j-1", beside, ["MX", "MY"], True),
                (f"prismatic not parallel to r1: no {last}", between and not beside, [along], False),
                ("prismatic rotor into M", alone and level, [{"IA": 1.0, "M": -1.0}], True),
                ("prismatic offset into M and IA", pulled and not level, [lighter], True),
            ]
        for rule, holds, changes, to_parent in rules:
            for change in changes if holds else ():
                parts = {change: 1.0} if isinstance(change, str) else change
                if next(iter(parts)) in (*INERTIAL, *drives):
                    regroupings.append((rule, j, parts, to_parent))
    return regroupings


def _lie_along(vectors: Array, axes: Array) -> Mask:
    return np.asarray(np.linalg.norm(np.cross(vectors, axes), axis=-1) < _ZERO)


def _grouping(robot: Robot, regroupings: Sequence[Move], lengths: Mapping[str, float]) -> Array:
    """Carry out the moves: row k starts as parameter k and becomes what it stands for, N_s x N_s."""
    index, links = {name: k for k, name in enumerate(robot.standard)}, list[Pose]()
    rows = np.eye(len(index))
    for joint in robot.joints:  # a length that is zero has no name
        sizes = zip(joint.names, (joint.d, joint.r), strict=True)
        d, r = (lengths.get(name, x) if x else 0.0 for name, x in sizes)
        along_x, along_z = step(replace(joint, d=d, r=r), 0.0)
        links.append(along_x @ along_z)
    for _, j, change, to_parent in regroupings:
        dropped, factor = next(iter(change.items()))
        amount = rows[index[f"{dropped}{j + 1}"]] / factor
        for kind, size in change.items():
            rows[index[f"{kind}{j + 1}"]] -= amount * size
        if to_parent and j > 0:
            body = InertialParameters(np.array([change.get(kind, 0.0) for kind in INERTIAL]))
            for name, size in body.moved(links[j].R, links[j].p).named(str(j)).items():
                rows[index[name]] += amount * size
    return rows


def _sum_text(columns: Sequence[str], terms: Mapping[_Monomial, Array]) -> str:
    """Write a sum of products of lengths, factors and parameters as (12) prints it: "IA1 + D3^2*(M3+M4) + YY2".

    Parameters with the same factor share a bracket, factors are in alphabetical order, terms in that of their last.
    """
    groups: dict[tuple[_Monomial, float, str], list[str]] = {}
    for product, factors in terms.items():
        for name, factor in zip(columns, factors.tolist(), strict=True):
            if abs(factor) > _ROUNDED:
                rounded = float(f"{factor:.9g}")
                alone = name if not product and abs(rounded) == 1.0 else ""
                groups.setdefault((product, rounded, alone), []).append(name)
    parts = []
    for (product, factor, _), group in groups.items():
        first, *more = sorted(group)
        bracket = f"({'+'.join([first, *more])})" if more else first
        powers = sorted({**Counter(product), first: 1}.items())
        texts = [] if abs(factor) == 1.0 else [f"{abs(factor):.6g}"]
        for name, power in powers:
            texts.append(bracket if name == first else name if power == 1 else f"{name}^{power}")
        parts.append((powers[::-1], f" {'-' if factor < 0 else '+'} {'*'.join(texts)}"))
    text = "".join(part for _, part in sorted(parts))
    return ("-" if text.startswith(" -") else "") + text[3:]
