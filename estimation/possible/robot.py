"""Robots that can exist: the base parameters of the nearest one, and standard parameters by a prior.

Standard parameters are the variables, the data speak only through base parameters chi = G x: the nearest chi for
which *some* robot exists whose every link can exist and whose drives neither push nor have negative inertia. The
standard parameters themselves stay undetermined (26 directions on the RX90). Of all robots that explain the data
about as well, the one whose links are nearest to a prior in entropic distance is one definite answer. The weight of
the distance is chosen so that chi2 rises by a stated budget above that of the nearest robot that can exist.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from ...common import Array, Indices, InputError, decomposed, one_thread
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.base import sum_text
from ...model.drives import parameter_kind
from ...model.stand_in import MOVING, cylinder_radius, cylinders, missing_inertial
from ..fit.estimate import Estimate, error_model
from .constraints import PSEUDO_INERTIA, ConeProgram, MassBounds, Part, SolverError, cone_solver, solve_cone, upper
from .payload import NOISE_FLOOR, TOLERANCE, Active, Possible, holding, lifted, whitening

_NOT_NEGATIVE = ("IA", "FV", "FS", "FL", "FVM", "FSM")
POWERS = {**dict.fromkeys(INERTIAL[:6], 2), **dict.fromkeys(INERTIAL[6:9], 1), "M": 0, "IA": 2}
"""Power of a length in the unit of each kind."""
_NEXT_TO_NOTHING = 1e-3  # of the largest multiplier: smaller ones belong to directions that the data do not see
_WAYS = ((1e3, np.inf), (1e3, 1e3), (1e2, 1e3), (10.0, 1e3), (10.0, np.inf), (1.0, np.inf))
"""Largest entry of R, for the norm of exact data is zero, at the tip of its cone; radius that z may not leave.

No torque may show some direction, and no finite robot attain the least value: the program is closed then, at a
thousand times the size of each parameter. Where the search stops short of its end, a smaller R has it end.
"""
_ABOVE = 1.0 + 4.0 * np.finfo(float).eps  # factor that keeps a larger number above a smaller one in other scales
_UNSEEN = 1e-3  # standard deviations by which a repair may change a number


def typical_length(robot: Robot) -> float:
    """Half the longest distance between two joints [m]; 1 where all axes meet."""
    return max(max(abs(joint.d), abs(joint.r)) for joint in robot.joints) / 2.0 or 1.0


def link_indices(robot: Robot, standard: Sequence[str]) -> Indices:
    """Indices of each link's ten, n x 10."""
    return np.array([[standard.index(f"{kind}{link}") for kind in INERTIAL] for link in range(1, robot.n + 1)])


def drive_rules(robot: Robot, standard: Sequence[str], scale: Array) -> tuple[Array, tuple[str, ...]]:
    """Rules A z >= 0 of standard parameters in units of ``scale``: drives neither push nor have negative inertia.

    Friction and rotor inertias are not negative. Of what coupled drives share, IA_j = K_j^2 JA_j + K_k^2 JA_k is at
    least IA_k = K_k^2 JA_k, and FV_j and FV_k hold the viscous friction FVM_k of rotor k besides the joint's own.

    Returns:
        A, r x N_s, with one positive entry in each row, of 1; and its rows as text.
    """
    pairs: list[tuple[str, str]] = []
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        pairs = [(f"IA{j}", f"IA{k}"), (f"FV{j}", f"FVM{k}"), (f"FV{k}", f"FVM{k}")]
    shared = [(standard.index(whole), standard.index(part)) for whole, part in pairs]
    signed = [k for k, name in enumerate(standard) if parameter_kind(name) in _NOT_NEGATIVE]
    units = np.eye(len(standard))
    rows = [*units[signed], *(units[j] - scale[k] / scale[j] * units[k] for j, k in shared)]
    texts = *(f"{standard[k]} >= 0" for k in signed), *(f"{whole} >= {part}" for whole, part in pairs)
    return np.array(rows).reshape(-1, len(standard)), texts


@dataclass(frozen=True, eq=False, repr=False)
class PossibleRobot(Possible):
    """Base parameters of a robot whose links can exist, and one such robot."""

    # Standard parameters of that robot by name. In the base gauge it is one of many with the same base parameters
    # and nothing in it is identified; with a prior, what is not identified is its choice.
    parameters: dict[str, float] = field(kw_only=True)
    unidentifiable: tuple[str, ...] = field(kw_only=True)  # changes that change no torque ("M1", "IA1 - ZZ1")


