"""Base parameters of a robot that can exist.

Standard parameters are the variables, the data speak only through base parameters chi = G x: the nearest chi for
which *some* robot exists whose every link can exist and whose drives neither push nor have negative inertia. The
standard parameters themselves stay undetermined (26 directions on the RX90) and are not a result.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..model import INERTIAL, BaseParameters, InertialParameters, InputError, Robot
from ..model.arrays import Array, frozen_array
from ..model.names import parameter_kind
from .cone import ConeProgram, ConeSolution, SolverError, solve_cone
from .estimate import Estimate
from .scaling import IDENTITY, NOISE_FLOOR, TOLERANCE, rise_p_value, whitening

_NOT_NEGATIVE = ("IA", "FV", "FS", "FVM", "FSM")
_NEXT_TO_NOTHING = 1e-3
"""Smaller multipliers, as a fraction of the largest, belong to directions that the data do not see."""


class Holding(NamedTuple):
    """What holds the estimate back.

    ``description``; ``multiplier``: how fast chi2 falls as it is relaxed, in scaled units.
    """

    description: str
    multiplier: float


@dataclass(frozen=True)
class ConstrainedBase:
    """Base parameters of a robot that can exist.

    Attributes:
        free: the unconstrained estimate.
        values: the constrained base parameters, in the order of ``free.names``.
        chi2_rise: squared distance from the free ones by their covariance.
        active: links and drives that hold the estimate back, largest multiplier first.
        witness: standard parameters of one robot that can exist and has these base parameters. One of many: not
            identified.
        min_pseudo_inertia_eigenvalue: smallest among the links of ``witness``; not negative.
        status: of the solver.
    """

    free: Estimate
    values: Array
    chi2_rise: float
    active: tuple[Holding, ...]
    witness: dict[str, float]
    min_pseudo_inertia_eigenvalue: float
    status: str

    def __post_init__(self) -> None:
        """Lock the values."""
        object.__setattr__(self, "values", frozen_array(self.values, (len(self.free.names),), "base parameters"))

    @property
    def p_value(self) -> float:
        """As for ``ConstrainedEstimate``: never too small for a robot that can exist."""
        return rise_p_value(self.chi2_rise, len(self.free.names), self.free.degrees_of_freedom)


def solve_constrained_base(robot: Robot, base: BaseParameters, estimate: Estimate) -> ConstrainedBase:
    """The nearest base parameters of a robot that can exist.

    Args:
        robot: the robot.
        base: its base parameters.
        estimate: of all of them, in their order.

    Raises:
        InputError: if the estimate is not of these parameters, or its covariance does not determine them.
        SolverError: for anything but a clean solve.
    """
    if estimate.names != base.columns:
        raise InputError(f"the estimate is not of the {len(base.columns)} base parameters: identify the robot anew")
    scale = _sizes(robot, base, estimate)
    G = base.grouping * scale
    R = whitening(estimate.covariance, estimate.names, NOISE_FLOOR * np.abs(G).max(axis=1))
    A, texts = drive_rules(robot, base.standard)
    places = [[base.standard.index(f"{kind}{link}") for kind in INERTIAL] for link in range(1, robot.n + 1)]
    bodies = np.eye(len(scale))[np.array(places)]
    program = ConeProgram(R @ G, R @ estimate.values, A, np.zeros(len(A)), bodies)
    solution = solve_cone(program)
    z = _repaired(solution.z, program, scale)
    x = z * scale
    values = base.grouping @ x
    chi2 = float(np.sum((R @ (values - estimate.values)) ** 2))
    lowest = min(_lowest(x[link]) for link in places)
    witness = {name: float(value) for name, value in zip(base.standard, x, strict=True)}
    active = _active(solution, program, z, texts)
    return ConstrainedBase(estimate, values, chi2, active, witness, lowest, solution.status)


def _sizes(robot: Robot, base: BaseParameters, estimate: Estimate) -> Array:
    """Scale of each standard parameter: one mass and one length for all links, from the robot's own numbers."""
    lengths = [max(abs(joint.d), abs(joint.r)) for joint in robot.joints]
    length = max(lengths) / 2.0 or 1.0
    powers = {**dict.fromkeys(INERTIAL[:6], 2), **dict.fromkeys(INERTIAL[6:9], 1)}
    masses = {
        name: abs(value) / length ** powers[parameter_kind(name)]
        for name, value in zip(estimate.names, estimate.values, strict=True)
        if parameter_kind(name) in powers
    }
    mass = float(np.median(list(masses.values()))) or 1.0
    inertial = {kind: mass * length ** powers.get(kind, 0) for kind in INERTIAL} | {"IA": mass * length**2}
    own = dict(zip(estimate.names, np.maximum(np.abs(estimate.values), estimate.sigma), strict=True))
    return np.array([inertial.get(parameter_kind(name), own.get(name, 1.0)) for name in base.standard])


