"""Base parameters of a serial robot by closed-form rules, as (12) for the RX90 (Gautier and Khalil 1990).

Joints from the tip to the base. r1 is the first revolute joint, r2 the next revolute one whose axis is not
parallel to that of r1 (0 and 180 degrees are parallel). To move a parameter to link j-1 is to add the same body,
seen from frame j-1 at q = 0.

- Revolute j: YYj (with XXj - YYj left behind), MZj and Mj go to link j-1. For r1 <= j < r2: XXj, XYj, XZj and YZj
  have no effect; nor MXj and MYj where axis j coincides with that of r1, lies along gravity, and all earlier axes
  are parallel to it.
- Prismatic j: the inertia matrix goes to link j-1. j < r1: MXj, MYj and MZj have no effect. r1 < j < r2: parallel
  to r1, MZj has none, MXj and MYj go to link j-1; else the first moment along the axis of r1 has none.
- Rotors: IA of r1 goes into ZZ of r1, IA of r2 into ZZ of r2 if and only if the two axes are orthogonal. For a
  prismatic j before r2 whose axis is parallel to every earlier revolute axis and orthogonal to every earlier
  prismatic one: if orthogonal to gravity, IAj goes into Mj while link j-1 loses a mass IAj; else that combination
  feels gravity alone, as a constant force, and a drive offset OFFj is grouped into it.

The rotor rule for prismatic joints is often stated for j = 1 only. That leaves a valid set that is not minimal; the
smallest case is two orthogonal prismatic joints, the second horizontal. With joint 1 vertical,

    Gamma1 = (M1 + M2) (q1'' + g) + IA1 q1'',    Gamma2 = (M2 + IA2) q2'',

M1, IA1, M2 and IA2 have three combinations only: M1R = M1 - IA2, IA1 and M2R = M2 + IA2.

The rules hold for any non-zero gravity and for drives that are not coupled; rank.py covers the rest.
The geometry is taken as exact: from the angles that are snapped to a multiple of 90 degrees (1e-4 rad) up to
about 3e-3 rad from one, effects of the angle squared can be too small for QR to see.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ..drives import parameter_kind
from ..regressors import standard_columns
from ..robot import INERTIAL, Robot
from .geometry import ZERO, Chain, chain_at_zero, transfer_matrix
from .parameters import BaseParameters
from .polynomial import Polynomial, linear_text
from .rank import base_parameters

_SAME = 1e-6
"""Relative and absolute difference of two groupings that are the same."""


class Move(NamedTuple):
    """Application of one rule: parameter ``drop`` of a joint is grouped away.

    Attributes:
        rule: the rule's name.
        joint: index from 0.
        drop: kind of the parameter that goes ("YY").
        change: what has no effect on the torques when added to the joint's parameters, by kind.
        to_parent: whether link j-1 has to lose the same body.
    """

    rule: str
    joint: int
    drop: str
    change: dict[str, float]
    to_parent: bool


def closed_form_base_parameters(robot: Robot) -> BaseParameters:
    """Base parameters of a serial robot by the rules above, with symbolic expressions.

    Coupled drives are decided by QR; rows that are the same without the coupling keep their expression.

    Raises:
        InputError: without gravity, or if one name stands for two lengths.
    """
    if robot.coupling:
        return _decided_by_rank(robot)
    lengths = _named_lengths(robot)
    regroupings = moves(robot)
    columns = standard_columns(robot)
    grouping = _apply(regroupings, robot, columns, np.eye(len(columns)), {})
    symbols = {name: Polynomial.symbol(name) for name in lengths}
    start = np.eye(len(columns)).astype(object)
    symbolic = _apply(regroupings, robot, columns, start, symbols) if symbols else grouping
    dropped = {f"{move.drop}{move.joint + 1}" for move in regroupings}
    chosen = tuple(k for k, name in enumerate(columns) if name not in dropped)
    expressions = tuple(linear_text(dict(zip(columns, symbolic[k], strict=True))) for k in chosen)
    return BaseParameters(columns, chosen, grouping[list(chosen)], "closed form", expressions)


def moves(robot: Robot) -> list[Move]:
    """List all applications of the rules to a robot without coupled drives, tip to base.

    Raises:
        InputError: without gravity.
    """
    if not any(robot.gravity):
        raise InputError(
            f"robot {robot.name!r} has no gravity, which the closed-form rules need: use base_parameters"
        )
    chain = chain_at_zero(robot)
    regroupings: list[Move] = []
    for j in reversed(range(robot.n)):
        rules = _revolute if robot.joints[j].revolute else _prismatic
        known = (*INERTIAL, *(parameter_kind(name) for name in robot.drives.names(j + 1)))
        regroupings += [move for move in rules(chain, j, robot) if move.drop in known]
    return regroupings


def _revolute(chain: Chain, j: int, robot: Robot) -> Iterator[Move]:
    yield Move("revolute: YY to link j-1", j, "YY", {"XX": 1.0, "YY": 1.0}, True)
    yield Move("revolute: MZ to link j-1", j, "MZ", {"MZ": 1.0}, True)
    yield Move("revolute: M to link j-1", j, "M", {"M": 1.0}, True)
    if j < chain.r2:
        for kind in ("XX", "XY", "XZ", "YZ"):
            yield Move("revolute before r2: no XX, XY, XZ, YZ", j, kind, {kind: 1.0}, False)
        if chain.turns_about_gravity(j):
            for kind in ("MX", "MY"):
                yield Move("revolute about gravity: no MX, MY", j, kind, {kind: 1.0}, False)
    if j == chain.r1:
        yield Move("rotor of r1 into ZZ", j, "IA", {"IA": 1.0, "ZZ": -1.0}, False)
    if j == chain.r2 and chain.orthogonal(j, chain.r1):
        yield Move("rotor of r2 into ZZ", j, "IA", {"IA": 1.0, "ZZ": -1.0}, False)


def _prismatic(chain: Chain, j: int, robot: Robot) -> Iterator[Move]:
    for kind in INERTIAL[:6]:
        yield Move("prismatic: inertia to link j-1", j, kind, {kind: 1.0}, True)
    if j < chain.r1:
        for kind in ("MX", "MY", "MZ"):
            yield Move("prismatic before r1: no MX, MY, MZ", j, kind, {kind: 1.0}, False)
    elif j < chain.r2 and chain.parallel(j, chain.r1):
        yield Move("prismatic parallel to r1: no MZ", j, "MZ", {"MZ": 1.0}, False)
        for kind in ("MX", "MY"):
            yield Move("prismatic parallel to r1: MX, MY to link j-1", j, kind, {kind: 1.0}, True)
    elif j < chain.r2:
        components = (chain.rotation[j].T @ chain.axis(chain.r1)).tolist()
        along = {kind: value for kind, value in zip(INERTIAL[6:9], components, strict=True) if abs(value) > ZERO}
        last = list(along)[-1]
        yield Move(f"prismatic not parallel to r1: no {last}", j, last, along, False)
    apart = all(chain.parallel(i, j) if chain.revolute[i] else chain.orthogonal(i, j) for i in range(j))
    if j < chain.r2 and apart:
        # A rotor without its mass, carried by a link that is lighter by as much: only gravity can still tell.
        weight = float(chain.axis(j) @ chain.gravity)
        if abs(weight) <= ZERO * float(np.linalg.norm(chain.gravity)):
            yield Move("prismatic rotor into M", j, "IA", {"IA": 1.0, "M": -1.0}, True)
        elif robot.drives.rotor_inertia:
            # FA is 1 for a joint that moves, as OFF is; a robot has one of them.
            constant = "FA" if f"FA{j + 1}" in robot.drives.names(j + 1) else "OFF"
            yield Move(
                "prismatic offset into M and IA", j, constant, {"M": 1.0, "IA": -1.0, constant: weight}, True
            )


def _apply(
    regroupings: list[Move],
    robot: Robot,
    columns: tuple[str, ...],
    rows: NDArray[Any],
    symbols: dict[str, Polynomial],
) -> NDArray[Any]:
    """Carry out the moves on ``rows``: row k starts as parameter k and becomes what it stands for."""
    index = {name: k for k, name in enumerate(columns)}
    transfers = [transfer_matrix(joint, symbols) for joint in robot.joints]
    for move in regroupings:
        number = move.joint + 1
        amount = rows[index[f"{move.drop}{number}"]] * (1.0 / move.change[move.drop])
        for kind, size in move.change.items():
            rows[index[f"{kind}{number}"]] = rows[index[f"{kind}{number}"]] - amount * size
        if not move.to_parent or move.joint == 0:
            continue
        body = np.array([move.change.get(kind, 0.0) for kind in INERTIAL])
        for kind, size in zip(INERTIAL, transfers[move.joint] @ body, strict=True):
            rows[index[f"{kind}{number - 1}"]] = rows[index[f"{kind}{number - 1}"]] + amount * size
    return rows


def _named_lengths(robot: Robot) -> dict[str, float]:
    lengths: dict[str, float] = {}
    for number, joint in enumerate(robot.joints, 1):
        for name, value in zip(joint.names, (joint.d, joint.r), strict=True):
            if name and not math.isclose(lengths.setdefault(name, value), value):
                raise InputError(
                    f"robot {robot.name!r}: joint {number} has length {name!r} = {value:g}, an earlier one "
                    f"{lengths[name]:g}: give them different names"
                )
    return lengths


def _decided_by_rank(robot: Robot) -> BaseParameters:
    decided = base_parameters(robot)
    rules = closed_form_base_parameters(replace(robot, drives=replace(robot.drives, coupling=None)))
    here = [decided.standard.index(name) for name in rules.standard]
    written = dict(zip(rules.columns, zip(rules.grouping, rules.expressions, strict=True), strict=True))
    texts = []
    for name, row in zip(decided.columns, decided.grouping, strict=True):
        row_by_rules, text = written.get(name, (None, ""))
        coupled = np.delete(row, here)
        same = row_by_rules is not None and _equal(row[here], row_by_rules) and _equal(coupled, 0.0 * coupled)
        texts.append(text if same else linear_text(dict(zip(decided.standard, row.tolist(), strict=True))))
    return replace(decided, expressions=tuple(texts))


def _equal(left: Array, right: Array) -> bool:
    return bool(np.allclose(left, right, rtol=_SAME, atol=_SAME))
