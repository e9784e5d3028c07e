"""Whole robots: standard parameters by a prior, and a number for everything that a simulator asks for.

Data decide a number, a part of it, or nothing. Every table, document and export takes its labels from here.

The standard parameters of a robot that can exist stay undetermined (26 directions on the RX90). Of all robots that
explain the data about as well, the one whose links are nearest to a prior in entropic distance is one definite
answer. The weight of the distance is chosen so that chi2 rises by a stated budget above that of the nearest robot
that can exist.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np

from ...common import Array, InputError, decomposed
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.drives import parameter_kind
from ...model.dynamics import gravity
from ...model.frames import bodies_in_link_frames
from ...model.friction import PAPER
from ...model.inertia import gradients
from ...model.stand_in import MOVING, POSES, cylinder_radius, cylinders, missing_inertial, poses_in_range
from ..fit.estimate import Estimate, error_model
from .constraints import PSEUDO_INERTIA, ConeProgram, MassBounds, Part, SolverError, cone_solver, solve_cone, upper
from .payload import TOLERANCE
from .robot import POWERS, PossibleRobot, RobotProgram, solve_constrained_base, typical_length

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
    found = problem.answer(solution, status, prices, TOLERANCE, 1.0)
    links = np.array([body.vector for body in found.bodies]) / problem.scale[problem.links]
    ratio = np.linalg.solve(expected, np.tensordot(links, PSEUDO_INERTIA, 1))
    distances = np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0
    return PriorRobot(
        **vars(found),
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
    pseudo-inertias (Lee, Wensing and Park, 2020), the same in all frames and units. log det P' is the largest sum
    of log Z_ii of a lower triangle Z for which [P' Z; Z' diag(Z)] is positive semidefinite. The z also minimises
    ||R z - d||^2 + weight sum D, whose multipliers are given.

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


BODY_NUMBERS = ("mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Numbers of a body: mass [kg], centre of mass [m], inertia there [kg m^2], in the link's frame."""
DRIVE_NUMBERS = {"armature": "IA", "damping": "FV", "friction": "FS", "offset": "OFF"}
"""Numbers of a drive, and its parameter: kg m^2 or kg, N·m·s/rad or N·s/m, N·m or N, N·m or N."""
SIGNED = ("armature", "damping", "friction")  # numbers of a drive that are not negative


class Labelled(NamedTuple):
    """Number with its origin, and the data's standard deviation and 95 % interval where they determine it.

    ``bound``: it stands at the bound of what can exist, which data alone would pass.
    """

    value: float
    origin: Origin = Origin()
    sigma: float | None = None
    interval: tuple[float, float] | None = None
    bound: bool = False

    @property
    def mark(self) -> Literal["data", "rule", "prior"]:
        """Origin in one word; the part that data have in a prior's number is ``origin.share``."""
        return "rule" if self.bound else "data" if self.origin.kind == "identified" else "prior"


class LinkNumbers(NamedTuple):
    """Numbers of one link."""

    link: str
    body: InertialParameters  # in the link's own frame
    numbers: dict[str, Labelled]  # its ``BODY_NUMBERS`` (mass alone if it has none)
    parameters: dict[str, Labelled]  # its standard ones and its drive's, in the modified DH frame

    @property
    def moments(self) -> Array:
        """Principal moments of inertia [kg m^2], shape (3,), rising."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com) if self.body.mass else np.zeros(3), dtype=float)

    @property
    def margin(self) -> float:
        """Distance of the moments from breaking A + B >= C, over their sum; 0 for a body at the edge."""
        a, b, c = self.moments.tolist()
        return (a + b - c) / (a + b + c) if c > 0.0 else 0.0


@dataclass(frozen=True)
class WholeRobot:
    """A robot with a number for everything that a simulator asks for."""

    robot: Robot
    links: tuple[LinkNumbers, ...]
    drives: tuple[dict[str, Labelled], ...]  # of each joint, what is known by the keys of ``DRIVE_NUMBERS``
    coupled: dict[str, Labelled]  # of the drive that turns with both joints of a coupling; empty without one
    apart: tuple[dict[str, Labelled], ...]  # as ``drives`` for who cannot couple joints: the diagonal of both
    groupings: tuple[str, ...]  # the base parameters, in text; none where nothing was identified
    source: str
    prior: str  # what decides where data do not

    @property
    def mass(self) -> float:
        """Mass of the moving links together [kg]."""
        return sum(link.body.mass for link in self.links)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints: of the robot's own file, else the maker's, else joint1 to jointn."""
        robot = self.robot
        if robot.links is not None:
            return robot.links.joints
        return robot.joint_names[0] if robot.joint_names else tuple(f"joint{j + 1}" for j in range(robot.n))

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """Name of the base, then of the links."""
        links = self.robot.links
        return ("base_link" if links is None else links.base, *(link.link for link in self.links))

    def signed(self, chosen: Callable[[Labelled], bool]) -> tuple[str, ...]:
        """Names of the chosen numbers of drives among those that are not negative: ``joint1 damping``."""
        drives = (*zip(self.joint_names, self.drives, strict=True), ("coupled drive", self.coupled))
        there = ((name, quantity, drive) for name, drive in drives for quantity in SIGNED if quantity in drive)
        return tuple(f"{name} {quantity}" for name, quantity, drive in there if chosen(drive[quantity]))

    def heavier_than_the_arm(self) -> tuple[str, ...]:
        """Links that weigh more than the maker says the whole arm does, in text."""
        most = self.robot.mass
        return tuple(
            f"{link.link} would weigh {link.body.mass:.4g} kg, the whole arm weighs {most:g} kg"
            for link in self.links
            if most is not None and link.body.mass > most
        )


