"""The regressor Phi_s of (4): torque is linear in the standard parameters."""

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from ..common import Array
from .drives import SPRING, DriveState, Sign, drive_terms, joint_of, parameter_kind
from .frames import ZERO, FrameChange, Vector, add, cross, dot
from .inertia import INERTIAL
from .robot import Robot, check_robot


def standard_columns(robot: Robot) -> tuple[str, ...]:
    """Names of the standard parameters, link by link in the order of (6), coupled friction last."""
    check_robot(robot)
    return robot.standard


def payload_columns(robot: Robot) -> tuple[str, ...]:
    """Names of the last link's ten inertial parameters: a payload fixed to it has the same columns."""
    return tuple(f"{kind}{robot.n}" for kind in INERTIAL)


def own_columns(robot: Robot) -> tuple[str, ...]:
    """Standard parameters whose columns span what all of them do.

    Three of the ten of each link that turns, the inertia of each that slides, are regrouped to the link before.
    """
    passed = [("YY", "MZ", "M") if joint.revolute else INERTIAL[:6] for joint in robot.joints]
    names = [x for x in robot.standard if parameter_kind(x) not in (*passed[joint_of(x)], SPRING)]
    return tuple(sorted(names, key=lambda name: parameter_kind(name) not in INERTIAL))


def standard_regressor(robot: Robot) -> ca.Function:
    """``standard_regressor(q, qd, qdd) -> Phi_s``, n x N_s, columns as ``standard_columns`` (4)."""
    return regressor(robot, standard_columns(robot), "standard_regressor")


def payload_regressor(robot: Robot) -> ca.Function:
    """``payload_regressor(q, qd, qdd) -> Phi_L``, n x 10, payload in the frame of the last link (22)."""
    return regressor(robot, payload_columns(robot), "payload_regressor")


def regressor(robot: Robot, columns: Sequence[str], name: str = "regressor") -> ca.Function:
    """Regressor of chosen columns.

    Args:
        columns: standard parameters, as in ``standard_columns``; the order is kept.

    Returns:
        Function of q, qd, qdd (each n x 1; rad or m, per second, per second squared) to an n x
        ``len(columns)`` sparse matrix, with common subexpressions eliminated. Where friction among the columns
        depends on load, the torques of links, payload and spring are a fourth input, ``load`` [N·m or N].

    Raises:
        KeyError: for a name that is not a standard parameter of the robot.
    """
    state, phi = regressor_expression(robot, columns)
    inputs = dict(list(state._asdict().items())[: 4 if ca.depends_on(phi, state.load) else 3])
    return ca.Function(name, [*inputs.values()], [ca.cse(phi)], [*inputs], ["Phi"])


def regressor_expression(robot: Robot, columns: Sequence[str], sign: Sign = ca.sign) -> tuple[DriveState, ca.SX]:
    """Symbols q, qd, qdd, load and the regressor's matrix, to build on; arguments, errors as ``regressor``.

    ``sign``: what stands for the sign in dry friction; by ``smooth_sign`` the matrix has a slope everywhere.
    """
    state, terms = _expressions(robot)
    terms = terms | drive_terms(robot.drives, state, sign)
    return state, term_matrix([terms[column] for column in columns], robot.n)


def term_matrix(columns: Sequence[Mapping[int, Any]], n: int) -> ca.SX:
    """Sparse matrix of n rows, of the factors of each column by row."""
    phi = ca.SX(n, len(columns))
    for k, column in enumerate(columns):
        for row, entry in column.items():
            if not (value := ca.SX(entry)).is_zero():
                phi[row, k] = value
    return phi


def load_expression(robot: Robot, state: DriveState, columns: Sequence[str], chi: ca.SX) -> ca.SX:
    """Torques of links, payload and spring, which the gears carry, n x 1, by values ``chi`` of some columns.

    Columns of drives do not count, and none may stand twice; values may be of base parameters, the others zero.
    """
    torque: ca.SX = ca.vertcat(*body_torques(robot, state, dict(zip(columns, chi.elements(), strict=True))))
    if robot.spring is not None:
        row = robot.spring.joint - 1
        torque[row] -= robot.spring.law(state.q[row])
    return torque


def body_torques(robot: Robot, state: DriveState, values: Mapping[str, Any], lib: Any = ca) -> list[Any]:
    """Torques of links and payload, joint by joint, by values of some inertial parameters.

    Wrenches are summed from tip to base. ``lib``: CasADi or, of arrays, NumPy.
    """
    changes = [FrameChange.of(joint, state.q[j], lib) for j, joint in enumerate(robot.joints)]
    wrenches, torques, none = list(link_wrenches(robot, changes, state)), list[Any](), 0.0 * state.q[0]
    force: Vector = (none, none, none)
    moment = force
    for j in reversed(range(robot.n)):
        for kind, unit in zip(INERTIAL, wrenches[j], strict=True):
            if (amount := values.get(f"{kind}{j + 1}")) is not None:
                force, moment = (
                    total if own is ZERO else add(total, (own[0] * amount, own[1] * amount, own[2] * amount))
                    for total, own in zip((force, moment), unit, strict=True)
                )
        torques.insert(0, moment[2] if robot.joints[j].revolute else force[2])
        force = changes[j].out_of(force)
        moment = add(changes[j].out_of(moment), cross(changes[j].origin, force))
    return torques


def own_regressor(robot: Robot, columns: Sequence[str], sign: Sign = ca.sign) -> tuple[DriveState, ca.SX]:
    """``regressor_expression`` under the load of the robot's own parameters."""
    state, phi = regressor_expression(robot, columns, sign)
    load = load_expression(robot, state, [*robot.parameters], ca.SX([*robot.parameters.values()]))
    return state, ca.substitute(phi, state.load, load)


