"""Prior knowledge of a body, as small values that can be combined, and the least squares over bodies that hold it.

These are a cone program, solved by Clarabel: minimise t with ||R z - d|| <= t, A z + b >= 0 and pseudo-inertias
positive semidefinite. The norm, not its square, keeps the condition number of R instead of R'R; z is of order 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from ...common import Array, ArrayLike, InputError, frozen_array
from ...model import InertialParameters
from ...model.inertia import check_metres

PSEUDO_INERTIA: Array = np.array([InertialParameters(unit).pseudo_inertia for unit in np.eye(10)])
"""Matrices of the pseudo-inertia: J = sum over k of x_k times the k-th: 10 x 4 x 4."""


def least_eigenvalue(x: Array) -> float:
    """Smallest eigenvalue of the pseudo-inertia of ten parameters in any units."""
    return float(np.linalg.eigvalsh((x @ PSEUDO_INERTIA.reshape(10, 16)).reshape(4, 4))[0])


@dataclass(frozen=True)
class Constraint:
    """Constraint on x, Khalil's ten of one body about the origin and in the axes of its frame."""

    demand: ClassVar[str]  # its numbers to be filled in from the attributes

    @property
    def description(self) -> str:
        """Demand in one line."""
        return self.demand.format(**vars(self))

    def violation(self, x: ArrayLike) -> float:
        """Distance of x, (10,), from keeping it: <= 0 where it is kept, in the constraint's own unit."""
        A, b = self.rows
        return float(np.max(-(A @ np.asarray(x, dtype=float) + b), initial=-np.inf))

    @property
    def rows(self) -> tuple[Array, Array]:
        """Rows A, k x 10, and b, (k,), of its linear inequalities A x + b >= 0; none by default."""
        return np.zeros((0, 10)), np.zeros(0)


@dataclass(frozen=True)
class PossibleBody(Constraint):
    """Body that can exist: its 4 x 4 pseudo-inertia is positive semidefinite (Wensing, Kim and Slotine, 2018).

    Nothing weaker will do: positive mass and a positive definite inertia still allow principal inertias that
    break the triangle inequality, which no distribution of mass has. Every estimate holds it, listed or not.

    Attributes:
        body: how texts call the body.
    """

    body: str = "payload"
    demand = "{body} can exist: pseudo-inertia positive semidefinite"

    def violation(self, x: ArrayLike) -> float:
        """Minus the smallest eigenvalue of the pseudo-inertia (mixed units)."""
        return -InertialParameters(np.asarray(x, dtype=float)).min_pseudo_inertia_eigenvalue


@dataclass(frozen=True)
class MassBounds(Constraint):
    """Bounds on the mass: low <= M <= high.

    Attributes:
        low: smallest mass [kg].
        high: largest mass [kg]; may be infinite.
    """

    low: float = 0.0
    high: float = float("inf")
    demand = "mass from {low:g} to {high:g} kg"

    def __post_init__(self) -> None:
        if not self.low <= self.high or not np.isfinite(self.low) or not self.high > 0.0:
            advice = "give low <= high, and high above 0"
            raise InputError(f"no mass lies within {self.low:g} to {self.high:g} kg: {advice}")

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows of M - low >= 0 and high - M >= 0 [kg]."""
        finite, A = np.isfinite([self.low, self.high]), np.zeros((2, 10))
        A[:, 9] = 1.0, -1.0
        return A[finite], np.array([-self.low, self.high])[finite]


@dataclass(frozen=True)
class KnownMass(Constraint):
    """Weighed mass: a soft term ((M - mass) / sigma)^2, because scales err too, that nothing violates.

    Attributes:
        mass: what the scale shows [kg].
        sigma: its standard deviation [kg].
    """

    mass: float
    sigma: float
    demand = "mass weighed as {mass:g} kg, standard deviation {sigma:g} kg"

    def __post_init__(self) -> None:
        if not (self.mass > 0.0 and self.sigma > 0.0 and np.isfinite([self.mass, self.sigma]).all()):
            given = f"known mass {self.mass:g} kg with sigma {self.sigma:g} kg"
            raise InputError(f"{given}: mass and sigma must be positive")


@dataclass(frozen=True)
class CentreOfMassInBox(Constraint):
    """Box along the frame's axes in which the centre of mass lies.

    Attributes:
        low: smallest coordinates [m], shape (3,).
        high: largest coordinates [m], shape (3,).
    """

    low: ArrayLike
    high: ArrayLike
    demand = "centre of mass in the box {low!r} to {high!r} m"

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, _as_tuples(getattr(self, name), (3,), f"{name} corner of the box"))
            check_metres(getattr(self, name), f"{name} corner of the box")
        if (np.asarray(self.low) > np.asarray(self.high)).any():
            raise InputError(f"the box from {self.low!r} to {self.high!r} m is empty: give low <= high")

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows of MX - M low >= 0 and M high - MX >= 0 for each axis [kg m]."""
        A = np.zeros((6, 10))
        A[:3, 6:9], A[3:, 6:9] = np.eye(3), -np.eye(3)
        A[:3, 9], A[3:, 9] = -np.asarray(self.low), np.asarray(self.high)
        return A, np.zeros(6)