_AT_BOUND = 1e-3
"""Fraction of its standard deviation, or of the largest such number: a smaller one stands at its bound, zero."""
Slopes = dict[str, float]  # derivatives of a number by standard parameters


def _add_plain_friction(drives: Sequence[dict[str, Slopes]], robot: Robot, parameters: Mapping[str, float]) -> None:
    """Add to each drive the Coulomb and viscous friction nearest to each other term, per unit of its parameter.

    Under the mean size of the links' weight, over speeds up to the joint's limit (1 without one), laws of one's own
    in mid-range.
    """
    chi = np.array([parameters.get(name, 0.0) for name in robot.standard])[:, None]
    weights = np.array(gravity(robot).map(POSES)(poses_in_range(robot, POSES).T, np.tile(chi, POSES)))
    every = zip(drives, robot.joints, np.abs(weights).mean(axis=1), strict=True)
    for j, (drive, joint, load) in enumerate(every, start=1):
        top = joint.limits.speed if np.isfinite(joint.limits.speed) else 1.0
        speed, one = np.linspace(0.02, 1.0, 50) * top, np.ones(50)
        middle = one * np.mean(np.clip(joint.limits.position, -10.0, 10.0))
        for term in robot.drives.friction:
            if term not in PAPER and (name := f"{term.kind}{j}") in parameters:
                law = term.value(speed, one, middle, load * one)
                dry, viscous = decomposed(np.column_stack([one, speed])).solution(law).tolist()
                drive.setdefault("friction", {})[name] = dry
                drive.setdefault("damping", {})[name] = viscous