class RobotProgram(NamedTuple):
    """Problem in z = standard parameters / ``scale``."""

    base: BaseParameters
    estimate: Estimate
    scale: Array  # (N_s,)
    R: Array  # whitens base parameters, N_b x N_b
    program: ConeProgram  # minimises ||R (G x - chi)||, its rows ``drive_rules``, then bounds of the total mass
    demands: list[Active]  # of the program's rows, then of its bodies
    rules: int  # number of the rows that are ``drive_rules``
    links: Indices  # indices of each link's ten, n x 10

    @staticmethod
    def of(robot: Robot, base: BaseParameters, estimate: Estimate, total_mass: MassBounds | None) -> "RobotProgram":
        """Scale an estimate of all base parameters; raises InputError if it is not one."""
        if estimate.names != base.columns:
            fault = f"the estimate is not of the {len(base.columns)} base parameters"
            raise InputError(f"{fault}: identify the robot anew")
        estimate = error_model(estimate)
        # One mass and one length for all links, from the robot's own numbers.
        length, kinds = typical_length(robot), [parameter_kind(name) for name in estimate.names]
        own = zip(kinds, estimate.values.tolist(), strict=True)
        masses = np.array([abs(value) / length ** POWERS[kind] for kind, value in own if kind in INERTIAL])
        # Data without noise show many a parameter as zero: they say nothing of the robot's size.
        masses = masses[masses > 1e-6 * masses.max(initial=0.0)]
        mass = float(np.median(masses)) if len(masses) else 1.0
        inertial = {kind: mass * length**power for kind, power in POWERS.items()}
        sizes = dict(zip(estimate.names, np.maximum(np.abs(estimate.values), estimate.sigma), strict=True))
        scale = np.array([inertial.get(parameter_kind(name), sizes.get(name, 1.0)) for name in base.standard])
        G = base.grouping * scale
        R = whitening(estimate.covariance, estimate.names, NOISE_FLOOR * np.abs(G).max(axis=1))
        links = link_indices(robot, base.standard)
        A, texts = drive_rules(robot, base.standard, scale)
        b, rules = np.zeros(len(A)), len(A)
        if total_mass is not None:
            units, bounds = total_mass.rows
            total = np.zeros((len(units), len(scale)))
            total[:, links[:, 9]] = units[:, 9:]
            A, b = np.vstack([A, total]), np.append(b, bounds / mass)
            texts += tuple(
                f"total mass {'>=' if sign > 0.0 else '<='} {-sign * bound + 0.0:g} kg"
                for sign, bound in zip(units[:, 9], bounds, strict=True)
            )
        texts += tuple(f"link {j} can exist" for j in range(1, robot.n + 1))
        program = ConeProgram(R @ G, R @ estimate.values, A, b, np.eye(len(scale))[links])
        return RobotProgram(base, estimate, scale, R, program, list(map(Active, texts)), rules, links)

    def repaired(self, z: Array) -> Array:
        """Move z by rounding, so that no link has a negative eigenvalue and no drive a negative number."""
        result = z.copy()
        for link in self.links:
            result[link] = lifted(z[link], self.scale[link])
        if (self.program.A @ result + self.program.b < -TOLERANCE).any():
            raise SolverError("friction, rotor inertia or mass missed by more than rounding")
        for rule in self.program.A[: self.rules]:
            whole = int(rule.argmax())
            result[whole] = max(result[whole], 0.0 - _ABOVE * float(result @ np.minimum(rule, 0.0)))
        if float(np.linalg.norm(self.program.R @ (result - z))) > _UNSEEN:
            raise SolverError("constraints missed by more than the data's accuracy")
        return result

    def answer(self, z: Array, status: str, prices: Array, floor: float, slope: float) -> PossibleRobot:
        """Make the robot that z stands for; ``prices``, ``floor``, ``slope``: as of ``holding``."""
        x = z * self.scale
        values = self.base.grouping @ x
        return PossibleRobot(
            free=self.estimate,
            values=values,
            chi2_rise=float(np.sum((self.R @ (values - self.estimate.values)) ** 2)),
            active=holding(self.program, z, prices, self.demands, floor, slope),
            bodies=tuple(map(InertialParameters, x[self.links])),
            status=status,
            parameters=dict(zip(self.base.standard, x.tolist(), strict=True)),
            unidentifiable=hidden_directions(self.base),
        )


@one_thread()
def solve_constrained_base(
    robot: Robot, base: BaseParameters, estimate: Estimate, total_mass: MassBounds | None = None
) -> PossibleRobot:
    """Find the nearest base parameters of a robot that can exist.

    Every link can exist, friction and rotor inertias are not negative, and coupled drives share some. Nearest
    by robust standard deviations where the estimate has them (``error_model``).

    ``estimate``: of all of them, in their order; ``total_mass``: bounds of the mass of all links, where known.

    Raises:
        InputError: if the estimate is not of these parameters, or its covariance does not determine them.
        SolverError: for anything but a clean solve.
    """
    problem = RobotProgram.of(robot, base, estimate, total_mass)
    z, prices = solve_cone(problem.program, _WAYS)
    slope = 2.0 * float(np.linalg.norm(problem.program.R @ z - problem.program.d))  # d chi2 = 2 norm d norm
    floor = max(_NEXT_TO_NOTHING * float(prices.max()), TOLERANCE)
    return problem.answer(problem.repaired(z), "Solved", prices, floor, slope)