@dataclass(frozen=True)
class InEllipsoid(Constraint):
    """Ellipsoid in which all mass lies: tr(J Q) >= 0 for the pseudo-inertia J (Wensing, Kim and Slotine, 2018).

    Q is the 4 x 4 matrix with [p 1] Q [p 1]' >= 0 for points p inside. With ``PossibleBody`` it is sufficient too.

    Attributes:
        centre: of the ellipsoid [m], shape (3,).
        semi_axes: half the lengths of its axes [m], shape (3,).
        rotation: 3 x 3, its columns are the directions of the axes; the frame's own by default.
    """

    centre: ArrayLike
    semi_axes: ArrayLike
    rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    demand = "mass in the ellipsoid around {centre!r} with semi-axes {semi_axes!r} m"

    def __post_init__(self) -> None:
        for name, shape in (("centre", (3,)), ("semi_axes", (3,)), ("rotation", (3, 3))):
            object.__setattr__(self, name, _as_tuples(getattr(self, name), shape, f"{name} of an ellipsoid"))
        for name in ("centre", "semi_axes"):
            check_metres(getattr(self, name), name)
        if not (np.asarray(self.semi_axes) > 0.0).all():
            raise InputError(f"semi_axes {self.semi_axes!r} m of an ellipsoid: all three must be positive")
        R = np.asarray(self.rotation)
        if np.abs(R.T @ R - np.eye(3)).max() > 1e-6:
            raise InputError("rotation of an ellipsoid: its columns must be orthonormal")

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Row of tr(J Q) >= 0 [kg]."""
        c, R = np.asarray(self.centre), np.asarray(self.rotation)
        A = R @ np.diag(1.0 / np.square(self.semi_axes)) @ R.T
        Q = np.block([[-A, (A @ c)[:, None]], [(c @ A)[None], np.array([[1.0 - c @ A @ c]])]])
        return np.einsum("kij,ij->k", PSEUDO_INERTIA, Q)[None], np.zeros(1)


def _as_tuples(values: ArrayLike, shape: tuple[int, ...], name: str) -> Any:
    """Convert numbers to nested tuples, which compare and hash."""
    try:
        array = frozen_array(values, shape, name)
    except ValueError as error:
        raise InputError(f"{error}: correct it") from None
    return tuple(map(tuple, array.tolist())) if array.ndim == 2 else tuple(array.tolist())


Part = tuple[Literal["Zero", "Nonnegative", "SecondOrder", "PSDTriangle", "Exponential"], Array]
"""Cone, and rows (A b) of what lies in it, A x + b; those of a triangle by its columns."""


class ConeProgram(NamedTuple):
    """Program to minimise ||R z - d|| with A z + b >= 0, and bodies of positive semidefinite pseudo-inertia."""

    R: Array  # k x n
    d: Array  # (k,)
    A: Array  # r x n
    b: Array  # (r,)
    bodies: Array  # maps from z to the ten of each body, p x 10 x n

    def posed(self, scale: Array) -> tuple[Any, Any, list[Any]]:
        """Pose it in CVXPY: the problem, its parameters in SI units, and the pseudo-inertias of its bodies."""
        import cvxpy  # slow to import

        z, entries = cvxpy.Variable(len(scale), name="scaled_parameters"), PSEUDO_INERTIA.reshape(10, 16).T
        x = cvxpy.multiply(scale, z)
        scaled, inertias = (
            [cvxpy.reshape(entries @ body @ parameters, (4, 4), order="C") for body in self.bodies]
            for parameters in (z, x)
        )
        rules = [*(inertia >> 0 for inertia in scaled), *([self.A @ z + self.b >= 0] if len(self.A) else [])]
        return cvxpy.Problem(cvxpy.Minimize(cvxpy.norm(self.R @ z - self.d)), rules), x, inertias


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
        super().__init__(status, tuple(demands))  # by which it is pickled
        self.status, self.demands, self.explanation = status, tuple(demands), _MEANING.get(status, status)

    def __str__(self) -> str:
        text, advice = "no body holds all constraints", "correct them"
        if "Infeasible" not in self.status:
            text = f"the constrained estimate was not found: {self.explanation}"
            advice = "check that the constraints allow some body near the data"
        return ": ".join([text, *filter(None, ["; ".join(self.demands)]), advice])


def upper(matrices: Array) -> Array:
    """Upper triangles of m x m matrices, the last two axes, by columns, off-diagonals times sqrt 2."""
    columns, rows = np.tril_indices(matrices.shape[-1])
    return np.asarray(np.where(rows == columns, 1.0, np.sqrt(2.0)) * matrices[..., rows, columns])


TRIANGLE: Array = upper(PSEUDO_INERTIA).T
"""Map from the ten to the triangle of the pseudo-inertia: 10 x 10."""
_DIAGONAL = [0, 2, 5, 9]  # of a triangle of 4 x 4


def solve_cone(program: ConeProgram, ways: Sequence[tuple[float, float]] = ((1e5, np.inf),)) -> tuple[Array, Array]:
    """Solve a cone program in the first way that gives a clean solution; the usual one is for data of little noise.

    It gives z, (n,), and how fast ||R z - d|| falls with e in A z + b >= -e, then in J >= -e times identity,
    (r + p,). ``ways``: largest entry of R, to which a larger one is scaled down, and radius of a ball that z may
    not leave: it closes a program whose least value no finite z attains.
    """
    (k, n), r, p, status = program.R.shape, len(program.A), len(program.bodies), ""
    rows = np.zeros((r + 1 + k + 10 * p + n + 1, n + 2))  # in (z, t, 1)
    rules, norm, bodies, ball = np.split(rows, [r, r + 1 + k, len(rows) - n - 1])
    rules[:, :n], rules[:, -1], norm[0, n] = program.A, program.b, 1.0
    bodies[:, :n], ball[1:, :n] = (TRIANGLE @ program.bodies).reshape(-1, n), np.eye(n)
    for largest, radius in ways:
        scale = max(1.0, float(np.abs(program.R).max()) / largest)
        norm[1:, :n], norm[1:, -1], ball[0, -1] = program.R / scale, -program.d / scale, radius
        parts: list[Part] = [("Nonnegative", rules), ("SecondOrder", norm)]
        parts += [("PSDTriangle", body) for body in bodies.reshape(p, 10, n + 2)]
        if np.isfinite(radius):
            parts.append(("SecondOrder", ball))
        solution = cone_solver(np.eye(n + 1)[n], parts).solve()
        status = str(solution.status)
        if status == "Solved":
            dual = np.asarray(solution.z) * scale
            traces = dual[r + k + 1 : r + k + 1 + 10 * p].reshape(p, 10)[:, _DIAGONAL].sum(axis=1)
            return np.asarray(solution.x)[:n], np.append(dual[:r], traces)
    raise SolverError(status)


def cone_solver(cost: Array, parts: Sequence[Part], tolerance: float = 1e-8, reused: bool = False) -> Any:
    """Make a solver for the x of least cost whose parts lie in their cones; one thread, no output.

    ``tolerance``: of gap and feasibility; ``reused``: whether other costs come later. Its rows stay as they are.
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
    left = -matrix[:, :-1].T
    column, row = left.nonzero()  # faster than SciPy finds them
    starts = np.searchsorted(column, np.arange(len(cost) + 1))
    A = csc_matrix((left[column, row], row, starts), left.shape[::-1])
    return clarabel.DefaultSolver(no_squares, cost, A, matrix[:, -1], cones, settings)
