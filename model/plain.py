"""Regressor and dynamics in NumPy alone, one state at a time; ``generate_numpy`` writes them into its files."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Joint = tuple[bool, float, float, float, float]
"""Whether it turns; then, by modified DH, alpha [rad], d [m], theta [rad] and r [m]."""


def frame_change(joint: Joint, q: float) -> tuple[Array, Array]:
    """Axes (3 x 3) and origin [m] of frame j in frame j-1."""
    revolute, alpha, d, theta, r = joint
    theta, r = (theta + q, r) if revolute else (theta, r + q)
    (ct, st), (ca, sa) = ((np.cos(angle), np.sin(angle)) for angle in (theta, alpha))
    axes = np.array([[ct, -st, 0.0], [ca * st, ca * ct, -sa], [sa * st, sa * ct, ca]])
    return axes, np.array([d, -sa * r, ca * r])


def skew(v: Array) -> Array:
    """Matrix of the cross product with v, 3 x 3."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def wrench_columns(w: Array, wd: Array, a: Array) -> Array:
    """Force and moment at a link's origin, 6 x 10: XX XY XZ YY YZ ZZ MX MY MZ M (Newton, Euler).

    w, wd: angular velocity and acceleration; a: acceleration of the origin less gravity; in the link's axes.
    """
    columns = np.zeros((6, 10))
    for k, (i, j) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]):
        unit = np.zeros((3, 3))
        unit[i, j] = unit[j, i] = 1.0
        columns[3:, k] = unit @ wd + skew(w) @ unit @ w
    columns[:3, 6:9] = skew(wd) + skew(w) @ skew(w)
    columns[3:, 6:9] = -skew(a)
    columns[:3, 9] = a
    return columns


def link_regressor(joints: list[Joint], gravity: Array, q: Array, qd: Array, qdd: Array) -> Array:
    """Torques by the ten parameters of each link, n x 10 n."""
    n, z = len(joints), np.array([0.0, 0.0, 1.0])
    phi, w, wd, a = np.zeros((n, 10 * n)), np.zeros(3), np.zeros(3), -gravity
    turn, slide = np.zeros((3, n)), np.zeros((3, n))  # by unit speed of each joint, in frame j
    for j, joint in enumerate(joints):
        axes, p = frame_change(joint, q[j])
        a = axes.T @ (a + (skew(wd) + skew(w) @ skew(w)) @ p)
        slide = axes.T @ (slide - skew(p) @ turn)
        w, wd, turn = axes.T @ w, axes.T @ wd, axes.T @ turn
        if joint[0]:
            wd = wd + skew(w) @ z * qd[j] + z * qdd[j]
            w = w + z * qd[j]
            turn[2, j] = 1.0
        else:
            a = a + 2.0 * skew(w) @ z * qd[j] + z * qdd[j]
            slide[2, j] = 1.0
        columns = wrench_columns(w, wd, a)
        phi[:, 10 * j : 10 * j + 10] = slide.T @ columns[:3] + turn.T @ columns[3:]
    return phi


class Arm(NamedTuple):
    """A robot. States q, qd, qdd and torques are arrays of n numbers; SI units.

    ``gravity``: acceleration in frame 0; ``standard``: names of the N_s standard parameters; ``chi``: their values;
    ``base``: which of them stand for a base parameter; ``grouping``: base parameters are grouping @ chi;
    ``drives``: gives the entries of the drives' parameters by joint, from 0; ``spring``: gives the joints' known
    torques by a spring.
    """

    joints: list[Joint]
    gravity: Array
    standard: list[str]
    chi: Array
    base: list[int]
    grouping: Array
    drives: Callable[[Array, Array, Array, Array], dict[str, dict[int, float]]]
    spring: Callable[[Array], Array]

    def regressor(self, q: Array, qd: Array, qdd: Array, load: Array | None = None) -> Array:
        """Columns of all standard parameters, n x N_s; ``load``: torques that the gears carry."""
        n = len(self.joints)
        links, phi = link_regressor(self.joints, self.gravity, q, qd, qdd), np.zeros((n, len(self.standard)))
        phi[:, self.links] = links
        for name, entries in self.drives(q, qd, qdd, np.zeros(n) if load is None else load).items():
            for row, value in entries.items():
                phi[row, self.standard.index(name)] = value
        return phi

    def base_regressor(self, q: Array, qd: Array, qdd: Array, load: Array | None = None) -> Array:
        """Columns of the base parameters, n x N_b."""
        return self.regressor(q, qd, qdd, load)[:, self.base]

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array, chi: Array | None = None) -> Array:
        """Torques that a motion needs; ``chi``: other standard parameters than the arm's own."""
        chi, spring = self.chi if chi is None else chi, self.spring(q)
        load = link_regressor(self.joints, self.gravity, q, qd, qdd) @ chi[self.links] - spring
        return np.asarray(self.regressor(q, qd, qdd, load) @ chi - spring)

    def mass_matrix(self, q: Array, chi: Array | None = None) -> Array:
        """Inertia matrix, n x n, rotors included."""
        n = len(self.joints)
        still = self.inverse_dynamics(q, np.zeros(n), np.zeros(n), chi)
        return np.column_stack([self.inverse_dynamics(q, np.zeros(n), unit, chi) - still for unit in np.eye(n)])

    def forward_dynamics(self, q: Array, qd: Array, torque: Array, chi: Array | None = None) -> Array:
        """Accelerations by torques; friction that grows with load takes several steps."""
        A, qdd = self.mass_matrix(q, chi), np.zeros(len(self.joints))
        for _ in range(6):
            qdd = qdd + np.linalg.solve(A, torque - self.inverse_dynamics(q, qd, qdd, chi))
        return qdd

    @property
    def links(self) -> list[int]:
        """Indices of the links' ten parameters, link by link, among the standard ones."""
        ten = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
        return [self.standard.index(f"{kind}{j + 1}") for j in range(len(self.joints)) for kind in ten]
