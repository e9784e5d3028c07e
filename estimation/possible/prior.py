"""Standard parameters of a robot that can exist: those nearest to a prior that the data allow.

Data speak only of base parameters; of all robots that explain them about as well, the one whose links are nearest
to a prior in entropic distance is one definite answer. The weight of the distance is chosen so that chi2 rises by a
stated budget above that of the nearest robot that can exist: the prior never costs more than that.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...common import Array, InputError
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.stand_in import MOVING, cylinder_radius, cylinders, missing_inertial
from ..fit.estimate import Estimate, error_model
from .cone import ConeProgram, Part, SolverError, cone_solver, solve_cone
from .constraints import PSEUDO_INERTIA, MassBounds
from .payload import TOLERANCE
from .robot import PossibleRobot, RobotProgram
from .whole_robot import Origin, origins

BUDGET = 1.0
"""Rise of chi2 that is allowed above the constrained minimum."""
_TRIED = ((0.1, 1e-10), (1.0, 1e-10), (10.0, 1e-10), (1e3, 1e-10), (0.1, 1e-8), (10.0, 1e-8), (1e3, 1e-8))
"""Largest entry of R, and the solver's tolerance, which is fine: near the nearest robot distances hardly change."""


@dataclass(frozen=True)
class RobotPrior:
    """Prior of a robot: links as they are thought to be, each in its own frame, and the text on where from."""

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


def robot_prior(robot: Robot, total_mass: float | None = None) -> RobotPrior:
    """Make the prior of a robot: the inertial parameters of its file, or cylinders of a total mass [kg].

    Without a stated mass, and where the file has no parameters, it is the fraction ``MOVING`` of the maker's mass
    of the whole arm, for that holds the base.

    Raises:
        InputError: if none of them is there, the file holds only some of the parameters, or the mass is not
            positive.
    """
    names = [f"{kind}{link}" for link in range(1, robot.n + 1) for kind in INERTIAL]
    missing, derived = missing_inertial(robot), ""
    if total_mass is None and len(missing) == len(names):
        if robot.mass is None:
            raise InputError(
                f"robot {robot.name!r} has no inertial parameters in its file to serve as prior: give them under "
                "[parameters] of a robot file of your own, or the total mass of its links (--prior-mass KG)"
            )
        total_mass, doubt = MOVING * robot.mass, robot.assumed("mass").get("mass", "")
        derived = f": {100.0 * MOVING:g} % of the maker's {robot.mass:g} kg, which holds the base"
        derived += f" (assumed: {doubt})" if doubt else ""
    if total_mass is not None:
        source = (
            f"cylinders of one density, radius {cylinder_radius(robot):.3g} m, {total_mass:g} kg in all{derived}"
        )
        return RobotPrior(cylinders(robot, total_mass), source)
    if missing:
        raise InputError(
            f"robot {robot.name!r}: {', '.join(missing[:6])} missing in [parameters]: a prior needs the ten of "
            "every link"
        )
    vectors = np.array([robot.parameters[name] for name in names]).reshape(robot.n, 10)
    return RobotPrior(tuple(map(InertialParameters, vectors)), f"the robot file of {robot.name}")


def has_prior(robot: Robot) -> bool:
    """True if the robot's own file gives ``robot_prior`` something to start from."""
    missing = missing_inertial(robot)
    return not missing or (robot.mass is not None and len(missing) == len(INERTIAL) * robot.n)


@dataclass(frozen=True, eq=False, repr=False)
class PriorRobot(PossibleRobot):
    """Robot that can exist, data first, then a prior."""

    nearest: PossibleRobot = field(kw_only=True)  # the base gauge: the nearest robot that can exist
    prior: RobotPrior = field(kw_only=True)
    budget: float = field(kw_only=True)  # by which chi2 was allowed to rise above ``nearest.chi2_rise``
    weight: float = field(kw_only=True)  # of the entropic distance; infinite if the prior is within the budget
    origins: dict[str, Origin] = field(kw_only=True)  # who decides each standard parameter
    distances: tuple[float, ...] = field(kw_only=True)  # entropic distance of each link from its prior


def solve_constrained_prior(
    robot: Robot,
    base: BaseParameters,
    estimate: Estimate,
    prior: RobotPrior,
    budget: float = BUDGET,
    total_mass: MassBounds | None = None,
) -> PriorRobot:
    """Find the robot nearest to a prior among those that explain the data within a budget.

    Links can exist, and drives hold the rules of ``solve_constrained_base``, as which it takes its arguments; the
    distance is that of the links alone. chi2 may rise by ``budget`` above the constrained minimum.

    Raises:
        InputError: if the estimate or the prior are not of this robot, or the budget is not positive.
        SolverError: for anything but a clean solve.
    """
    if len(prior.bodies) != robot.n:
        raise InputError(f"a prior of {len(prior.bodies)} links for the {robot.n} of {robot.name}: give one each")
    if not 0.0 < budget < np.inf:
        raise InputError(f"budget {budget:g} of the prior must be positive: 1 is one standard deviation")
    problem = RobotProgram.of(robot, base, error_model(estimate), total_mass)
    nearest = problem.nearest()
    z0 = np.zeros(len(problem.scale))  # the prior's links; drives are zero
    z0[problem.links] = [body.vector for body in prior.bodies] / problem.scale[problem.links]
    expected = _pseudo_inertias(problem.program, z0)
    limit, possible = nearest.chi2_rise + budget, np.array(list(nearest.parameters.values())) / problem.scale
    solution, weight, prices, status = _prior_itself(problem, z0, limit), np.inf, np.zeros(0), "prior"
    if solution is None:
        (solution, weight, prices), status = _nearest(problem.program, expected, possible, np.sqrt(limit)), "Solved"
    z = problem.repaired(solution)
    ratio = np.linalg.solve(expected, _pseudo_inertias(problem.program, z))
    distances = np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0
    return PriorRobot(
        **vars(problem.answer(z, status, prices)),
        nearest=nearest,
        prior=prior,
        budget=budget,
        weight=weight,
        origins=origins(robot, base),
        distances=tuple(distances.tolist()),
    )


