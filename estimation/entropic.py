"""Least squares plus a weight times the entropic distance from prior bodies, by a primal-dual interior-point method.

Minimises ||F z - d||^2 + w sum D(P_j || P0_j) under A z + b >= 0, with the log-det divergence of pseudo-inertias
D = -log det(P P0^-1) + tr(P0^-1 P) - 4 (Lee, Wensing and Park, 2020). D keeps every P_j positive definite and does
not change with frames or units.

Its minimum has P S = w 1 with the dual S_j, as a cone program's central path has with w as the barrier's parameter.
Newton's method on P alone is slow for a small w; in the scaling of Nesterov and Todd, G G' S G G' = P, it is not:
with M dz = G^-1 dP G^-T the step minimises ||M dz + w G'(P0^-1 - P^-1) G||^2 / 2 beside the other terms, and so do
the rows with their multipliers. Each step is a linear least-squares problem, solved by QR of the stacked rows, which
keeps the condition number of F instead of F'F.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ..model.arrays import Array
from .cone import ConeProgram, SolverError
from .constraints import PSEUDO_INERTIA

_STEPS = 100
_INSIDE = 0.9
"""Of the way to the boundary: longest step."""
_CENTRING = 0.1
"""By which the rows' complementarity falls once a step changes less than it."""
_CORNER = 1e-7
"""Of the weight: complementarity of each row at the end."""
_PRECISE = 1e-12
"""Of the weight: half the squared length of the last step, in its own metric."""
_ROUGH = 0.3
"""The same two on the way."""


class EntropicPoint(NamedTuple):
    """``z`` (n,), ``multipliers`` (r,) of the rows, ``duals`` p x 4 x 4 of the bodies."""

    z: Array
    multipliers: Array
    duals: Array


class _Scaled(NamedTuple):
    """Bodies where P and S are both the diagonal ``root`` (p x 4): ``G`` p x 4 x 4, ``M`` p x 4 x 4 x n."""

    G: Array
    root: Array
    M: Array


class _Step(NamedTuple):
    """Triangle and right-hand side of the step's least-squares problem, and the bodies it was made with."""

    triangle: Array
    right: Array
    bodies: _Scaled
    pull: Array


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

    def start(self, weight: float, z: Array) -> EntropicPoint:
        """A point with P S = w 1 and rows alike; z strictly inside, shape (n,)."""
        slack = self.program.A @ z + self.program.b
        return EntropicPoint(z, weight / slack, weight * np.linalg.inv(pseudo_inertias(self.program, z)))

    def minimum(self, weight: float, point: EntropicPoint, precise: bool = True) -> EntropicPoint:
        """Solve for one weight.

        Args:
            weight: w.
            point: the solution for another weight.
            precise: to rounding, or just enough to go on with a smaller weight.

        Raises:
            SolverError: if it does not converge.
        """
        last = weight * (_CORNER if precise else 1.0)
        done = weight * (_PRECISE if precise else _ROUGH)
        slack = self.program.A @ point.z + self.program.b
        target = max(float(point.multipliers @ slack) / max(len(slack), 1), last)
        for _ in range(_STEPS):
            step = self._step(weight, target, point)
            length = float(step.right @ step.right)
            if target <= last and length < done:
                return point
            if target > last and length < max(target, done):
                target = max(_CENTRING * target, last)
                step = self._step(weight, target, point)
            point = self._moved(weight, target, point, step)
        raise SolverError("Newton steps did not converge", self.program)

    def slope(self, weight: float, point: EntropicPoint) -> float:
        """d chi2 / d log w at a minimum: dz/dw = -K^-1 grad D, K the Hessian of all."""
        F, d = self.program[:2]
        step = self._step(weight, _CORNER * weight, point)
        gradient = np.tensordot(step.pull, step.bodies.M, 3)
        dz = solve_triangular(step.triangle, solve_triangular(step.triangle, gradient, trans="T"))
        return -float((F @ point.z - d) @ (F @ dz))

    def _step(self, weight: float, target: float, point: EntropicPoint) -> _Step:
        F, d, A, b = self.program[:4]
        slack = A @ point.z + b
        bodies = self._scaled(point)
        G, n = bodies.G, F.shape[1]
        pull = weight * (np.swapaxes(G, 1, 2) @ np.linalg.solve(self.prior, G) - _diagonal(1.0 / bodies.root))
        stiff = np.sqrt(point.multipliers / (2.0 * slack))
        left = [F, np.sqrt(0.5) * bodies.M.reshape(-1, n), stiff[:, None] * A]
        right = [d - F @ point.z, -np.sqrt(0.5) * pull.ravel(), target / np.sqrt(2.0 * slack * point.multipliers)]
        stacked = np.column_stack([np.vstack(left), np.concatenate(right)])
        R = np.asarray(lapack.dgeqrf(stacked, overwrite_a=1)[0])
        return _Step(np.triu(R[:n, :n]), R[:n, n], bodies, pull)

    def _scaled(self, point: EntropicPoint) -> _Scaled:
        C = np.linalg.cholesky(pseudo_inertias(self.program, point.z))
        squares, Q = np.linalg.eigh(np.swapaxes(C, 1, 2) @ point.duals @ C)
        root = np.sqrt(squares)
        G = C @ Q / np.sqrt(root)[:, None, :]
        inverse = np.linalg.inv(G)
        units = np.einsum("pij,kjl,pml->pkim", inverse, PSEUDO_INERTIA, inverse, optimize=True)
        return _Scaled(G, root, np.einsum("pkim,pkn->pimn", units, self.program.bodies, optimize=True))

    def _moved(self, weight: float, target: float, point: EntropicPoint, step: _Step) -> EntropicPoint:
        """The point after a step as long as everything stays inside."""
        A, b = self.program.A, self.program.b
        dz = solve_triangular(step.triangle, step.right)
        G, root, M = step.bodies
        dP = M @ dz
        dS = weight * _diagonal(1.0 / root) - _diagonal(root) - dP
        slack, change = A @ point.z + b, A @ dz
        dm = (target - point.multipliers * change) / slack - point.multipliers
        reach = min(_to_boundary(root, dP), _to_boundary(root, dS), _reach(slack, change))
        length = min(1.0, _INSIDE * min(reach, _reach(point.multipliers, dm)))
        inverse = np.linalg.inv(G)
        duals = np.swapaxes(inverse, 1, 2) @ (_diagonal(root) + length * dS) @ inverse
        duals = 0.5 * (duals + np.swapaxes(duals, 1, 2))
        return EntropicPoint(point.z + length * dz, point.multipliers + length * dm, duals)


def pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))


def _diagonal(values: Array) -> Array:
    """Diagonal matrices p x 4 x 4 of p x 4 numbers."""
    return values[:, :, None] * np.eye(4)


def _to_boundary(root: Array, change: Array) -> float:
    """How far along ``change`` the diagonal matrices ``root`` stay positive definite."""
    scaled = change / np.sqrt(root[:, :, None] * root[:, None, :])
    lowest = float(np.linalg.eigvalsh(scaled).min())
    return -1.0 / lowest if lowest < 0.0 else np.inf


def _reach(values: Array, change: Array) -> float:
    """Longest step along which positive values stay positive."""
    falling = change < 0.0
    return float((-values[falling] / change[falling]).min(initial=np.inf))