def regressor_at(
    robot: Robot, columns: Sequence[str], q: Array, qd: Array, qdd: Array, load: Array | None = None
) -> Array:
    """Columns of the standard regressor at N states, each N x n; n x ``len(columns)`` x N.

    ``columns``: standard parameters; offsets whether the robot has them or not; ``load``: torques that the gears
    carry [N·m or N], for friction that depends on them; zero by default.
    """
    W, carried = np.zeros((robot.n, len(columns), len(q))), np.zeros(q.shape) if load is None else load
    state = DriveState(q.T, qd.T, qdd.T, carried.T)
    terms = _rigid_terms(robot, state, np) | drive_terms(replace(robot.drives, offsets=True), state, np.sign)
    for k, name in enumerate(columns):
        for row, values in terms[name].items():
            W[row, k] = values
    return W


@functools.lru_cache(maxsize=16)
def _expressions(robot: Robot) -> tuple[DriveState, dict[str, dict[int, Any]]]:
    state = DriveState(*(ca.SX.sym(symbol, robot.n) for symbol in DriveState._fields))
    return state, _rigid_terms(robot, state, ca)


def _rigid_terms(robot: Robot, state: DriveState, lib: Any) -> dict[str, dict[int, Any]]:
    """Factors of all but the drives' own parameters: links, payload, and a spring whose torque is a column."""
    terms, spring = inertial_terms(robot, state, lib), robot.spring
    if spring is not None and spring.column:
        terms[f"{SPRING}{spring.joint}"] = {spring.joint - 1: -spring.law(state.q[spring.joint - 1], lib)}
    return terms


def inertial_terms(robot: Robot, state: DriveState, lib: Any = ca) -> dict[str, dict[int, Any]]:
    """Factors of each inertial parameter in the joints' torques, row by row; by CasADi or, of arrays, by NumPy.

    The wrench of link j is projected on the axis of joint i seen from frame j (virtual power), which needs
    fewer operations than carrying ten wrenches back to the base.
    """
    terms: dict[str, dict[int, Any]] = {}
    changes = [FrameChange.of(joint, state.q[j], lib) for j, joint in enumerate(robot.joints)]
    # What the link turns and its origin moves by where each joint has unit speed, all joints at once.
    turn = slide = (0.0 * state.q,) * 3
    for j, (change, wrenches) in enumerate(zip(changes, link_wrenches(robot, changes, state), strict=True)):
        slide = change.into(add(slide, cross(turn, change.origin)))
        turn = change.into(turn)
        (turn if robot.joints[j].revolute else slide)[2][j] = 1.0
        if lib is np:  # all ten at once; the inertia's six have no force
            forces, moments = np.zeros((2, 3, len(INERTIAL), *state.q.shape[1:]))
            for k, (force, moment) in enumerate(wrenches):
                for axis in range(3):
                    forces[axis, k], moments[axis, k] = force[axis], moment[axis]
            torques: Any = np.einsum("ai...,ak...->ki...", np.array(turn)[:, : j + 1], moments)
            torques[6:] += np.einsum("ai...,ak...->ki...", np.array(slide)[:, : j + 1], forces[:, 6:])
        else:
            torques = [(dot(turn, moment) + dot(slide, force)).elements() for force, moment in wrenches]
        for kind, torque in zip(INERTIAL, torques, strict=True):
            terms[f"{kind}{j + 1}"] = {i: torque[i] for i in range(j + 1)}
    return terms


def link_wrenches(
    robot: Robot, changes: Sequence[FrameChange], state: DriveState
) -> Iterator[list[tuple[Vector, Vector]]]:
    """Force and moment of each link at its origin, for each of its ten parameters (Newton, Euler).

    Accelerations are less gravity, so that a robot at rest accelerates upwards. Source of the recursion: Khalil and
    Dombre 2002.
    """
    w = angular = ZERO
    a: Vector = (-robot.gravity[0], -robot.gravity[1], -robot.gravity[2])
    spin = (ZERO, ZERO, ZERO)
    for j, (joint, change) in enumerate(zip(robot.joints, changes, strict=True)):
        speed, pace = state.qd[j], state.qdd[j]
        further = dot(spin[0], change.origin), dot(spin[1], change.origin), dot(spin[2], change.origin)
        a = change.into(add(a, further))
        w, angular = change.into(w), change.into(angular)
        aside = w[1] * speed, -w[0] * speed  # w x speed along the axis
        if joint.revolute:
            angular = add(angular, (*aside, pace))
            w = (w[0], w[1], w[2] + speed)
        else:
            a = add(a, (2.0 * aside[0], 2.0 * aside[1], pace))
        (x, y, z), (p, q, r) = w, angular
        xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
        # A point at p of the link accelerates by spin p more than its origin: angular^ + w^ w^.
        spin = (-(yy + zz), xy - r, xz + q), (xy + r, -(xx + zz), yz - p), (xz - q, yz + p, -(xx + yy))
        by_x, by_y, by_z = zip(*spin, strict=True)
        yield [
            (ZERO, (p, xz, -xy)),
            (ZERO, (q - xz, p + yz, xx - yy)),
            (ZERO, (r + xy, zz - xx, p - yz)),
            (ZERO, (-yz, q, xy)),
            (ZERO, (yy - zz, r - xy, q + xz)),
            (ZERO, (yz, -xz, r)),
            (by_x, (0.0, -a[2], a[1])),
            (by_y, (a[2], 0.0, -a[0])),
            (by_z, (-a[1], a[0], 0.0)),
            (a, ZERO),
        ]
