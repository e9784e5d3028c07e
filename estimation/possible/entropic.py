"""Least squares with an entropic distance of bodies from a prior, by an interior-point method.

Minimises ||F z - d||^2 + w sum D(P_j || P0_j) under A z + b >= 0. D = -log det(P P0^-1) + tr(P0^-1 P) - 4 is the
log-det divergence of pseudo-inertias (Lee, Wensing and Park, 2020); it keeps every P_j positive definite and does
not change with frames or units.

At the minimum P S = w 1 with duals S_j: it is the point of the central path of the semidefinite program
||F z - d||^2 + w tr(P0^-1 P) at which the barrier's parameter has fallen to w. So the path is followed from a large
parameter down to w, with steps in the scaling of Nesterov and Todd: with G' S G = G^-1 P G'^-1 diagonal and
M dz = G^-1 dP G'^-1 a step minimises ||M dz + G' (w P0^-1 - mu P^-1) G||^2 / 2 beside the other terms, and so do
the rows with their multipliers. Each step is a linear least-squares problem, solved by QR of the stacked rows,
which keeps the condition number of F instead of F'F.

This is the most specialised code of the house. Whoever mends it compares with
``tests/estimation/test_constrained_prior.py``, which solves the same problem by CVXPY.
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
_MET = 1e-8
"""Of the budget: how exactly it is met."""
_ROUNDS = 60
_FAR = 3.0
"""By which the weight's logarithm changes at most in a round."""
_NEAR = 0.3
"""Up to this change a solution is a good start for the next; else the start is."""


class EntropicPoint(NamedTuple):
    """``z`` (n,), ``multipliers`` (r,) of the rows, ``duals`` p x 4 x 4 of the bodies; or a change of all three."""

    z: Array
    multipliers: Array
    duals: Array


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
        F, d, A, *_ = self.program
        slack, P = self.program.slack(z), pseudo_inertias(self.program, z)
        # Duals that outweigh the gradient of chi2 in the barrier's own metric.
        bodies = self._whitened(np.linalg.inv(np.linalg.cholesky(P))).reshape(-1, len(z))
        barrier = np.vstack([bodies, A / slack[:, None], 1e-3 * np.eye(len(z))])
        triangle = np.linalg.qr(barrier, mode="r")
        gradient = 2.0 * F.T @ (F @ z - d)
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
            P, slack = pseudo_inertias(self.program, point.z), self.program.slack(point.z)
            mu = max(fall * float(np.einsum("pij,pji->", P, point.duals)) / (4 * len(P)), weight)
            nu = max(fall * float(point.multipliers @ slack) / max(len(slack), 1), _CORNER * weight)
            change, square, reach = self._step(weight, mu, nu, point)
            length = min(1.0, _INSIDE * reach)
            point = EntropicPoint(*(value + length * by for value, by in zip(point, change, strict=True)))
            fall = max(_CENTRING, (1.0 - length) ** 0.5)  # after a short step, centre before going on
            if mu <= weight and nu <= _CORNER * weight and square < _PRECISE * weight:
                return point
        raise SolverError("interior-point steps did not converge")

    def within_budget(self, start: EntropicPoint, least: float, budget: float) -> tuple[float, EntropicPoint]:
        """Weight and point at which chi2 = least + budget; chi2 rises with the weight, from ``least`` at none.

        Newton's method on logarithms inside a bracket.

        Raises:
            SolverError: if it does not converge.
        """
        weight, low, high = 0.1 * budget, 0.0, np.inf
        point = start
        F, d = self.program[:2]
        for _ in range(_ROUNDS):
            point = self.minimum(weight, point)
            rise = self.chi2(point.z) - least
            if abs(rise - budget) <= _MET * budget:
                return weight, point
            low, high = (weight, high) if rise < budget else (low, weight)
            # From a minimum, the step towards twice the weight is dz / d log w.
            change, *_ = self._step(2.0 * weight, 2.0 * weight, 2.0 * _CORNER * weight, point)
            slope = 2.0 * float((F @ point.z - d) @ (F @ change.z))
            step = -np.log(rise / budget) * rise / slope if rise > 0.0 and slope > 0.0 else -_FAR
            next_weight = weight * float(np.exp(np.clip(step, -_FAR, _FAR)))
            if not low < next_weight < high:
                next_weight = float(np.sqrt(low * high)) if low > 0.0 else high * float(np.exp(-_FAR))
            point = point if abs(np.log(next_weight / weight)) < _NEAR else start
            weight = next_weight
        raise SolverError("no weight of the prior meets the budget")

    def _step(
        self, weight: float, mu: float, nu: float, point: EntropicPoint
    ) -> tuple[EntropicPoint, float, float]:
        """The change of a point, its squared length in its own metric, and the part that leads to the boundary."""
        F, d, A, *_ = self.program
        z, multipliers, duals = point
        n, slack = len(z), self.program.slack(z)
        C = np.linalg.cholesky(pseudo_inertias(self.program, z))
        squares, Q = np.linalg.eigh(np.swapaxes(C, 1, 2) @ duals @ C)
        root = np.sqrt(np.maximum(squares, 1e-300))  # the diagonal of P and of S in the scaling G, p x 4
        G = C @ Q / np.sqrt(root)[:, None, :]
        inverse = np.linalg.inv(G)
        M = self._whitened(inverse)
        barrier = mu * _diagonal(1.0 / root)
        pull = weight * np.swapaxes(G, 1, 2) @ np.linalg.solve(self.prior, G) - barrier
        stiff = np.sqrt(multipliers / (2.0 * slack))
        left = [F, np.sqrt(0.5) * M.reshape(-1, n), stiff[:, None] * A]
        right = [d - F @ z, -np.sqrt(0.5) * pull.ravel(), nu / np.sqrt(2.0 * slack * multipliers)]
        stacked = np.column_stack([np.vstack(left), np.concatenate(right)])
        R = np.asarray(lapack.dgeqrf(stacked, overwrite_a=1)[0])
        dz = solve_triangular(R[:n, :n], R[:n, n])  # which reads the upper triangle alone
        dP, opened = M @ dz, A @ dz
        dS = barrier - _diagonal(root) - dP
        dm = (nu - multipliers * opened) / slack - multipliers
        reach = np.inf
        for change in (dP, dS):
            lowest = float(np.linalg.eigvalsh(change / np.sqrt(root[:, :, None] * root[:, None, :])).min())
            reach = min(reach, -1.0 / lowest if lowest < 0.0 else np.inf)
        for values, change in ((slack, opened), (multipliers, dm)):
            falling = change < 0.0
            reach = min(reach, float((-values[falling] / change[falling]).min(initial=np.inf)))
        change_of_duals = np.swapaxes(inverse, 1, 2) @ dS @ inverse
        change_of_duals = 0.5 * (change_of_duals + np.swapaxes(change_of_duals, 1, 2))
        return EntropicPoint(dz, dm, change_of_duals), float(R[:n, n] @ R[:n, n]), reach

    def _whitened(self, inverse: Array) -> Array:
        """G^-1 P G'^-1 of each body for each unit of z, p x 4 x 4 x n, by the inverses of G."""
        units = np.einsum("pij,kjl,pml->pkim", inverse, PSEUDO_INERTIA, inverse, optimize=True)
        return np.asarray(np.einsum("pkim,pkn->pimn", units, self.program.bodies, optimize=True))


def pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))


def _diagonal(values: Array) -> Array:
    """Diagonal matrices p x 4 x 4 of p x 4 numbers."""
    return np.asarray(values[:, :, None] * np.eye(4))