def _prior_itself(problem: RobotProgram, z0: Array, limit: float) -> Array | None:
    """Take the prior's links with the drives that suit them best, if that is within the limit."""
    F, d, A, _, bodies = problem.program
    drives, rows = np.setdiff1d(np.arange(len(z0)), problem.links), len(problem.signed) + len(problem.shared)
    room = problem.program.slack(z0)
    if (room[rows:] < -TOLERANCE).any():
        return None  # the prior breaks a bound of the mass
    z = z0.copy()
    if len(drives):
        part = ConeProgram(F[:, drives], d - F @ z0, A[:rows, drives], room[:rows], bodies[:0, :, drives])
        z[drives] = solve_cone(part, [(1e3, np.inf)]).z
        z[problem.signed] = np.maximum(z[problem.signed], 0.0)
    return z if float(np.sum((F @ z - d) ** 2)) <= limit else None


def _nearest(program: ConeProgram, prior: Array, possible: Array, radius: float) -> tuple[Array, float, Array]:
    """Find z of least entropic distance with ||R z - d|| <= radius, the distance's weight, multipliers of the rows.

    D(P || P0) = tr P' - log det P' - 4 with P' = L^-1 P L'^-1 and P0 = L L' is the log-det divergence of
    pseudo-inertias (Lee, Wensing and Park, 2020); it keeps every P positive definite and does not change with
    frames or units. log det P' is the largest sum of log Z_ii of a lower triangle Z for which [P' Z; Z' diag(Z)] is
    positive semidefinite. The z also minimises ||R z - d||^2 + weight sum D, whose multipliers are given.

    ``prior``: P0 of each body, p x 4 x 4, in the program's scaled units; ``possible``: a z that holds all.
    """
    (k, n), r, p = program.R.shape, len(program.A), len(program.bodies)
    root = np.linalg.inv(np.linalg.cholesky(prior))
    own = np.einsum("pij,kjl,pml,pkn->pimn", root, PSEUDO_INERTIA, root, program.bodies, optimize=True)
    # Unknown are z - possible, the ten of each Z, row by row, and the logarithms of their diagonals; what is known
    # is the last column.
    Z, logs = n + np.arange(10 * p).reshape(p, 10), n + 10 * p + np.arange(4 * p).reshape(p, 4)
    (rows, columns), blocks = np.tril_indices(4), np.zeros((p, 8, 8, n + 14 * p + 1))
    exponentials = np.zeros((p, 4, 3, n + 14 * p + 1))  # log, 1 and Z_ii of each diagonal entry
    blocks[:, :4, :4, :n], blocks[:, :4, :4, -1], exponentials[:, :, 1, -1] = own, own @ possible, 1.0
    for j in range(p):
        blocks[j, rows, 4 + columns, Z[j]] = 1.0
        for i, diagonal in enumerate(Z[j, rows == columns]):
            blocks[j, 4 + i, 4 + i, diagonal] = exponentials[j, i, 2, diagonal] = 1.0
            exponentials[j, i, 0, logs[j, i]] = 1.0
    upper = [(i, j) for j in range(8) for i in range(j + 1)]
    triangles = np.stack([(1.0 if i == j else np.sqrt(2.0)) * blocks[:, i, j] for i, j in upper], axis=1)
    rules, norm, left = (
        np.zeros((r, n + 14 * p + 1)),
        np.zeros((k + 1, n + 14 * p + 1)),
        program.R @ possible - program.d,
    )
    rules[:, :n], rules[:, -1], norm[0, -1] = program.A, program.slack(possible), radius
    norm[1:, :n], norm[1:, -1] = program.R, left
    links: list[Part] = [("PSDTriangle", body) for body in triangles]
    links += [("Exponential", rows) for rows in exponentials.reshape(4 * p, 3, -1)]
    cost = np.concatenate([np.einsum("piin->n", own), np.zeros(10 * p), -np.ones(4 * p)])
    ends = dict[str, tuple[Any, float]]()
    for largest, tolerance in _TRIED:
        size = float(np.abs(program.R).max()) / largest
        parts: list[Part] = [("Nonnegative", rules), ("SecondOrder", norm / size), *links]
        solution = cone_solver(cost, parts, tolerance).solve()
        ends[str(solution.status)] = solution, size
        if "Solved" in ends:
            break
    # With exact data the search may end next to where it should; the budget is kept there as well.
    solution, size = ends.get("Solved") or ends.get("AlmostSolved") or (None, 1.0)
    if solution is None:
        raise SolverError(next(iter(ends)))
    change, dual = np.asarray(solution.x)[:n], np.asarray(solution.z)
    # As far towards the solution as |left + part moved| = radius allows.
    moved = program.R @ change
    a, b, c = moved @ moved, moved @ left, left @ left - radius**2
    part = min(1.0, float((np.sqrt(b * b - a * c) - b) / a))
    weight = 2.0 * radius * size / float(dual[r])
    return possible + part * change, weight, weight * dual[:r]


def _pseudo_inertias(program: ConeProgram, z: Array) -> Array:
    """Pseudo-inertia P of each body of a program, p x 4 x 4."""
    return np.asarray(np.tensordot(program.bodies @ z, PSEUDO_INERTIA, 1))