def whole_robot(
    robot: Robot,
    parameters: Mapping[str, float],
    source: str,
    base: BaseParameters | None = None,
    estimate: Estimate | None = None,
    prior: str = "the robot's own description",
) -> WholeRobot:
    """Collect all numbers of a robot, labelled.

    A body's number, such as the centre of mass h/M, is no standard parameter: its gradient tells whether small
    changes that no motion shows move it. Standard deviations are those of the identified base parameters.

    Args:
        parameters: its standard parameters by name, the ten of every link; of its drives what is known.
        source: where they come from, in text.
        base: its base parameters, where they were identified.
        estimate: of all of them; without it all numbers are the prior's.
        prior: what decides where data do not, in text.

    Raises:
        InputError: if parameters of a link are missing.
    """
    bodies, links = bodies_in_link_frames(robot, parameters), list[LinkNumbers]()

    def labels(numbers: Sequence[float], slopes: Sequence[Slopes]) -> list[Labelled]:
        """Label numbers by their gradients, standard deviations where the data determine them."""
        if base is None or estimate is None:
            return [Labelled(number) for number in numbers]
        errors, by_standard = error_model(estimate), np.zeros((len(base.standard), len(numbers)))
        for column, row in enumerate(slopes):
            by_standard[[base.standard.index(name) for name in row], column] = list(row.values())
        by_base = np.asarray(np.linalg.lstsq(base.grouping.T, by_standard, rcond=None)[0].T, dtype=float)
        # To first order the free estimate's own number, for what can exist may be moved away from it.
        free = errors.mapped(by_base, tuple(map(str, range(len(numbers)))))
        moved = by_base @ (errors.values - base.value(parameters)) - free.values
        ends = (np.asarray(numbers) + moved)[:, None] + free.interval95
        every = zip(numbers, origins(robot, base, by_standard), free.sigma.tolist(), ends.tolist(), strict=True)
        return [
            Labelled(number, origin, *((sigma, tuple(interval)) if origin.share == 1.0 else ()))
            for number, origin, sigma, interval in every
        ]

    by_parameter = labels(list(parameters.values()), [{name: 1.0} for name in parameters])
    own, every = dict(zip(parameters, by_parameter, strict=True)), [*product(range(1, robot.n + 1), INERTIAL)]
    # Per link, the ten in its own frame by the ten in the modified DH frame, 10 x 10.
    units = ({f"{kind}{j}": float(kind == unit) for j, kind in every} for unit in INERTIAL)
    columns = [[there.vector for there in bodies_in_link_frames(robot, one).values()] for one in units]
    moves = np.array(columns).transpose(1, 2, 0)
    for j, ((name, body), move) in enumerate(zip(bodies.items(), moves, strict=True), start=1):
        numbers = {"mass": own[f"M{j}"]}  # of a body without mass there is no more than that
        if body.mass != 0.0:
            ten = [f"{kind}{j}" for kind in INERTIAL]
            values = [*body.com.tolist(), *body.inertia_com[np.triu_indices(3)].tolist()]
            slopes = [dict(zip(ten, row, strict=True)) for row in gradients(body.vector) @ move]
            numbers |= dict(zip(BODY_NUMBERS[1:], labels(values, slopes), strict=True))
        its = {name: label for name, label in own.items() if name == f"{parameter_kind(name)}{j}"}
        links.append(LinkNumbers(name, body, numbers, its))

    def drives(rows: Sequence[dict[str, Slopes]]) -> list[dict[str, Labelled]]:
        """Label drives' numbers, those that stand at their bound marked."""
        drives = []
        for row in rows:
            terms = [[slope * parameters[name] for name, slope in slopes.items()] for slopes in row.values()]
            # What is left of a difference may be rounding.
            sums = [0.0 if abs(sum(own)) < _ROUNDING * max(map(abs, own)) else sum(own) for own in terms]
            drives.append(dict(zip(row, labels(sums, list(row.values())), strict=True)))
        for quantity in SIGNED if groupings else ():
            largest = max((abs(drive[quantity].value) for drive in drives if quantity in drive), default=0.0)
            for drive in (drive for drive in drives if quantity in drive):
                label = drive[quantity]
                drive[quantity] = label._replace(bound=label.value <= _AT_BOUND * (label.sigma or largest))
        return drives

    # Numbers of each joint's drive as far as they are known.
    apart = [
        {quantity: {f"{kind}{j}": 1.0} for quantity, kind in DRIVE_NUMBERS.items() if f"{kind}{j}" in parameters}
        for j in range(1, robot.n + 1)
    ]
    _add_plain_friction(apart, robot, parameters)
    # Rotor k turns with q_j + q_k (8): its inertia IA_k and viscous friction FVM_k act on that sum, and
    # IA_j - IA_k, FV_j - FVM_k and FV_k - FVM_k remain.
    remaining, shared = [dict(row) for row in apart], dict[str, Slopes]()
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        both = {"armature": f"IA{k}", "damping": f"FVM{k}", "friction": f"FSM{k}"}
        shared = {quantity: {name: 1.0} for quantity, name in both.items() if name in parameters}
        if "armature" in shared:
            remaining[j - 1]["armature"] = {f"IA{j}": 1.0, f"IA{k}": -1.0}
            del remaining[k - 1]["armature"]
        if "damping" in shared:
            for joint in (j, k):
                remaining[joint - 1]["damping"] = {**remaining[joint - 1]["damping"], f"FVM{k}": -1.0}
    groupings = base.groupings() if base is not None and estimate is not None else ()
    *joints, coupled = drives([*remaining, shared])
    return WholeRobot(robot, tuple(links), tuple(joints), coupled, tuple(drives(apart)), groupings, source, prior)
