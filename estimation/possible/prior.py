"""Standard parameters of a robot that can exist: those nearest to a prior that the data allow.

Data speak only of base parameters; of all robots that explain them about as well, the one whose links are nearest
to a prior in entropic distance is one definite answer. The weight of the distance is chosen so that chi2 rises by a
stated budget above that of the nearest robot that can exist: the prior never costs more than that.

An interior-point method minimises ||F z - d||^2 + w sum D(P_j || P0_j) under A z + b >= 0. D = -log det(P P0^-1) +
tr(P0^-1 P) - 4 is the log-det divergence of pseudo-inertias (Lee, Wensing and Park, 2020); it keeps every P_j
positive definite and does not change with frames or units.

At the minimum P S = w 1 with duals S_j: it is the point of the central path of the semidefinite program
||F z - d||^2 + w tr(P0^-1 P) at which the barrier's parameter has fallen to w. So the path is followed from a large
parameter down to w, with steps in the scaling of Nesterov and Todd: with G' S G = G^-1 P G'^-1 diagonal and
M dz = G^-1 dP G'^-1 a step minimises ||M dz + G' (w P0^-1 - mu P^-1) G||^2 / 2 beside the other terms, and so do
the rows with their multipliers. Each step is a linear least-squares problem, solved by QR of the stacked rows,
which keeps the condition number of F instead of F'F.

This is the most specialised code of the house. Whoever mends it compares with
``tests/estimation/test_constrained_prior.py``, which solves the same problem by CVXPY.
"""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.stand_in import MOVING, cylinder_radius, cylinders, missing_inertial
from ..fit.estimate import Estimate, error_model
from .cone import ConeProgram, SolverError, solve_cone
from .constraints import PSEUDO_INERTIA, MassBounds
from .payload import TOLERANCE
from .result import Active
from .robot import PossibleRobot, RobotProgram, solve_robot_program
from .whole_robot import Origin, origins

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


@dataclass(frozen=True)
class RobotPrior:
    """Links as they are thought to be.

    Attributes:
        bodies: one per link, in its own frame; each has some extent (positive definite pseudo-inertia).
        source: where they come from, in words.
    """

    bodies: tuple[InertialParameters, ...]
    source: str

    def __post_init__(self) -> None:
        """Refuse a link from which no distance can be measured."""
        for link, body in enumerate(self.bodies, start=1):
            if body.mass <= 0.0 or body.min_pseudo_inertia_eigenvalue <= 0.0:
                raise InputError(
                    f"prior of link {link} ({self.source}): smallest eigenvalue of its pseudo-inertia "
                    f"{body.min_pseudo_inertia_eigenvalue:.2g}: give a body with mass and some extent"
                )

    @property
    def total_mass(self) -> float:
        """Mass of all links [kg]."""
        return sum(body.mass for body in self.bodies)


def robot_prior(robot: Robot, total_mass: float | None = None) -> RobotPrior:
    """The prior of a robot: the inertial parameters of its file, or cylinders of a total mass.

    Without a stated mass, and where the file has no parameters, it is the share ``MOVING`` of the maker's mass of
    the whole arm, for that holds the base.

    Args:
        total_mass: of all moving links [kg]; asks for the cylinders even if the file has parameters.

    Raises:
        InputError: if none of them is there, or the file holds only some of the parameters.
    """
    if total_mass is not None:
        return cylinder_prior(robot, total_mass)
    names = [f"{kind}{link}" for link in range(1, robot.n + 1) for kind in INERTIAL]
    missing = missing_inertial(robot)
    if len(missing) == len(names) and robot.mass is not None:
        prior, doubt = cylinder_prior(robot, MOVING * robot.mass), robot.assumed("mass").get("mass", "")
        share = f"{100.0 * MOVING:g} % of the maker's {robot.mass:g} kg, which holds the base"
        return replace(prior, source=f"{prior.source}: {share}{f' (assumed: {doubt})' if doubt else ''}")
    if len(missing) == len(names):
        raise InputError(
            f"robot {robot.name!r} has no inertial parameters in its file to serve as prior: give them under "
            "[parameters] of a robot file of your own, or the total mass of its links (--prior-mass KG)"
        )
    if missing:
        raise InputError(
            f"robot {robot.name!r}: {', '.join(missing[:6])} missing in [parameters]: a prior needs the ten of "
            "every link"
        )
    vectors = np.array([robot.parameters[name] for name in names]).reshape(robot.n, 10)
    return RobotPrior(tuple(map(InertialParameters, vectors)), f"the robot file of {robot.name}")