def build_constrained_base(
    robot: Robot, base: BaseParameters, estimate: Estimate, total_mass: MassBounds | None = None
) -> tuple[Any, dict[str, Any], list[Any]]:
    """Build the problem of ``solve_constrained_base`` in CVXPY, not solved yet, as ``build_constrained`` does.

    Returns:
        The ``cvxpy.Problem``; the standard parameters by name and the pseudo-inertia of each link, 4 x 4, all
        expressions in SI units. What no torque shows of them is left to your own terms.

    Raises:
        InputError: if the estimate is not of these parameters, or its covariance does not determine them.
    """
    made = RobotProgram.of(robot, base, estimate, total_mass)
    problem, x, inertias = made.program.posed(made.scale)
    return problem, {name: x[k] for k, name in enumerate(base.standard)}, inertias


def hidden_directions(base: BaseParameters) -> tuple[str, ...]:
    """Describe changes of the standard parameters that change no torque, N_s - N_b texts: "YY2 + XX2", "M1"."""
    rest = [k for k in range(len(base.standard)) if k not in base.chosen]
    # One more of parameter k is the same as less of those that it is grouped into.
    return tuple(sum_text(base.standard[k], base.columns, -base.grouping[:, k]) for k in rest)


_ROUNDING = 1e-9
_NOTHING = 1e-12  # fraction of a gradient's largest entry below which it is a rotation's rounding


class Origin(NamedTuple):
    """Origin of a number of the robot: who decides it.

    ``base``: the base parameters it is part of; ``share``: squared length of the part of its unit gradient in the
    row space of the grouping G, in units of one mass and one length for all links: 1 if they alone determine it.
    """

    base: tuple[str, ...] = ()
    share: float = 0.0

    @property
    def kind(self) -> Literal["identified", "combination", "prior"]:
        """Kind: the data determine it, or only combinations of it with others, or no motion shows it."""
        return "prior" if not self.base else "identified" if self.share == 1.0 else "combination"

    def decided_by(self) -> str:
        """Label of every table, document and export: "data", "prior", or "prior within MX2R, ZZ2R"."""
        return {"identified": "data", "prior": "prior"}.get(self.kind, f"prior within {', '.join(self.base)}")


def origins(robot: Robot, base: BaseParameters, gradients: Array | None = None) -> list[Origin]:
    """Find origins of numbers by their gradients by the standard parameters, N_s x m; by default of these."""
    length, gradients = typical_length(robot), np.eye(len(base.standard)) if gradients is None else gradients
    units = np.array([length ** POWERS.get(parameter_kind(name), 0) for name in base.standard])
    rows = decomposed((base.grouping * units).T).range.T
    scaled = gradients * units[:, None]
    scaled[np.abs(scaled) < _NOTHING * np.abs(scaled).max(axis=0)] = 0.0
    shares = np.sum((rows @ scaled) ** 2, axis=0) / np.sum(scaled**2, axis=0)
    shares = np.where(shares > 1.0 - _ROUNDING, 1.0, np.maximum(shares, 0.0))
    parts = (base.grouping != 0.0) @ (scaled != 0.0)
    names = [tuple(base.names[i] for i in np.flatnonzero(part)) for part in parts.T]
    return [Origin(own, share if own else 0.0) for own, share in zip(names, shares.tolist(), strict=True)]


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
        for link, body in enumerate(self.bodies, start=1):
            least = body.min_pseudo_inertia_eigenvalue
            if body.mass <= 0.0 or least <= 0.0:
                own = f"prior of link {link} ({self.source}): smallest eigenvalue of its pseudo-inertia {least:.2g}"
                raise InputError(f"{own}: give a body with mass and some extent")


