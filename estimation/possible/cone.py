"""Least squares over bodies that can exist, as a cone program, solved by Clarabel.

Minimise t with ||R z - d|| <= t, A z + b >= 0 and positive semidefinite pseudo-inertias. The form with the norm,
not its square, keeps the condition number of R instead of R'R; z must be scaled to the order of 1.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from ...common import Array
from .constraints import PSEUDO_INERTIA

Cone = tuple[Literal["Zero", "Nonnegative", "SecondOrder", "PSDTriangle", "Exponential"], int]
"""Cone and its size: rows, but for a triangle the side of its matrix; an exponential one has three rows."""


class ConeProgram(NamedTuple):
    """Program to minimise ||R z - d|| with A z + b >= 0, and bodies of positive semidefinite pseudo-inertia."""

    R: Array  # k x n
    d: Array  # (k,)
    A: Array  # r x n
    b: Array  # (r,)
    bodies: Array  # maps from z to the ten of each body, p x 10 x n

    def slack(self, z: Array) -> Array:
        """Slack A z + b, shape (r,)."""
        return np.asarray(self.A @ z + self.b)


class ConeSolution(NamedTuple):
    """Solution, and how fast its norm falls as constraints are relaxed."""

    z: Array  # (n,)
    norm: float  # ||R z - d||
    row_multipliers: Array  # by A z + b >= -e, (r,)
    body_multipliers: Array  # by J >= -e times identity, (p,)


_MEANING = {
    "PrimalInfeasible": "nothing holds all of it",
    "DualInfeasible": "the data leave it open",
    "AlmostSolved": "the search came near an end, not to it",
    "MaxIterations": "the search took too many steps",
    "MaxTime": "the search took too long",
    "NumericalError": "the search lost its digits",
    "InsufficientProgress": "the search got stuck",
}
"""Text on each of the solver's states."""


class SolverError(RuntimeError):
    """Error of the cone solver, which ended without a clean solution.

    Attributes:
        status: what the solver says.
        demands: what the constraints demand, in text.
        explanation: the status for those who do not know the solver.
    """

    def __init__(self, status: str, demands: Sequence[str] = ()) -> None:
        """Say what happened and what may be the reason."""
        self.status, self.demands, self.explanation = status, tuple(demands), _MEANING.get(status, status)
        infeasible = "Infeasible" in status
        text = f"the constrained estimate was not found: {self.explanation}"
        text = "no body holds all constraints" if infeasible else text
        listed = f": {'; '.join(demands)}" if demands else ""
        advice = "correct them" if infeasible else "check that the constraints allow some body near the data"
        super().__init__(f"{text}{listed}: {advice}")

    def __reduce__(self) -> tuple[type["SolverError"], tuple[str, tuple[str, ...]]]:
        """Pickle what it is made from."""
        return SolverError, (self.status, self.demands)

    def naming(self, *demands: str) -> "SolverError":
        """Name the constraints in the error."""
        return SolverError(self.status, demands)


_ENTRIES = [(row, column) for column in range(4) for row in range(column + 1)]
_DIAGONAL = [k for k, (row, column) in enumerate(_ENTRIES) if row == column]
TRIANGLE: Array = np.array(
    [(1.0 if i == j else np.sqrt(2.0)) * PSEUDO_INERTIA[:, i, j] for i, j in _ENTRIES],
)
"""Map from the ten to the pseudo-inertia's upper triangle, by columns, off-diagonals times sqrt 2: 10 x 10."""


Ways = Sequence[tuple[float, float]]
"""Largest entry of R, to which a larger one is scaled down, and radius of a ball that z may not leave.

The ball closes a program whose least value no finite z attains.
"""


def solve_cone(program: ConeProgram, ways: Ways = ((1e5, np.inf),)) -> ConeSolution:
    """Solve a cone program in the first way that gives a clean solution.

    ``ways``: the usual one cares for data almost without noise.
    """
    (k, n), r, p, status = program.R.shape, len(program.A), len(program.bodies), ""
    for largest, ball in ways:
        scale = max(1.0, float(np.abs(program.R).max()) / largest)
        # right - matrix (z, t) lies in the cones.
        matrix = np.zeros((r + k + 1 + 10 * p, n + 1))
        matrix[:r, :n] = -program.A
        matrix[r, n] = -1.0
        matrix[r + 1 : r + k + 1, :n] = -program.R / scale
        matrix[r + k + 1 :, :n] = -(TRIANGLE @ program.bodies).reshape(10 * p, n)
        right = np.concatenate([program.b, [0.0], -program.d / scale, np.zeros(10 * p)])
        cones: list[Cone] = [("Nonnegative", r), ("SecondOrder", k + 1)]
        cones += [("PSDTriangle", 4)] * p
        if np.isfinite(ball):
            cones.append(("SecondOrder", n + 1))
            matrix = np.vstack([matrix, np.zeros((1, n + 1)), np.hstack([-np.eye(n), np.zeros((n, 1))])])
            right = np.concatenate([right, [ball], np.zeros(n)])
        solution = cone_solver(np.append(np.zeros(n), 1.0), matrix, right, cones).solve()
        status = str(solution.status)
        if status == "Solved":
            z, dual = np.asarray(solution.x)[:n], np.asarray(solution.z) * scale
            traces = dual[r + k + 1 : r + k + 1 + 10 * p].reshape(p, 10)[:, _DIAGONAL].sum(axis=1)
            return ConeSolution(z, float(np.linalg.norm(program.R @ z - program.d)), dual[:r], traces)
    raise SolverError(status)


def cone_solver(
    cost: Array,
    matrix: Array,
    right: Array,
    cones: Sequence[Cone],
    tolerance: float = 1e-8,
    reused: bool = False,
) -> Any:
    """Make a solver for the x of least cost with right - matrix x in the cones; one thread, no output.

    Args:
        cost: shape (n,).
        matrix: m x n.
        right: shape (m,).
        cones: for the rows in their order.
        tolerance: of gap and feasibility.
        reused: whether other costs come later. Such a solver's rows are well scaled and stay as they are.
    """
    import clarabel  # both take their time to import: only where a cone program is solved
    from scipy.sparse import csc_matrix

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    if reused:
        settings.presolve_enable = False
        settings.chordal_decomposition_enable = False
        settings.equilibrate_enable = False
    sizes = [(kind, () if kind == "Exponential" else (size,)) for kind, size in cones if size]
    kinds = [getattr(clarabel, f"{kind}ConeT")(*size) for kind, size in sizes]
    no_squares = csc_matrix((len(cost), len(cost)))
    return clarabel.DefaultSolver(no_squares, cost, csc_matrix(matrix), right, kinds, settings)