def has_prior(robot: Robot) -> bool:
    """Whether the robot's own file gives ``robot_prior`` something to start from."""
    missing = missing_inertial(robot)
    return not missing or (robot.mass is not None and len(missing) == len(INERTIAL) * robot.n)


def cylinder_prior(robot: Robot, total_mass: float) -> RobotPrior:
    """Cylinders of a total mass [kg] as ``model.stand_in.cylinders`` makes them.

    Raises:
        InputError: if the mass is not positive.
    """
    source = f"cylinders of one density, radius {cylinder_radius(robot):.3g} m, {total_mass:g} kg in all"
    return RobotPrior(cylinders(robot, total_mass), source)


BUDGET = 1.0
"""By which chi2 may rise above the constrained minimum."""
_MET = 1e-8
"""Of the budget: how exactly it is met."""
_ROUNDS = 60
_FAR = 3.0
"""By which the weight's logarithm changes at most in a round."""
_NEAR = 0.3
"""Up to this change a solution is a good start for the next; else the start is."""


@dataclass(frozen=True)
class PriorRobot(PossibleRobot):
    """The robot that can exist, data first, then a prior.

    Attributes:
        nearest: the base gauge: the nearest robot that can exist.
        prior: what the links were thought to be.
        budget: by which chi2 was allowed to rise above ``nearest.chi2_rise``.
        weight: of the entropic distance; infinite where the prior itself is within the budget.
        origins: who decides each standard parameter.
        distances: entropic distance of each link from its prior.
    """

    nearest: PossibleRobot = field(kw_only=True)
    prior: RobotPrior = field(kw_only=True)
    budget: float = field(kw_only=True)
    weight: float = field(kw_only=True)
    origins: dict[str, Origin] = field(kw_only=True)
    distances: tuple[float, ...] = field(kw_only=True)


def solve_constrained_prior(
    robot: Robot,
    base: BaseParameters,
    estimate: Estimate,
    prior: RobotPrior,
    budget: float = BUDGET,
    total_mass: MassBounds | None = None,
) -> PriorRobot:
    """The robot nearest to a prior among those that explain the data within a budget.

    Links can exist, and drives hold the rules of ``solve_constrained_base``; the distance is that of the links
    alone. chi2 goes by robust standard deviations where the estimate has them (``error_model``).

    Args:
        estimate: of all of them, in their order.
        prior: one body for each link.
        budget: by which chi2 may rise above the constrained minimum.
        total_mass: bounds of the mass of all links together, where known.

    Raises:
        InputError: if the estimate or the prior are not of this robot, or the budget is not positive.
        SolverError: for anything but a clean solve.
    """
    if len(prior.bodies) != robot.n:
        raise InputError(f"a prior of {len(prior.bodies)} links for the {robot.n} of {robot.name}: give one each")
    if not 0.0 < budget < np.inf:
        raise InputError(f"budget {budget:g} of the prior must be positive: 1 is one standard deviation")
    estimate = error_model(estimate)
    problem = RobotProgram.of(robot, base, estimate, total_mass)
    nearest = solve_robot_program(problem, base, estimate)
    z0 = np.zeros(len(problem.scale))  # the prior's links; drives are zero
    for link, body in zip(problem.links, prior.bodies, strict=True):
        z0[link] = body.vector / problem.scale[link]
    program = EntropicProgram(problem.program, pseudo_inertias(problem.program, z0))
    solution, weight, status = _prior_itself(problem, z0, nearest.chi2_rise + budget), np.inf, "prior"
    active: list[Active] = []
    if solution is None:
        start = program.start(_inside(problem, z0))
        weight, point = _within_budget(program, start, nearest.chi2_rise, budget)
        solution, status = point.z, "Solved"
        slack = problem.rules.A @ point.z + problem.rules.b
        held = zip(problem.rules.texts, point.multipliers.tolist(), slack, strict=True)
        active = [Active(text, price) for text, price, room in held if price > max(room, TOLERANCE)]
    z = problem.repaired(solution)
    return PriorRobot(
        **vars(problem.answer(base, estimate, z, active, status)),
        nearest=nearest,
        prior=prior,
        budget=budget,
        weight=weight,
        origins=origins(robot, base),
        distances=tuple(float(distance) for distance in program.distances(z)),
    )


