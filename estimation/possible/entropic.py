"""Least squares plus a weight times the entropic distance from prior bodies, by an interior-point method.

Minimises ||F z - d||^2 + w sum D(P_j || P0_j) under A z + b >= 0. D = -log det(P P0^-1) + tr(P0^-1 P) - 4 is the
log-det divergence of pseudo-inertias (Lee, Wensing and Park, 2020); it keeps every P_j positive definite and does
not change with frames or units.

At the minimum P S = w 1 with duals S_j: it is the point of the central path of the semidefinite program
||F z - d||^2 + w tr(P0^-1 P) at which the barrier's parameter has fallen to w. So the path is followed from a large
parameter down to w, with steps in the scaling of Nesterov and Todd: with G' S G = G^-1 P G'^-1 diagonal and
M dz = G^-1 dP G'^-1 a step minimises ||M dz + G' (w P0^-1 - mu P^-1) G||^2 / 2 beside the other terms, and so do
the rows with their multipliers. Each step is a linear least-squares problem, solved by QR of the stacked rows,
which keeps the condition number of F instead of F'F.

This is the most specialised code of the house, used for ``solve_constrained_prior`` alone. Whoever mends it
compares with ``tests/estimation/test_constrained_prior.py``, which solves the same problem by CVXPY.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ...common.arrays import Array
from .cone import ConeProgram, SolverError
from .constraints import PSEUDO_INERTIA

_STEPS = 150
_INSIDE = 0.9
"""Of the way to the boundary: longest step."""
_CENTRING = 0.15
"""By which complementarity is to fall in a step."""
_CORNER = 1e-7
"""Of the weight: complementarity of each row at the end."""
_PRECISE = 1e-12
"""Of the weight: half the squared length of the last step, in its own metric."""


class EntropicPoint(NamedTuple):
    """``z`` (n,), ``multipliers`` (r,) of the rows, ``duals`` p x 4 x 4 of the bodies."""

    z: Array
    multipliers: Array
    duals: Array


class _Step(NamedTuple):
    """Triangle and right-hand side of a step's least-squares problem, in the scaling that it was made with.

    ``G`` p x 4 x 4: P and S of each body are both the diagonal ``root`` (p x 4) there; ``M`` p x 4 x 4 x n.
    """

    triangle: Array
    right: Array
    G: Array
    root: Array
    M: Array


class EntropicProgram(NamedTuple):
    """``program``: F, d, rows and bodies; ``prior`` p x 4 x 4: pseudo-inertias P0 in its scaled units."""

    program: ConeProgram
    prior: Array

    def chi2(self, z: Array) -> float:
        """||F z - d||^2."""
        return float(np.sum((self.program.R @ z - self.program.d) ** 2))

    def distances(self, z: Array) -> Array:
        """D of each body, shape (p,)."""
        ratio = np.linalg.solve(self.prior, pseudo_inertias(self.program, z))
        return np.asarray(np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0)

    def start(self, z: Array) -> EntropicPoint:
        """A point on no path, but well inside; z strictly inside, shape (n,)."""
        F, d, A, _ = self.program[:4]
        slack, P = self._slack(z), pseudo_inertias(self.program, z)
        # Duals that outweigh the gradient of chi2 in the barrier's own metric.
        rows = [
            whitened_bodies(self.program, np.asarray(np.linalg.cholesky(P))).reshape(-1, len(z)),
            A / slack[:, None],
        ]
        barrier = np.vstack([*rows, 1e-3 * np.eye(len(z))])
        gradient = 2.0 * F.T @ (F @ z - d)
        triangle = np.linalg.qr(barrier, mode="r")
        level = float(np.linalg.norm(solve_triangular(triangle, gradient, trans="T"))) + 1e-3
        return EntropicPoint(z, level / slack, np.asarray(level * np.linalg.inv(P)))

    def minimum(self, weight: float, point: EntropicPoint) -> EntropicPoint:
        """Solve for one weight.

        Args:
            weight: w.
            point: ``start``, or the solution for a weight not much different.

        Raises:
            SolverError: if it does not converge.
        """
        fall = _CENTRING
        for _ in range(_STEPS):
            # Complementarity of bodies and rows that the step aims at.
            P = pseudo_inertias(self.program, point.z)
            mu = max(fall * float(np.einsum("pij,pji->", P, point.duals)) / (4 * len(P)), weight)
            rows = float(point.multipliers @ self._slack(point.z)) / max(len(point.multipliers), 1)
            nu = max(fall * rows, _CORNER * weight)
            step = self._step(weight, mu, nu, point)
            point, reached = self._moved(mu, nu, point, step)
            fall = max(_CENTRING, (1.0 - reached) ** 0.5)  # after a short step, centre before going on
            length = float(step.right @ step.right)
            if mu <= weight and nu <= _CORNER * weight and length < _PRECISE * weight:
                return point
        raise SolverError("interior-point steps did not converge", self.program)

    def slope(self, weight: float, point: EntropicPoint) -> float:
        """d chi2 / d log w at a minimum: dz/dw = -K^-1 grad D, K the Hessian of all."""
        F, d = self.program[:2]
        step = self._step(weight, weight, _CORNER * weight, point)
        gradient = np.tensordot(self._pull(weight, weight, step.G, step.root), step.M, 3)
        dz = solve_triangular(step.triangle, solve_triangular(step.triangle, gradient, trans="T"))
        return -float((F @ point.z - d) @ (F @ dz))

    def _slack(self, z: Array) -> Array:
        return np.asarray(self.program.A @ z + self.program.b)

    def _step(self, weight: float, mu: float, nu: float, point: EntropicPoint) -> _Step:
        F, d, A, _ = self.program[:4]
        n, slack = F.shape[1], self._slack(point.z)
        C = np.linalg.cholesky(pseudo_inertias(self.program, point.z))
        squares, Q = np.linalg.eigh(np.swapaxes(C, 1, 2) @ point.duals @ C)
        root = np.sqrt(np.maximum(squares, 1e-300))
        G = C @ Q / np.sqrt(root)[:, None, :]
        M = whitened_bodies(self.program, G)
        stiff = np.sqrt(point.multipliers / (2.0 * slack))
        left = [F, np.sqrt(0.5) * M.reshape(-1, n), stiff[:, None] * A]
        right = [
            d - F @ point.z,
            -np.sqrt(0.5) * self._pull(weight, mu, G, root).ravel(),
            nu / np.sqrt(2.0 * slack * point.multipliers),
        ]
        stacked = np.column_stack([np.vstack(left), np.concatenate(right)])
        R = np.asarray(lapack.dgeqrf(stacked, overwrite_a=1)[0])
        return _Step(np.triu(R[:n, :n]), R[:n, n], G, root, M)

    def _pull(self, weight: float, mu: float, G: Array, root: Array) -> Array:
        """G' (w P0^-1 - mu P^-1) G, p x 4 x 4."""
        attraction = weight * np.swapaxes(G, 1, 2) @ np.linalg.solve(self.prior, G)
        return np.asarray(attraction - mu * _diagonal(1.0 / root))

    def _moved(self, mu: float, nu: float, point: EntropicPoint, step: _Step) -> tuple[EntropicPoint, float]:
        """The point after a step as long as everything stays inside, and the part of it that was made."""
        dz = solve_triangular(step.triangle, step.right)
        root = step.root
        dP = step.M @ dz
        dS = mu * _diagonal(1.0 / root) - _diagonal(root) - dP
        slack, change = self._slack(point.z), self.program.A @ dz
        dm = (nu - point.multipliers * change) / slack - point.multipliers
        reach = min(_to_boundary(root, dP), _to_boundary(root, dS), _reach(slack, change))
        length = min(1.0, _INSIDE * min(reach, _reach(point.multipliers, dm)))
        inverse = np.linalg.inv(step.G)
        duals = np.swapaxes(inverse, 1, 2) @ (_diagonal(root) + length * dS) @ inverse
        duals = 0.5 * (duals + np.swapaxes(duals, 1, 2))
        return EntropicPoint(point.z + length * dz, point.multipliers + length * dm, duals), length


def pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))


def whitened_bodies(program: ConeProgram, G: Array) -> Array:
    """G^-1 P G'^-1 of each body for each unit of z: p x 4 x 4 x n."""
    inverse = np.linalg.inv(G)
    units = np.einsum("pij,kjl,pml->pkim", inverse, PSEUDO_INERTIA, inverse, optimize=True)
    return np.asarray(np.einsum("pkim,pkn->pimn", units, program.bodies, optimize=True))


def _diagonal(values: Array) -> Array:
    """Diagonal matrices p x 4 x 4 of p x 4 numbers."""
    return np.asarray(values[:, :, None] * np.eye(4))


def _to_boundary(root: Array, change: Array) -> float:
    """How far along ``change`` the diagonal matrices ``root`` stay positive definite."""
    scaled = change / np.sqrt(root[:, :, None] * root[:, None, :])
    lowest = float(np.linalg.eigvalsh(scaled).min())
    return -1.0 / lowest if lowest < 0.0 else np.inf


def _reach(values: Array, change: Array) -> float:
    """Longest step along which positive values stay positive."""
    falling = change < 0.0
    return float((-values[falling] / change[falling]).min(initial=np.inf))
