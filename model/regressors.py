"""The regressor Phi_s of (4): torque is linear in the standard parameters."""

import functools
from collections.abc import Sequence

import casadi as ca

from .drives import DriveState, Sign, drive_terms, parameter_kind
from .kinematics import LinkMotion, base_motion, joint_axis, joint_transform, next_motion, spin_matrix
from .robot import INERTIAL, Robot


def standard_columns(robot: Robot) -> tuple[str, ...]:
    """Names of the standard parameters, link by link in the order of (6), coupled friction last."""
    names: list[str] = []
    for joint in range(1, robot.n + 1):
        names += [f"{kind}{joint}" for kind in INERTIAL]
        names += [*robot.drives.names(joint), *robot.drives.spring_names(joint)]
    return (*names, *robot.drives.coupling_names())


def payload_columns(robot: Robot) -> tuple[str, ...]:
    """Names of the last link's ten inertial parameters: a payload fixed to it has the same columns."""
    return tuple(f"{kind}{robot.n}" for kind in INERTIAL)


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


def regressor_expression(robot: Robot, columns: Sequence[str]) -> tuple[DriveState, ca.SX]:
    """Symbols q, qd, qdd, load and the regressor's matrix, to build on; arguments, errors as ``regressor``."""
    state, terms = _terms(robot)
    return state, _matrix(robot, columns, terms)


def load_expression(robot: Robot, state: DriveState, columns: Sequence[str], chi: ca.SX) -> ca.SX:
    """Torques of links, payload and spring, which the gears carry, by values of some columns; n x 1.

    Args:
        columns: standard parameters; those of drives do not count.
        chi: their values, as base parameters where the others are zero.
    """
    _, terms = _terms(robot)
    load = ca.SX.zeros(robot.n)
    for value, name in zip(ca.vertsplit(chi), columns, strict=True):
        for row, factor in terms[name].items() if parameter_kind(name) in INERTIAL else ():
            load[row] += factor * value
    if robot.spring is not None:
        row = robot.spring.joint - 1
        load[row] -= robot.spring.torque_symbol(state.q[row])
    return load


def own_regressor(robot: Robot, columns: Sequence[str], sign: Sign = ca.sign) -> tuple[DriveState, ca.SX]:
    """Symbols and the regressor's matrix under the load of the robot's own parameters; as ``regressor_expression``.

    Args:
        sign: what stands for the sign in dry friction; by ``smooth_sign`` the matrix has a slope everywhere.
    """
    state, terms = _terms(robot)
    phi = _matrix(robot, columns, terms | drive_terms(robot.drives, state, sign))
    known = {name: value for name, value in robot.parameters.items() if parameter_kind(name) in INERTIAL}
    load = load_expression(robot, state, list(known), ca.SX(list(known.values())))
    return state, ca.substitute(phi, state.load, load)


def _matrix(robot: Robot, columns: Sequence[str], terms: dict[str, dict[int, ca.SX]]) -> ca.SX:
    phi = ca.SX(robot.n, len(columns))
    for k, column in enumerate(columns):
        for row, entry in terms[column].items():
            if not (value := ca.SX(entry)).is_zero():
                phi[row, k] = value
    return phi


@functools.lru_cache(maxsize=16)
def _terms(robot: Robot) -> tuple[DriveState, dict[str, dict[int, ca.SX]]]:
    """Symbols q, qd, qdd, load, and the factors of each standard parameter; built once for a robot."""
    state = DriveState(*(ca.SX.sym(symbol, robot.n) for symbol in DriveState._fields))
    q, qd, qdd, _ = state
    terms = _rigid_body_terms(robot, q, qd, qdd) | drive_terms(robot.drives, state)
    if robot.spring is not None:
        row = robot.spring.joint - 1
        terms |= {name: {row: -robot.spring.torque_symbol(q[row])} for name in robot.drives.spring_names(row + 1)}
    return state, terms


def _rigid_body_terms(robot: Robot, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> dict[str, dict[int, ca.SX]]:
    """Factors of each inertial parameter in each joint's torque.

    The wrench of link j is projected on the axis of joint i seen from frame j (virtual power), which needs
    fewer operations than carrying ten wrenches back to the base.
    """
    terms: dict[str, dict[int, ca.SX]] = {}
    motion = base_motion(robot)
    axes: list[tuple[ca.SX, ca.SX]] = []
    for j, joint in enumerate(robot.joints):
        rotation, origin = joint_transform(joint, q[j])
        axes = [(rotation.T @ a, rotation.T @ (b + ca.cross(a, origin))) for a, b in axes]
        axes.append(joint_axis(joint))
        motion = next_motion(motion, rotation, origin, axes[-1], qd[j], qdd[j])
        force, moment = link_wrench(motion)
        for k, kind in enumerate(INERTIAL):
            terms[f"{kind}{j + 1}"] = {
                i: ca.dot(turn, moment[:, k]) + ca.dot(slide, force[:, k]) for i, (turn, slide) in enumerate(axes)
            }
    return terms


def link_wrench(motion: LinkMotion) -> tuple[ca.SX, ca.SX]:
    """Force and moment at the link's origin per unit inertial parameter, each 3 x 10 (Newton, Euler)."""
    w, alpha, a = motion
    spin = spin_matrix(motion)
    inertia = _inertia_times(alpha) + ca.skew(w) @ _inertia_times(w)
    force = ca.horzcat(ca.SX(3, 6), spin, a)
    moment = ca.horzcat(inertia, -ca.skew(a), ca.SX(3, 1))
    return force, moment


def _inertia_times(v: ca.SX) -> ca.SX:
    """Matrix K, 3 x 6, with J v = K [XX XY XZ YY YZ ZZ]'."""
    x, y, z = v[0], v[1], v[2]
    zero = ca.SX(0)
    rows = [[x, y, z, zero, zero, zero], [zero, x, zero, y, z, zero], [zero, zero, x, zero, y, z]]
    return ca.vertcat(*(ca.horzcat(*row) for row in rows))
