"""Base parameters of a robot that can exist.

Standard parameters are the variables, the data speak only through base parameters chi = G x: the nearest chi for
which *some* robot exists whose every link can exist and whose drives neither push nor have negative inertia. The
standard parameters themselves stay undetermined (26 directions on the RX90) and are not a result.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import BaseParameters, InertialParameters, Robot
from ..fit.estimate import Estimate, error_model
from .cone import ConeProgram, ConeSolution, SolverError, solve_cone
from .constraints import MassBounds
from .origin import hidden_directions
from .payload import IDENTITY, NOISE_FLOOR, TOLERANCE, whitening
from .result import Active, Possible
from .robot_rules import RobotRules, link_places, sizes

_NEXT_TO_NOTHING = 1e-3
"""Smaller multipliers, as a fraction of the largest, belong to directions that the data do not see."""
_LARGEST = 1e3
"""R with larger entries is scaled down: the norm of exact data is zero, at the tip of its cone."""
_BALL = 1e3
"""Radius of z where the program must be closed: a thousand times the size of each parameter."""
_ABOVE = 1.0 + 4.0 * np.finfo(float).eps
"""Factor by which a larger number is above a smaller one, whatever rounding a change of scale leaves."""
_UNSEEN = 1e-3
"""In standard deviations: what a repair may change."""


@dataclass(frozen=True)
class PossibleRobot(Possible):
    """Base parameters of a robot whose links can exist, and one such robot.

    Attributes:
        parameters: standard parameters of that robot by name. In the base gauge it is one of many with the same
            base parameters and nothing in it is identified; with a prior, what is not identified is its choice.
        unidentifiable: changes of standard parameters that change no torque ("M1", "IA1 - ZZ1").
    """

    parameters: dict[str, float] = field(kw_only=True)
    unidentifiable: tuple[str, ...] = field(kw_only=True)


class RobotProgram(NamedTuple):
    """The problem in z = standard parameters / ``scale`` (N_s,).

    ``R`` N_b x N_b whitens base parameters; ``program`` minimises ||R (G x - chi)||; ``rules``: its rows;
    ``links``: positions of each link's ten.
    """

    scale: Array
    R: Array
    program: ConeProgram
    rules: RobotRules
    links: list[list[int]]

    @staticmethod
    def of(robot: Robot, base: BaseParameters, estimate: Estimate, total_mass: MassBounds | None) -> "RobotProgram":
        """Scale an estimate of all base parameters; raises InputError if it is not one."""
        if estimate.names != base.columns:
            raise InputError(
                f"the estimate is not of the {len(base.columns)} base parameters: identify the robot anew"
            )
        scale = sizes(robot, base, estimate)
        G = base.grouping * scale
        R = whitening(estimate.covariance, estimate.names, NOISE_FLOOR * np.abs(G).max(axis=1))
        rules, links = RobotRules.of(robot, base.standard, scale, total_mass), link_places(robot, base.standard)
        bodies = np.eye(len(scale))[np.array(links)]
        program = ConeProgram(R @ G, R @ estimate.values, rules.A, rules.b, bodies)
        return RobotProgram(scale, R, program, rules, links)

    def answer(
        self, base: BaseParameters, estimate: Estimate, z: Array, active: tuple[Active, ...], status: str
    ) -> PossibleRobot:
        """The robot that z stands for."""
        x = z * self.scale
        values = base.grouping @ x
        return PossibleRobot(
            free=estimate,
            values=values,
            chi2_rise=float(np.sum((self.R @ (values - estimate.values)) ** 2)),
            active=active,
            bodies=tuple(InertialParameters(x[link]) for link in self.links),
            status=status,
            parameters={name: float(value) for name, value in zip(base.standard, x, strict=True)},
            unidentifiable=hidden_directions(base),
        )

    def repaired(self, z: Array) -> Array:
        """z moved by rounding, so that no link has a negative eigenvalue and no drive a negative number.

        Raises:
            SolverError: if that is more than rounding.
        """
        result = z.copy()
        for link in self.links:
            step, size = max(-_lowest(z[link]), 0.0), max(1.0, float(np.abs(z[link]).max()))
            while _lowest((z[link] + step * IDENTITY) * self.scale[link]) < 0.0 and step < TOLERANCE * size:
                step = 2.0 * step + 1e-16 * size
            if step >= TOLERANCE * size:
                raise SolverError("eigenvalues too negative to be repaired", self.program)
            result[link] += step * IDENTITY
        if (self.rules.A @ result + self.rules.b < -TOLERANCE).any():
            raise SolverError("friction, rotor inertia or mass missed by more than rounding", self.program)
        signed = list(self.rules.signed)
        result[signed] = np.maximum(result[signed], 0.0)
        for j, k in self.rules.shared:
            result[j] = max(result[j], result[k] * self.scale[k] / self.scale[j] * _ABOVE)
        if float(np.linalg.norm(self.program.R @ (result - z))) > _UNSEEN:
            raise SolverError("constraints missed by more than the data's accuracy", self.program)
        return np.asarray(result)


def solve_constrained_base(
    robot: Robot, base: BaseParameters, estimate: Estimate, total_mass: MassBounds | None = None
) -> PossibleRobot:
    """The nearest base parameters of a robot that can exist.

    Every link can exist, friction and rotor inertias are not negative, and coupled drives share some. Nearest
    by robust standard deviations where the estimate has them (``error_model``).

    Args:
        estimate: of all of them, in their order.
        total_mass: bounds of the mass of all links together, where known.

    Raises:
        InputError: if the estimate is not of these parameters, or its covariance does not determine them.
        SolverError: for anything but a clean solve.
    """
    estimate = error_model(estimate)
    return solve_robot_program(RobotProgram.of(robot, base, estimate, total_mass), base, estimate)


def solve_robot_program(problem: RobotProgram, base: BaseParameters, estimate: Estimate) -> PossibleRobot:
    """The nearest base parameters by a problem that is scaled already."""
    solution = _solved(problem.program)
    z = problem.repaired(solution.z)
    return problem.answer(base, estimate, z, _active(solution, problem.program, z, problem.rules.texts), "Solved")


def _solved(program: ConeProgram) -> ConeSolution:
    """The first clean solution.

    No torque may show some direction, and no finite robot attain the least value: the program is closed then. Where
    the search stops short of its end, a smaller R has it end.

    Raises:
        SolverError: if none is clean.
    """
    *others, last = ((_LARGEST, None), (_LARGEST, _BALL), (0.1 * _LARGEST, _BALL), (0.01 * _LARGEST, _BALL))
    for largest, ball in others:
        with suppress(SolverError):
            return solve_cone(program, largest, ball)
    return solve_cone(program, *last)


def _lowest(ten: Array) -> float:
    return InertialParameters(ten).min_pseudo_inertia_eigenvalue


def _active(solution: ConeSolution, program: ConeProgram, z: Array, texts: Sequence[str]) -> tuple[Active, ...]:
    """Constraints whose multiplier exceeds their slack, and is not next to nothing."""
    slacks = [*(program.A @ z + program.b), *(_lowest(body @ z) for body in program.bodies)]
    links = [f"link {j} can exist" for j in range(1, len(program.bodies) + 1)]
    prices = [*solution.row_multipliers, *solution.body_multipliers]
    floor = max(_NEXT_TO_NOTHING * max(prices), TOLERANCE)
    active = [
        Active(text, 2.0 * solution.norm * float(price))
        for text, price, slack in zip([*texts, *links], prices, slacks, strict=True)
        if price > max(slack, floor)
    ]
    return tuple(sorted(active, key=lambda active: -active.multiplier))
