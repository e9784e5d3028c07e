"""Base parameters of a serial robot by closed-form rules, as (12) for the RX90 (Gautier and Khalil 1990).

Joints from the tip to the base. r1 is the first revolute joint, r2 the next revolute one whose axis is not
parallel to that of r1 (0 and 180 degrees are parallel). To move a parameter to link j-1 is to add the same body,
seen from frame j-1 at q = 0.

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
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, combinations, groupby
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError, Mask
from ..drives import parameter_kind
from ..frames import FrameChange, frames_at
from ..inertia import INERTIAL, InertialParameters
from ..pose import Pose
from ..regressors import standard_columns
from ..robot import Joint, Robot
from .parameters import BaseParameters

_ZERO = 1e-9  # cosine, sine or length that is rounding: nearly special geometry was snapped when the robot was made
_ROUNDING = 1e-12  # factor of a parameter that comes from rounded sines and cosines
_Monomial = tuple[str, ...]  # factors of a product of lengths in alphabetical order: D3^2 is ("D3", "D3")


class Move(NamedTuple):
    """Application of one rule: parameter ``drop`` of a joint is grouped away."""

    rule: str  # the rule's name
    joint: int  # index from 0
    drop: str  # kind of the parameter that goes ("YY")
    change: dict[str, float]  # what has no effect on the torques when added to the joint's parameters, by kind
    to_parent: bool  # whether link j-1 has to lose the same body


def closed_form_base_parameters(robot: Robot) -> BaseParameters:
    """Base parameters of a serial robot by the rules above, with symbolic expressions.

    Raises:
        InputError: without gravity, if one name stands for two lengths, or for coupled drives that no rule covers.
    """
    lengths: dict[str, float] = {}
    for number, joint in enumerate(robot.joints, 1):
        for name, value in zip(joint.names, (joint.d, joint.r), strict=True):
            if name and not math.isclose(lengths.setdefault(name, value), value):
                raise InputError(
                    f"robot {robot.name!r}: joint {number} has length {name!r} = {value:g}, an earlier one "
                    f"{lengths[name]:g}: give them different names"
                )
    columns, regroupings = standard_columns(robot), moves(robot)
    dropped = {f"{move.drop}{move.joint + 1}" for move in regroupings}
    chosen = [k for k, name in enumerate(columns) if name not in dropped]

    def grouping(lengths: Mapping[str, float]) -> Array:
        joints = []
        for joint in robot.joints:  # a length that is zero has no name
            d, r = (
                lengths.get(name, x) if x else 0.0 for name, x in zip(joint.names, (joint.d, joint.r), strict=True)
            )
            joints.append(replace(joint, d=d, r=r))
        return _grouping(regroupings, joints, columns)[chosen]

    terms = _second_degree(grouping, sorted(lengths))
    expressions = [
        _sum_text((product, factors[row, k], name) for product, factors in terms for k, name in enumerate(columns))
        for row in range(len(chosen))
    ]
    return BaseParameters(columns, tuple(chosen), grouping({}), "closed form", tuple(expressions))


def moves(robot: Robot) -> list[Move]:
    """List all applications of the rules to a robot, tip to base.

    Raises:
        InputError: without gravity, or for coupled drives that no rule covers.
    """
    if not any(robot.gravity):
        raise InputError(
            f"robot {robot.name!r} has no gravity, which the closed-form rules need: use base_parameters"
        )
    n, turns = robot.n, np.array([joint.revolute for joint in robot.joints])
    frames = frames_at(replace(robot, base=Pose()), [0.0] * n)[1:-1]
    axes, origins = np.array([frame.R[:, 2] for frame in frames]), np.array([frame.p for frame in frames])
    parallel, orthogonal = _lie_along(axes[:, None], axes), np.abs(axes @ axes.T) < _ZERO
    # First revolute joint, and the next one whose axis is not parallel to its; n where there is none.
    r1 = next(iter(np.flatnonzero(turns).tolist()), n)
    r2 = next((j for j in range(r1, n) if turns[j] and not parallel[j, r1]), n)
    # Every revolute axis on the way has to coincide: two offsets may cancel at q = 0 only.
    apart = turns & ~_lie_along(origins - origins[min(r1, n - 1)], axes[min(r1, n - 1)])
    gravity = np.array(robot.gravity) / math.hypot(*robot.gravity)
    # Of coupled drives rotor k turns with both joints.
    coupled = [joint - 1 for joint in robot.coupling.joints] if robot.coupling else [n, n]
    beside = _beside(robot, coupled, axes, [r1, r2] if r2 < n and orthogonal[r2, r1] else [r1])
    about_gravity = np.logical_and.accumulate(_lie_along(axes, gravity) & ~apart)
    regroupings: list[Move] = []
    for j in reversed(range(n)):
        if turns[j]:
            rotor = "r1" if j == r1 else "r2" if j == r2 and orthogonal[j, r1] else ""
            if j == coupled[1]:
                rotor = "beside" if beside else ""
            rules = _revolute(j, j < r2, bool(about_gravity[j]), rotor)
        else:
            rules = _prismatic(j, None if j < r1 else frames[j].R.T @ axes[r1], j < r2)
            if j < r2 and np.where(turns[:j], parallel[:j, j], orthogonal[:j, j]).all():
                rules = chain(rules, _prismatic_rotor(robot, j, float(axes[j] @ np.array(robot.gravity))))
        known = (*INERTIAL, *(parameter_kind(name) for name in robot.drives.names(j + 1)))
        regroupings += [move for move in rules if move.drop in known]
    return regroupings


def _lie_along(vectors: Array, axes: Array) -> Mask:
    return np.asarray(np.linalg.norm(np.cross(vectors, axes), axis=-1) < _ZERO)


def _revolute(j: int, before_r2: bool, about_gravity: bool, rotor: str) -> Iterator[Move]:
    """Apply the rules of a revolute joint; ``rotor``: "r1" or "r2" where that rule holds."""
    yield Move("revolute: YY to link j-1", j, "YY", {"XX": 1.0, "YY": 1.0}, True)
    yield Move("revolute: MZ to link j-1", j, "MZ", {"MZ": 1.0}, True)
    yield Move("revolute: M to link j-1", j, "M", {"M": 1.0}, True)
    for kind in ("XX", "XY", "XZ", "YZ") if before_r2 else ():
        yield Move("revolute before r2: no XX, XY, XZ, YZ", j, kind, {kind: 1.0}, False)
    for kind in ("MX", "MY") if before_r2 and about_gravity else ():
        yield Move("revolute about gravity: no MX, MY", j, kind, {kind: 1.0}, False)
    if rotor:
        yield Move(f"rotor of {rotor} into ZZ", j, "IA", {"IA": 1.0, "ZZ": -1.0}, rotor == "beside")


def _beside(robot: Robot, coupled: Sequence[int], axes: Array, first: Sequence[int]) -> bool:
    """True if rotor k of coupled drives acts like ZZ of link k less ZZ of link j: joints next to each other."""
    if not robot.coupling:
        return False
    (a, b), turns = sorted(coupled), [joint.revolute for joint in robot.joints]
    follows = a in first and not any(turns[a + 1 : b])
    alike = follows and bool(axes[a] @ axes[b] > 1.0 - _ZERO)
    if not (turns[a] and turns[b]) or (follows and coupled[1] == a) or (alike and b > a + 1):
        raise InputError(f"robot {robot.name!r} has coupled drives that no rule covers: use base_parameters")
    return alike


def _prismatic(j: int, r1: Array | None, before_r2: bool) -> Iterator[Move]:
    """Apply the rules of a prismatic joint; ``r1``: axis of r1 in frame j, if it is an earlier joint."""
    for kind in INERTIAL[:6]:
        yield Move("prismatic: inertia to link j-1", j, kind, {kind: 1.0}, True)
    if r1 is None:
        for kind in ("MX", "MY", "MZ"):
            yield Move("prismatic before r1: no MX, MY, MZ", j, kind, {kind: 1.0}, False)
    elif before_r2 and np.hypot(*r1[:2]) < _ZERO:
        yield Move("prismatic parallel to r1: no MZ", j, "MZ", {"MZ": 1.0}, False)
        for kind in ("MX", "MY"):
            yield Move("prismatic parallel to r1: MX, MY to link j-1", j, kind, {kind: 1.0}, True)
    elif before_r2:
        components = zip(INERTIAL[6:9], r1.tolist(), strict=True)
        along = {kind: value for kind, value in components if abs(value) > _ZERO}
        last = list(along)[-1]
        yield Move(f"prismatic not parallel to r1: no {last}", j, last, along, False)


def _prismatic_rotor(robot: Robot, j: int, weight: float) -> Iterator[Move]:
    """Group a rotor without its mass, carried by a link that is lighter by as much: only gravity can still tell."""
    if abs(weight) <= _ZERO * math.hypot(*robot.gravity):
        yield Move("prismatic rotor into M", j, "IA", {"IA": 1.0, "M": -1.0}, True)
    elif robot.drives.rotor_inertia:
        # FA is 1 for a joint that moves, as OFF is; a robot has one of them.
        constant = "FA" if f"FA{j + 1}" in robot.drives.names(j + 1) else "OFF"
        yield Move("prismatic offset into M and IA", j, constant, {"M": 1.0, "IA": -1.0, constant: weight}, True)


def _grouping(regroupings: Sequence[Move], joints: Sequence[Joint], columns: Sequence[str]) -> Array:
    """Carry out the moves: row k starts as parameter k and becomes what it stands for, N_s x N_s."""
    index = {name: k for k, name in enumerate(columns)}
    rows = np.eye(len(columns))
    changes = [FrameChange.of(joint, 0.0, np) for joint in joints]
    for move in regroupings:
        amount = rows[index[f"{move.drop}{move.joint + 1}"]] / move.change[move.drop]
        for kind, size in move.change.items():
            rows[index[f"{kind}{move.joint + 1}"]] -= amount * size
        if not move.to_parent or move.joint == 0:
            continue
        body = InertialParameters(np.array([move.change.get(kind, 0.0) for kind in INERTIAL]))
        before = body.moved(changes[move.joint].axes, changes[move.joint].origin)
        for name, size in before.named(str(move.joint)).items():
            rows[index[name]] += amount * size
    return rows


def _second_degree(
    function: Callable[[Mapping[str, float]], Array], names: Sequence[str]
) -> list[tuple[_Monomial, Array]]:
    """Coefficients of a polynomial in some lengths, by its values.

    A grouping is of second degree: Steiner's theorem has squares, and what was moved once has no longer terms.
    """

    def at(**lengths: float) -> Array:
        return function(dict.fromkeys(names, 0.0) | lengths)

    constant = at()
    plus, minus = ({name: at(**{name: size}) for name in names} for size in (1.0, -1.0))
    terms: list[tuple[_Monomial, Array]] = [((), constant)]
    for name in names:
        terms.append(((name,), 0.5 * (plus[name] - minus[name])))
        terms.append(((name, name), 0.5 * (plus[name] + minus[name]) - constant))
    for a, b in combinations(names, 2):
        terms.append(((a, b), at(**{a: 1.0, b: 1.0}) - plus[a] - plus[b] + constant))
    return terms


def _sum_text(terms: Iterable[tuple[_Monomial, float, str]]) -> str:
    """Write a sum of products of lengths, factors and parameters as (12) prints it: "IA1 + D3^2*(M3+M4) + YY2".

    Parameters with the same factor share a bracket; factors are in alphabetical order, and terms in the order
    of their last factors.
    """
    single = sorted(
        (product, float(f"{factor:.9g}"), name) for product, factor, name in terms if abs(factor) > _ROUNDING
    )
    joined = []
    for (product, factor), group in groupby(single, key=lambda term: term[:2]):
        names = [name for _, _, name in group]
        apart = not product and abs(factor) == 1.0
        for some in [[name] for name in names] if apart else [names]:
            powers = sorted({**Counter(product), some[0]: 1}.items())
            joined.append((powers, factor, some))
    text = ""
    for powers, factor, names in sorted(joined, key=lambda term: term[0][::-1]):
        bracket = names[0] if len(names) == 1 else f"({'+'.join(names)})"
        written = [] if abs(factor) == 1.0 else [f"{abs(factor):.6g}"]
        for name, power in powers:
            written.append(bracket if name == names[0] else name if power == 1 else f"{name}^{power}")
        text += f" {'-' if factor < 0 else '+'} {'*'.join(written)}"
    return ("-" if text.startswith(" -") else "") + text[3:]
