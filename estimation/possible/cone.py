"""Least squares over bodies that can exist, as a cone program, solved by Clarabel.

Minimise t with ||R z - d|| <= t, A z + b >= 0 and positive semidefinite pseudo-inertias. The form with the norm,
not its square, keeps the condition number of R instead of R'R; z must be scaled to the order of 1.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from ...common import Array
from .constraints import PSEUDO_INERTIA

Part = tuple[Literal["Zero", "Nonnegative", "SecondOrder", "PSDTriangle", "Exponential"], Array]
"""Cone, and rows (A b) of what lies in it, A x + b; those of a triangle by its columns."""


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
    """Solution, and how fast its norm ||R z - d|| falls as constraints are relaxed."""

    z: Array  # (n,)
    norm: float
    row_multipliers: Array  # by A z + b >= -e, (r,)
    body_multipliers: Array  # by J >= -e times identity, (p,)


_MEANING = {  # of the solver's states
    "PrimalInfeasible": "nothing holds all of it",
    "DualInfeasible": "the data leave it open",
    "AlmostSolved": "the search came near an end, not to it",
    "MaxIterations": "the search took too many steps",
    "MaxTime": "the search took too long",
    "NumericalError": "the search lost its digits",
    "InsufficientProgress": "the search got stuck",
}


class SolverError(RuntimeError):
    """Error of the cone solver, which ended without a clean solution.

    Attributes:
        status: what the solver says.
        demands: what the constraints demand, in text.
        explanation: the status for those who do not know the solver.
    """

    def __init__(self, status: str, demands: Sequence[str] = ()) -> None:
        """Say what may be the reason."""
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
TRIANGLE: Array = np.array([(1.0 if i == j else np.sqrt(2.0)) * PSEUDO_INERTIA[:, i, j] for i, j in _ENTRIES])
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
    bodies = np.pad(TRIANGLE @ program.bodies, ((0, 0), (0, 0), (0, 2)))
    for largest, ball in ways:
        scale = max(1.0, float(np.abs(program.R).max()) / largest)
        # Rows in (z, t, 1).
        norm = np.column_stack([program.R, np.zeros(k), -program.d]) / scale
        parts: list[Part] = [
            ("Nonnegative", np.column_stack([program.A, np.zeros(r), program.b])),
            ("SecondOrder", np.vstack([np.eye(1, n + 2, n), norm])),
            *(("PSDTriangle", body) for body in bodies),
        ]
        if np.isfinite(ball):
            parts.append(("SecondOrder", np.vstack([ball * np.eye(1, n + 2, n + 1), np.eye(n, n + 2)])))
        solution = cone_solver(np.eye(n + 1)[n], parts).solve()
        status = str(solution.status)
        if status == "Solved":
            z, dual = np.asarray(solution.x)[:n], np.asarray(solution.z) * scale
            traces = dual[r + k + 1 : r + k + 1 + 10 * p].reshape(p, 10)[:, _DIAGONAL].sum(axis=1)
            return ConeSolution(z, float(np.linalg.norm(program.R @ z - program.d)), dual[:r], traces)
    raise SolverError(status)


def cone_solver(cost: Array, parts: Sequence[Part], tolerance: float = 1e-8, reused: bool = False) -> Any:
    """Make a solver for the x of least cost whose parts lie in their cones; one thread, no output.

    ``tolerance``: of gap and feasibility; ``reused``: whether other costs come later. Such a solver's rows are well
    scaled and stay as they are.
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
    cones = []
    for kind, rows in parts:
        size = int(np.sqrt(2 * len(rows))) if kind == "PSDTriangle" else len(rows)
        if size:
            cones.append(getattr(clarabel, f"{kind}ConeT")(*(() if kind == "Exponential" else (size,))))
    matrix, no_squares = np.vstack([rows for _, rows in parts]), csc_matrix((len(cost), len(cost)))
    return clarabel.DefaultSolver(no_squares, cost, csc_matrix(-matrix[:, :-1]), matrix[:, -1], cones, settings)
