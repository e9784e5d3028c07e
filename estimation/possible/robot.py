"""Base parameters of the nearest robot that can exist.

Standard parameters are the variables, the data speak only through base parameters chi = G x: the nearest chi for
which *some* robot exists whose every link can exist and whose drives neither push nor have negative inertia. The
standard parameters themselves stay undetermined.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...common import Array, Indices, InputError, one_thread
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.base import sum_text
from ...model.drives import parameter_kind
from ..fit.estimate import Estimate, error_model
from .constraints import ConeProgram, MassBounds, SolverError, solve_cone
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
    """Rules A z >= 0, one positive entry in a row, of 1, of standard parameters over ``scale``; the rows as text.

    Friction and rotor inertias are not negative. Of what coupled drives share, IA_j = K_j^2 JA_j + K_k^2 JA_k is at
    least IA_k = K_k^2 JA_k, and FV_j and FV_k hold the viscous friction FVM_k of rotor k besides the joint's own.
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

    def answer(self, solution: Array, status: str, prices: Array, floor: float, slope: float) -> PossibleRobot:
        """Make the robot of a solution; ``prices``, ``floor``, ``slope``: as of ``holding``.

        It is moved by rounding, so that no link has a negative eigenvalue and no drive a negative number.
        """
        z = solution.copy()
        for link in self.links:
            z[link] = lifted(z[link], self.scale[link])
        if (self.program.A @ z + self.program.b < -TOLERANCE).any():
            raise SolverError("friction, rotor inertia or mass missed by more than rounding")
        for rule in self.program.A[: self.rules]:
            whole = int(rule.argmax())
            z[whole] = max(z[whole], 0.0 - _ABOVE * float(z @ np.minimum(rule, 0.0)))
        if float(np.linalg.norm(self.program.R @ (z - solution))) > _UNSEEN:
            raise SolverError("constraints missed by more than the data's accuracy")
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
    return problem.answer(z, "Solved", prices, floor, slope)


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
