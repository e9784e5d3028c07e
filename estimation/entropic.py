"""Least squares plus a weight times the entropic distance from prior bodies, by an interior-point Newton method.

Minimises ||F z - d||^2 + w sum D(P_j || P0_j) under A z + b >= 0, with the log-det divergence of pseudo-inertias
D = -log det(P P0^-1) + tr(P0^-1 P) - 4 (Lee, Wensing and Park, 2020). D keeps every P_j positive definite and does
not change with frames or units. With P = C C' its second-order model is ||M dz + g||^2 / 2, M dz = C^-1 dP C^-T and
g = C' P0^-1 C - I, and so is that of the rows' barrier: each Newton step is a linear least-squares problem, solved
by QR of the stacked rows, which keeps the condition number of F instead of F'F.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ..model.arrays import Array
from .cone import ConeProgram, SolverError
from .constraints import PSEUDO_INERTIA

_STEPS = 100
_CENTRING = 0.1
"""By which the mean complementarity is to fall in a step."""
_DONE = 1e-10
"""Of chi2: where complementarity and Newton's decrement end."""
_INSIDE = 0.95
"""Of the way to the boundary: longest step."""


class EntropicPoint(NamedTuple):
    """``z`` (n,), ``multipliers`` (r,) of the rows, ``chi2`` = ||F z - d||^2, ``slope``: d chi2 / d log w."""

    z: Array
    multipliers: Array
    chi2: float
    slope: float


class EntropicProgram(NamedTuple):
    """``program``: F, d, rows and bodies; ``prior`` p x 4 x 4: pseudo-inertias P0 in its scaled units."""

    program: ConeProgram
    prior: Array

    def distances(self, z: Array) -> Array:
        """D of each body, shape (p,)."""
        ratio = np.linalg.solve(self.prior, pseudo_inertias(self.program, z))
        return np.asarray(np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0)

    def minimum(self, weight: float, z: Array, multipliers: Array) -> EntropicPoint:
        """Solve for one weight.

        Args:
            weight: w.
            z: a point strictly inside, shape (n,).
            multipliers: of the rows, positive, shape (r,).

        Raises:
            SolverError: if it does not converge.
        """
        F, d, A, b = self.program[:4]
        floor = _DONE * max(1.0, float(np.sum((F @ z - d) ** 2)) * 1e-3)
        for _ in range(_STEPS):
            slack = A @ z + b
            gap = float(multipliers @ slack) / max(len(slack), 1)
            target = _CENTRING * gap
            triangle, right = self._step(weight, z, multipliers, target)
            dz = solve_triangular(triangle, right)
            decrement = float(right @ right)
            if decrement < floor and gap * len(slack) < floor:
                chi2 = float(np.sum((F @ z - d) ** 2))
                return EntropicPoint(z, multipliers, chi2, self._slope(weight, z, triangle))
            change = A @ dz
            dm = (target - multipliers * change) / slack - multipliers
            primal = min(1.0, _INSIDE * min(self._to_boundary(z, dz), _reach(slack, change)))
            primal = self._shortened(weight, target, z, dz, primal)
            dual = min(1.0, _INSIDE * _reach(multipliers, dm))
            z, multipliers = z + primal * dz, multipliers + dual * dm
        raise SolverError("Newton steps did not converge", self.program)

    def _step(self, weight: float, z: Array, multipliers: Array, target: float) -> tuple[Array, Array]:
        """Triangle and right-hand side of the step's least-squares problem."""
        F, d, A, b = self.program[:4]
        slack = A @ z + b
        M, g = self._whitened(z)
        root = np.sqrt(multipliers / (2.0 * slack))
        rows = [F, np.sqrt(weight / 2.0) * M, root[:, None] * A]
        right = [d - F @ z, -np.sqrt(weight / 2.0) * g, target / np.sqrt(2.0 * slack * multipliers)]
        n = F.shape[1]
        stacked = np.column_stack([np.vstack(rows), np.concatenate(right)])
        R = np.asarray(lapack.dgeqrf(stacked)[0])[: n + 1]
        return np.triu(R[:n, :n]), R[:n, n]

    def _whitened(self, z: Array) -> tuple[Array, Array]:
        """M, 16 p x n, and g (16 p,) of the second-order model at z."""
        C = np.linalg.cholesky(pseudo_inertias(self.program, z))
        inverse = np.linalg.inv(C)
        basis = np.einsum("pij,kjl,pml->pkim", inverse, PSEUDO_INERTIA, inverse, optimize=True)
        M = np.einsum("pkim,pkn->pimn", basis, self.program.bodies, optimize=True)
        g = np.swapaxes(C, 1, 2) @ np.linalg.solve(self.prior, C) - np.eye(4)
        return M.reshape(-1, len(z)), g.ravel()

    def _slope(self, weight: float, z: Array, triangle: Array) -> float:
        """d chi2 / d log w: dz/dw = -K^-1 grad D with K = 2 triangle' triangle."""
        F, d = self.program[:2]
        M, g = self._whitened(z)
        dz = solve_triangular(triangle, solve_triangular(triangle, M.T @ g, trans="T"))
        return -weight * float((F @ z - d) @ (F @ dz))

    def _to_boundary(self, z: Array, dz: Array) -> float:
        """How far along dz some body stays positive definite."""
        inverse = np.linalg.inv(np.linalg.cholesky(pseudo_inertias(self.program, z)))
        change = inverse @ pseudo_inertias(self.program, dz) @ np.swapaxes(inverse, 1, 2)
        lowest = float(np.linalg.eigvalsh(change).min())
        return -1.0 / lowest if lowest < 0.0 else np.inf

    def _shortened(self, weight: float, target: float, z: Array, dz: Array, step: float) -> float:
        """A step that does not raise the cost with the rows' barrier."""
        before = self._merit(weight, target, z)
        while step > 1e-10 and self._merit(weight, target, z + step * dz) > before + 1e-9 * abs(before):
            step *= 0.5
        return step

    def _merit(self, weight: float, target: float, z: Array) -> float:
        F, d, A, b = self.program[:4]
        barrier = float(np.log(A @ z + b).sum()) if len(b) else 0.0
        return float(np.sum((F @ z - d) ** 2)) + weight * float(self.distances(z).sum()) - target * barrier


def pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))


def _reach(values: Array, change: Array) -> float:
    """Longest step along which positive values stay positive."""
    falling = change < 0.0
    return float((-values[falling] / change[falling]).min(initial=np.inf))