def robot_prior(robot: Robot, total_mass: float | None = None) -> RobotPrior:
    """Make the prior of a robot: the inertial parameters of its file, or cylinders of a total mass.

    Without either, the mass is the fraction ``MOVING`` of the maker's for the whole arm, for that holds the base.

    Args:
        total_mass: of all moving links [kg]; asks for the cylinders even if the file has parameters.

    Raises:
        InputError: if none is there, the file holds only some of the parameters, or the mass is not positive.
    """
    names = [f"{kind}{link}" for link in range(1, robot.n + 1) for kind in INERTIAL]
    missing, derived = missing_inertial(robot), ""
    if total_mass is None and len(missing) == len(names):
        if robot.mass is None:
            advice = "[parameters] of a robot file of your own, or the total mass of its links (--prior-mass KG)"
            without = f"robot {robot.name!r} has no inertial parameters in its file to serve as prior"
            raise InputError(f"{without}: give them under {advice}")
        total_mass, doubt = MOVING * robot.mass, robot.assumed("mass").get("mass", "")
        derived = f": {100.0 * MOVING:g} % of the maker's {robot.mass:g} kg, which holds the base"
        derived += f" (assumed: {doubt})" if doubt else ""
    if total_mass is not None:
        each = f"cylinders of one density, radius {cylinder_radius(robot):.3g} m"
        return RobotPrior(cylinders(robot, total_mass), f"{each}, {total_mass:g} kg in all{derived}")
    if missing:
        absent = f"robot {robot.name!r}: {', '.join(missing[:6])} missing in [parameters]"
        raise InputError(f"{absent}: a prior needs the ten of every link")
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
    nearest = solve_constrained_base(robot, base, estimate, total_mass)
    problem = RobotProgram.of(robot, base, estimate, total_mass)
    z0 = np.zeros(len(problem.scale))  # the prior's links; drives are zero
    z0[problem.links] = [body.vector for body in prior.bodies] / problem.scale[problem.links]
    expected = np.tensordot(problem.program.bodies @ z0, PSEUDO_INERTIA, 1)
    limit, possible = nearest.chi2_rise + budget, np.array(list(nearest.parameters.values())) / problem.scale
    # The prior's links with the drives that suit them best will do if they hold the mass's bounds and the limit.
    F, d, A, b, bodies = problem.program
    room, rows = A @ z0 + b, problem.rules
    drives, solution = np.setdiff1d(np.arange(len(z0)), problem.links), z0.copy()
    within = bool((room[rows:] >= -TOLERANCE).all())
    if within and len(drives):
        part = ConeProgram(F[:, drives], d - F @ z0, A[:rows, drives], room[:rows], bodies[:0, :, drives])
        solution[drives] = solve_cone(part, [(1e3, np.inf)])[0]
    weight, prices, status = np.inf, np.zeros(0), "prior"
    if not within or float(np.sum((F @ solution - d) ** 2)) > limit:
        (solution, weight, prices), status = _nearest(problem.program, expected, possible, np.sqrt(limit)), "Solved"
    z = problem.repaired(solution)
    ratio = np.linalg.solve(expected, np.tensordot(problem.program.bodies @ z, PSEUDO_INERTIA, 1))
    distances = np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0
    return PriorRobot(
        **vars(problem.answer(z, status, prices, TOLERANCE, 1.0)),
        nearest=nearest,
        prior=prior,
        budget=budget,
        weight=weight,
        origins=dict(zip(base.standard, origins(robot, base), strict=True)),
        distances=tuple(distances.tolist()),
    )


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
    own = np.einsum("pij,kjl,pml,pkn->pnim", root, PSEUDO_INERTIA, root, program.bodies, optimize=True)
    # Unknown are z - possible, the ten of each Z, row by row, and the logarithms of their diagonals; 1 comes last.
    Z, logs = n + np.arange(10 * p).reshape(p, 10), n + 10 * p + np.arange(4 * p).reshape(p, 4)
    (rows, columns), width = np.tril_indices(4), n + 14 * p + 1
    each, i, diagonal = np.arange(p)[:, None], np.arange(4), Z[:, rows == columns]
    blocks, exponentials = np.zeros((p, width, 8, 8)), np.zeros((p, 4, 3, width))
    blocks[:, :n, :4, :4], blocks[:, -1, :4, :4] = own, np.tensordot(own, possible, (1, 0))
    blocks[each, Z, rows, 4 + columns] = blocks[each, diagonal, 4 + i, 4 + i] = 1.0
    # Of each diagonal entry the logarithm, 1 and Z_ii.
    exponentials[each, i, 0, logs] = exponentials[:, :, 1, -1] = exponentials[each, i, 2, diagonal] = 1.0
    links: list[Part] = [("PSDTriangle", body.T) for body in upper(blocks)]
    links += [("Exponential", rows) for rows in exponentials.reshape(4 * p, 3, -1)]
    cost = np.concatenate([np.einsum("pnii->n", own), np.zeros(10 * p), -np.ones(4 * p)])
    (rules, norm), left = (np.zeros((count, width)) for count in (r, k + 1)), program.R @ possible - program.d
    rules[:, :n], rules[:, -1], norm[0, -1] = program.A, program.A @ possible + program.b, radius
    norm[1:, :n], norm[1:, -1] = program.R, left
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
