"""Standard parameters of a robot that can exist: those nearest to a prior that the data allow.

Data speak only of base parameters; of all robots that explain them about as well, the one whose links are nearest
to a prior in entropic distance is one definite answer. The weight of the distance is chosen so that chi2 rises by a
stated budget above that of the nearest robot that can exist: the prior never costs more than that.
"""

from dataclasses import dataclass, field

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.stand_in import MOVING, cylinder_radius, cylinders, missing_inertial
from ..fit.estimate import Estimate, error_model
from .cone import ConeProgram, solve_cone
from .constraints import MassBounds
from .entropic import EntropicProgram, pseudo_inertias
from .payload import TOLERANCE
from .robot import PossibleRobot, RobotProgram
from .whole_robot import Origin, origins

BUDGET = 1.0
"""By which chi2 may rise above the constrained minimum."""


@dataclass(frozen=True)
class RobotPrior:
    """Links as they are thought to be.

    Attributes:
        bodies: one per link, in its own frame; each has some extent (positive definite pseudo-inertia).
        source: where they come from, in text.
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


def robot_prior(robot: Robot, total_mass: float | None = None) -> RobotPrior:
    """The prior of a robot: the inertial parameters of its file, or cylinders of a total mass.

    Without a stated mass, and where the file has no parameters, it is the fraction ``MOVING`` of the maker's mass
    of the whole arm, for that holds the base.

    Args:
        total_mass: of all moving links [kg]; asks for the cylinders even if the file has parameters.

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
    """Whether the robot's own file gives ``robot_prior`` something to start from."""
    missing = missing_inertial(robot)
    return not missing or (robot.mass is not None and len(missing) == len(INERTIAL) * robot.n)


@dataclass(frozen=True)
class PriorRobot(PossibleRobot):
    """The robot that can exist, data first, then a prior.

    Attributes:
        nearest: the base gauge: the nearest robot that can exist.
        prior: the links as they were thought to be.
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
    problem = RobotProgram.of(robot, base, error_model(estimate), total_mass)
    nearest = problem.nearest()
    z0 = np.zeros(len(problem.scale))  # the prior's links; drives are zero
    z0[problem.links] = [body.vector for body in prior.bodies] / problem.scale[problem.links]
    program = EntropicProgram(problem.program, pseudo_inertias(problem.program, z0))
    solution, weight, status = _prior_itself(problem, z0, nearest.chi2_rise + budget), np.inf, "prior"
    prices = np.zeros(0)
    if solution is None:
        weight, point = program.within_budget(program.start(_inside(problem, z0)), nearest.chi2_rise, budget)
        solution, prices, status = point.z, point.multipliers, "Solved"
    z = problem.repaired(solution)
    return PriorRobot(
        **vars(problem.answer(z, status, prices)),
        nearest=nearest,
        prior=prior,
        budget=budget,
        weight=weight,
        origins=origins(robot, base),
        distances=tuple(program.distances(z).tolist()),
    )


def _prior_itself(problem: RobotProgram, z0: Array, limit: float) -> Array | None:
    """The prior's links with the drives that suit them best, if that is within the limit."""
    F, d, A, _, bodies = problem.program
    drives, rows = np.setdiff1d(np.arange(len(z0)), problem.links), len(problem.rules.A)
    room = problem.program.slack(z0)
    if (room[rows:] < -TOLERANCE).any():
        return None  # the prior breaks a bound of the mass
    z = z0.copy()
    if len(drives):
        part = ConeProgram(F[:, drives], d - F @ z0, A[:rows, drives], room[:rows], bodies[:0, :, drives])
        z[drives] = solve_cone(part, [(1e3, np.inf)]).z
        signed = list(problem.rules.signed)
        z[signed] = np.maximum(z[signed], 0.0)
    return z if float(np.sum((F @ z - d) ** 2)) <= limit else None


def _inside(problem: RobotProgram, z0: Array) -> Array:
    """A point strictly inside: the prior's links, scaled to the bounds of their mass, drives above zero.

    Raises:
        InputError: if the bounds of the mass leave no room.
    """
    z, rows = z0.copy(), len(problem.rules.A)
    A, b = problem.program.A[rows:] @ z0, problem.program.b[rows:]
    if (A + b <= 0.0).any():
        ends = -b / A  # factors at which a bound is met
        factor = float(ends.mean()) if len(ends) == 2 else float(ends[0]) * (1.1 if A[0] > 0.0 else 0.9)
        if (A * factor + b <= 0.0).any():
            raise InputError("the bounds of the total mass leave no room: give low < high, high above 0 kg")
        z[problem.links] *= factor
    z[list(problem.rules.signed)] = 1.0
    for j, k in problem.rules.shared:
        z[j] = max(z[j], 1.0 + z[k] * problem.scale[k] / problem.scale[j])
    return z