def _prior_itself(problem: RobotProgram, z0: Array, limit: float) -> Array | None:
    """The prior's links with the drives that suit them best, if that is within the limit."""
    F, d, A, b, bodies = problem.program
    drives = [k for k in range(len(z0)) if k not in {place for link in problem.links for place in link}]
    shift = A @ z0 + b
    rows = np.abs(A[:, drives]).max(axis=1, initial=0.0) > 0.0
    if (shift[~rows] < -TOLERANCE).any():
        return None  # the prior breaks a bound of the mass
    z = z0.copy()
    if drives:
        part = ConeProgram(F[:, drives], d - F @ z0, A[np.ix_(rows, drives)], shift[rows], bodies[:0, :, drives])
        z[drives] = solve_cone(part, 1e3).z
        signed = list(problem.rules.signed)
        z[signed] = np.maximum(z[signed], 0.0)
    return z if float(np.sum((F @ z - d) ** 2)) <= limit else None


def _inside(problem: RobotProgram, z0: Array) -> Array:
    """A point strictly inside: the prior's links, scaled to the bounds of their mass, drives above zero.

    Raises:
        InputError: if the bounds of the mass leave no room.
    """
    z = z0.copy()
    places = [place for link in problem.links for place in link]
    masses = [k for k, text in enumerate(problem.rules.texts) if text.startswith("total mass")]
    A, b = problem.rules.A[masses] @ z0, problem.rules.b[masses]
    if masses and min(A + b) <= 0.0:
        ends = -b / A  # factors at which a bound is met
        factor = float(ends.mean()) if len(masses) == 2 else float(ends[0]) * (1.1 if A[0] > 0.0 else 0.9)
        if min(A * factor + b) <= 0.0:
            raise InputError("the bounds of the total mass leave no room: give low < high, high above 0 kg")
        z[places] *= factor
    z[list(problem.rules.signed)] = 1.0
    for j, k in problem.rules.shared:
        z[j] = max(z[j], 1.0 + z[k] * problem.scale[k] / problem.scale[j])
    return z


def _within_budget(
    program: EntropicProgram, start: EntropicPoint, least: float, budget: float
) -> tuple[float, EntropicPoint]:
    """Weight and point at which chi2 = least + budget; chi2 rises with the weight, from ``least`` at none.

    Newton's method on logarithms inside a bracket.
    """
    weight, low, high = 0.1 * budget, 0.0, np.inf
    point = start
    for _ in range(_ROUNDS):
        point = program.minimum(weight, point)
        rise = program.chi2(point.z) - least
        if abs(rise - budget) <= _MET * budget:
            return weight, point
        low, high = (weight, high) if rise < budget else (low, weight)
        slope = program.slope(weight, point)
        step = -np.log(rise / budget) * rise / slope if rise > 0.0 and slope > 0.0 else -_FAR
        next_weight = weight * float(np.exp(np.clip(step, -_FAR, _FAR)))
        if not low < next_weight < high:
            next_weight = float(np.sqrt(low * high)) if low > 0.0 else high * float(np.exp(-_FAR))
        point = point if abs(np.log(next_weight / weight)) < _NEAR else start
        weight = next_weight
    raise SolverError("no weight of the prior meets the budget", program.program)
