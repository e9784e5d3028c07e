"""The payload nearest to a free estimate among those that can exist.

Minimises (x - x_LS)' C^-1 (x - x_LS) over the x that hold the constraints. Whatever method gave x_LS with its full
covariance C, the data enter only through this distance: of method 4's joint problem, minimised over the robot's
parameters first, which are not constrained, it is exactly what is left (C^-1 is the Schur complement).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtrc, fdtrc

from ...common import Array, Brief, Document, Float, InputError, decomposed, freeze_fields, one_thread
from ...model import InertialParameters
from ..equations.equations import PAYLOAD
from ..fit.estimate import Estimate
from .constraints import ConeProgram, Constraint, KnownMass, PossibleBody, SolverError, least_eigenvalue, solve_cone

CONFLICT = 0.01  # probability below which a constraint and the data contradict each other


class Active(NamedTuple):
    """A demand that holds the estimate back.

    ``multiplier``: how fast chi2 falls as it is relaxed, per scaled unit (M l^2, M l, M of the body): a slope, so
    that of several the one to blame is found by leaving each out in turn; ``constraint``: of a payload. Once
    ``tested``, ``rise`` is what it adds to chi2, and ``p_value`` the probability of as much if it is true, at most:
    by chi-squared (or Fisher's F) of as many degrees as the constraint restricts directions; nan before.
    """

    description: str
    multiplier: float = 0.0
    constraint: Constraint | None = None
    rise: float = np.nan
    p_value: float = np.nan

    @property
    def conflict(self) -> bool:
        """True if it contradicts the data."""
        return self.p_value < CONFLICT


class Weighing(Document, frozen=True):
    """A weighed mass beside the identified one [kg], each with its standard deviation.

    Attributes:
        z: standard deviations of their difference by which the identified mass is larger.
        p_value: probability of as large a difference of either sign.
    """

    mass: float
    sigma: float
    identified: float
    identified_sigma: float
    degrees_of_freedom: Float
    z: Float
    p_value: Float

    @classmethod
    def by(cls, scale: KnownMass, estimate: Estimate) -> Self:
        """Compare what a scale shows with the mass of an estimate."""
        identified, sigma = estimate["M_L"], float(estimate.sigma[estimate.names.index("M_L")])
        z = (identified - scale.mass) / float(np.hypot(scale.sigma, sigma))
        p_value = rise_p_value(z**2, 1, estimate.degrees_of_freedom)
        return cls(scale.mass, scale.sigma, identified, sigma, estimate.degrees_of_freedom, z, p_value)

    @property
    def conflict(self) -> bool:
        """True if scale and identification contradict each other."""
        return self.p_value < CONFLICT


@dataclass(frozen=True, eq=False, repr=False)
class Possible(Brief):
    """A payload, or the links of a robot, that can exist."""

    free: Estimate  # the unconstrained estimate with the covariance by which distance and p-value go
    values: Array  # of a payload the ten of ``PAYLOAD``, eliminated ones zero; of a robot those of ``free.names``
    chi2_rise: float  # of these values, squared distance from the free ones by their covariance, plus soft terms
    active: tuple[Active, ...]  # what holds the estimate back, largest multiplier first
    bodies: tuple[InertialParameters, ...]  # the payload alone, or one robot's links; each can exist
    # of the solver; without a solve "free" if the free estimate holds every constraint, "repaired" if it does but
    # for an eigenvalue of rounding size (exact data), "prior" if a prior itself will do
    status: str
    constraints: tuple[Constraint, ...] = ()  # of a payload

    def __post_init__(self) -> None:
        freeze_fields(self, values=(None,))

    @property
    def body(self) -> InertialParameters:
        """Payload as a body."""
        (body,) = self.bodies
        return body

    @cached_property
    def min_eigenvalues(self) -> tuple[float, ...]:
        """Smallest eigenvalue of each body's pseudo-inertia; none is negative."""
        return tuple(body.min_pseudo_inertia_eigenvalue for body in self.bodies)

    @cached_property
    def p_value(self) -> float:
        """Probability of a rise this large if what is true keeps the constraints, at most.

        The nearest admissible point is no farther than the truth, whose squared distance is chi-squared with as
        many degrees of freedom k as there are parameters and soft terms (k times Fisher's F, as the covariance
        holds an estimated variance): a small p-value says that a constraint or the model is wrong.
        """
        k = len(self.free.names) + sum(isinstance(constraint, KnownMass) for constraint in self.constraints)
        return rise_p_value(self.chi2_rise, k, self.free.degrees_of_freedom)

    @property
    def weighings(self) -> tuple[Weighing, ...]:
        """Weighed masses against the free estimate."""
        return tuple(Weighing.by(scale, self.free) for scale in self.constraints if isinstance(scale, KnownMass))


def rise_p_value(chi2: float, k: int, degrees_of_freedom: float) -> float:
    """Probability that chi-squared of k degrees, or k times F(k, degrees_of_freedom), exceeds ``chi2``."""
    if np.isinf(degrees_of_freedom):
        return float(chdtrc(k, chi2))
    return float(fdtrc(k, max(degrees_of_freedom, 1.0), chi2 / k))


POSSIBLE = (PossibleBody("payload"),)  # constraints of every payload
_NO_MULTIPLIER = 1e-7  # multiplier below which it is rounding
_DEPENDENT = 1e-13  # smallest eigenvalue of a correlation matrix that counts as of full rank
NOISE_FLOOR = 3e-7
"""Noise floor in the body's own size: a solver accurate to 1e-8 cannot weigh finer errors; no recording has any."""
TOLERANCE = 1e-6  # largest miss of a linear constraint, in scaled units


class ScaledProblem(NamedTuple):
    """Problem in z = x / (M l^2, M l, M) of the parameters that are left: chi2 = ||R z - d||^2 + floor."""

    constraints: tuple[Constraint, ...]  # among them ``PossibleBody``
    select: Array  # picks the parameters, n x 10
    scale: Array  # (n,)
    ten: Array  # all ten in SI units are z @ ten, n x 10
    centre: Array  # minimum of chi2, (n,)
    floor: float
    program: ConeProgram  # R n x n; its rows have a largest entry of 1 and come constraint by constraint

    @staticmethod
    def of(estimate: Estimate, constraints: Sequence[Constraint]) -> "ScaledProblem":
        """Scale an estimate and its constraints."""
        if "M_L" not in estimate.names or not set(estimate.names) <= set(PAYLOAD):
            given = f"an estimate of {', '.join(estimate.names)} is not that of a payload"
            raise InputError(f"{given}: it needs M_L and others of {', '.join(PAYLOAD)}")
        if not any(isinstance(c, PossibleBody) for c in constraints):
            constraints = (*POSSIBLE, *constraints)
        select = np.eye(10)[[PAYLOAD.index(name) for name in estimate.names]]
        # M l^2, M l and M for the ten, from the estimate itself or, where it is next to nothing, its sigma.
        size = np.maximum(np.abs(estimate.values), estimate.sigma) @ select
        mass = size[9]
        length = np.sqrt(max(size[[0, 3, 5]].sum() / 2.0, size[6:9].max() ** 2 / mass) / mass)
        scale = select @ np.array([mass * length**2] * 6 + [mass * length] * 3 + [mass])
        centre, n = estimate.values / scale, len(scale)
        R, floor = whitening(estimate.covariance, estimate.names, NOISE_FLOOR * scale) * scale, 0.0
        d = R @ centre
        # One more QR merges soft terms: the distance from their common minimum is all that is left to the solver.
        soft = [np.append(select[:, 9] * scale, c.mass) / c.sigma for c in constraints if isinstance(c, KnownMass)]
        if soft:
            merged = np.asarray(np.linalg.qr(np.vstack([np.column_stack([R, d]), *soft]), mode="r"))
            R, d, floor = merged[:n, :n], merged[:n, n], float(merged[n, n] ** 2)
            centre = solve_triangular(R, d)
        rows, bounds = zip(*(c.rows for c in constraints), strict=True)
        A, b = np.vstack(rows) @ select.T * scale, np.concatenate(bounds)
        norms = np.maximum(np.abs(A).max(axis=1, initial=0.0), 1e-300)
        program = ConeProgram(R, d, A / norms[:, None], b / norms, select.T[None])
        return ScaledProblem(tuple(constraints), select, scale, scale[:, None] * select, centre, floor, program)

    def holds(self, z: Array, rounding: float = 0.0) -> bool:
        """True if z keeps every constraint, but for that much of an eigenvalue."""
        kept = bool((self.program.A @ z + self.program.b >= 0.0).all())
        return kept and least_eigenvalue(z @ self.select) >= -rounding


def holding(
    program: ConeProgram, z: Array, prices: Array, demands: Sequence[Active], floor: float, slope: float
) -> tuple[Active, ...]:
    """Demands whose multiplier exceeds their slack and ``floor``, largest first; equal ones count together.

    ``prices``, ``demands``: of the rows, then of the bodies; ``slope``: of chi2 by what prices are multipliers of.
    """
    slacks = [*(program.A @ z + program.b), *(least_eigenvalue(body @ z) for body in program.bodies)]
    found = dict[str, Active]()
    for demand, price, slack in zip(demands, prices.tolist(), slacks, strict=False):
        if price > max(slack, floor):
            before = found.get(demand.description, demand)
            found[demand.description] = before._replace(multiplier=before.multiplier + slope * price)
    return tuple(sorted(found.values(), key=lambda one: -one.multiplier))


IDENTITY: Array = np.array([2.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0])
"""Ten parameters whose pseudo-inertia is the identity."""


def lifted(z: Array, scale: Array) -> Array:
    """Move a body's ten in units of ``scale`` by as little as leaves no negative eigenvalue."""
    size, inward = max(1.0, float(np.abs(z).max())), np.where(scale > 0.0, IDENTITY, 0.0)
    step, limit = 1.01 * max(-least_eigenvalue(z), 0.0), TOLERANCE * size
    while step < limit and InertialParameters((z + step * inward) * scale).min_pseudo_inertia_eigenvalue < 0.0:
        step = 2.0 * step + 1e-16 * size
    if step >= limit:
        raise SolverError("eigenvalues too negative to be repaired")
    return np.asarray(z + step * inward)


def whitening(C: Array, names: Sequence[str], floor: Array) -> Array:
    """Root R with R'R = (C + diag(floor^2))^-1."""
    sigma = np.sqrt(np.maximum(np.diag(C), 0.0))
    if not np.isfinite(C).all() or (sigma == 0.0).any():
        raise InputError(f"the covariance of {', '.join(names)} is not a covariance: identify all of them first")
    values, vectors = np.linalg.eigh(C / np.outer(sigma, sigma))
    if values[0] < _DEPENDENT * values[-1]:
        mixed = ", ".join(name for name, part in zip(names, np.abs(vectors[:, 0]), strict=True) if part > 0.05)
        advice = "constraints cannot replace motion, so move more joints"
        raise InputError(f"the data cannot separate {mixed}: {advice}")
    L = np.linalg.cholesky((C + np.diag(floor**2)) / np.outer(sigma, sigma))
    return np.linalg.solve(L, np.diag(1.0 / sigma))


@one_thread()
def solve_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> Possible:
    """Find the nearest payload that keeps the constraints.

    Bounds hold to 1e-6 of the body's own size, the pseudo-inertia exactly: it is repaired, which chi2 knows of.

    Args:
        estimate: of some or all of ``PAYLOAD``; parameters that are absent were eliminated and stay zero.

    Raises:
        InputError: if the covariance does not determine every parameter.
        SolverError: for anything but a clean solve, as when no body holds all constraints.
    """
    problem = ScaledProblem.of(estimate, constraints)
    constraints, select, scale, ten, z, floor, program = problem
    status, active, values = "free", tuple[Active, ...](), z @ ten
    try:
        if any(constraint.violation(values) > 0.0 for constraint in constraints):
            # What is violated by rounding is too little for a solver to work on.
            prices, status = np.zeros(0), "repaired"
            if not problem.holds(z, NOISE_FLOOR):
                (z, prices), status = solve_cone(program), "Solved"
            slope = 2.0 * float(np.linalg.norm(program.R @ z - program.d))  # d chi2 = 2 norm d norm
            z = select @ lifted(z @ select, scale @ select)  # eliminated parameters stay zero
            if (program.A @ z + program.b < -TOLERANCE).any():
                raise SolverError("constraints missed by more than rounding")
            demands = [Active(c.description, constraint=c) for c in constraints for _ in c.rows[1]]
            demands += [Active(c.description, constraint=c) for c in constraints if isinstance(c, PossibleBody)]
            active, values = holding(program, z, prices, demands, _NO_MULTIPLIER, slope), z @ ten
    except SolverError as error:
        raise SolverError(error.status, [constraint.description for constraint in constraints]) from None
    chi2 = floor + float(np.sum((program.R @ (z - problem.centre)) ** 2))
    return Possible(estimate, values, chi2, active, (InertialParameters(values),), status, constraints)


def tested(result: Possible) -> tuple[Active, ...]:
    """Test each active constraint by itself: the rise with all constraints less that without it.

    That a body must exist is not left out; its rise is that which it causes alone.
    """
    tested, free = list[Active](), result.free
    for active in result.active:
        constraint = active.constraint
        assert constraint is not None
        if isinstance(constraint, PossibleBody):
            rise, k = solve_constrained(free, [constraint]).chi2_rise, len(free.names)
        else:
            others = [other for other in result.constraints if other is not constraint]
            rise = result.chi2_rise - solve_constrained(free, others).chi2_rise
            k = len(decomposed(constraint.rows[0]).singular)
        p_value = rise_p_value(max(rise, 0.0), k, free.degrees_of_freedom)
        tested.append(active._replace(rise=rise, p_value=p_value))
    return tuple(tested)


def build_constrained(estimate: Estimate, constraints: Sequence[Constraint] = POSSIBLE) -> tuple[Any, Any, Any]:
    """Build the problem of ``solve_constrained`` in CVXPY, not solved yet: constraints and terms can be added.

    Add your own by ``cvxpy.Problem(problem.objective, [*problem.constraints, ...])``. Its solution is not repaired:
    eigenvalues down to -1e-7 of the largest are left.

    Returns:
        The ``cvxpy.Problem``, its value the distance, square root of the chi2 rise less what soft terms alone cost;
        the parameters ``estimate.names`` and their pseudo-inertia, 4 x 4, both expressions in SI units.

    Raises:
        InputError: if the covariance does not determine every parameter.
    """
    scaled = ScaledProblem.of(estimate, constraints)
    problem, values, (inertia,) = scaled.program.posed(scaled.scale)
    return problem, values, inertia