def drive_rules(robot: Robot, standard: Sequence[str]) -> tuple[Array, tuple[str, ...]]:
    """Rows of A x >= 0 for friction and rotor inertias, and what each says.

    Of coupled rotors IA_j = K_j^2 JA_j + K_k^2 JA_k is at least IA_k = K_k^2 JA_k.
    """
    units = np.eye(len(standard))
    signs = [k for k, name in enumerate(standard) if parameter_kind(name) in _NOT_NEGATIVE]
    rows, texts = [units[k] for k in signs], [f"{standard[k]} >= 0" for k in signs]
    if robot.coupling:
        j, k = (standard.index(f"IA{joint}") for joint in robot.coupling.joints)
        rows.append(units[j] - units[k])
        texts.append(f"{standard[j]} >= {standard[k]}")
    return np.array(rows).reshape(-1, len(standard)), tuple(texts)


def _lowest(ten: Array) -> float:
    return InertialParameters(ten).min_pseudo_inertia_eigenvalue


def _repaired(z: Array, program: ConeProgram, scale: Array) -> Array:
    """z moved by rounding, so that no link has a negative eigenvalue and no drive a negative number."""
    result = z.copy()
    for body in program.bodies:
        link = body.argmax(axis=1)
        step = max(-_lowest(result[link]), 0.0)
        size = float(np.abs(z[link]).max())
        while _lowest((z[link] + step * IDENTITY) * scale[link]) < 0.0 and step < TOLERANCE * size:
            step = 2.0 * step + 1e-16 * size
        if step >= TOLERANCE * size > 0.0:
            raise SolverError("eigenvalues too negative to be repaired", program)
        result[link] += step * IDENTITY
    single = (program.A != 0.0).sum(axis=1) == 1
    signed = program.A[single].any(axis=0)
    if (program.A @ result < -TOLERANCE).any():
        raise SolverError("friction or rotor inertia too negative to be repaired", program)
    result[signed] = np.maximum(result[signed], 0.0)
    for row in program.A[~single]:
        result[row > 0.0] += max(-float(row @ result), 0.0)
    return np.asarray(result)


def _active(solution: ConeSolution, program: ConeProgram, z: Array, texts: Sequence[str]) -> tuple[Holding, ...]:
    """Constraints whose multiplier exceeds their slack, and is not next to nothing."""
    slacks = [*(program.A @ z), *(_lowest(body @ z) for body in program.bodies)]
    links = [f"link {j} can exist" for j in range(1, len(program.bodies) + 1)]
    prices = [*solution.row_multipliers, *solution.body_multipliers]
    floor = max(_NEXT_TO_NOTHING * max(prices), TOLERANCE)
    found = [
        Holding(text, 2.0 * solution.norm * float(price))
        for text, price, slack in zip([*texts, *links], prices, slacks, strict=True)
        if price > max(slack, floor)
    ]
    return tuple(sorted(found, key=lambda holding: -holding.multiplier))
