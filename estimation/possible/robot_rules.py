"""What every robot holds, beside links that can exist: rules for its drives, and bounds of its total mass."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, BaseParameters, Coupling, Robot
from ...model.drives import parameter_kind
from ..fit.estimate import Estimate
from .constraints import MassBounds

_NOT_NEGATIVE = ("IA", "FV", "FS", "FVM", "FSM")
POWERS = {**dict.fromkeys(INERTIAL[:6], 2), **dict.fromkeys(INERTIAL[6:9], 1), "M": 0, "IA": 2}
"""Power of a length in the unit of each kind."""


class RobotRules(NamedTuple):
    """Rows A z + b >= 0 in scaled parameters z, and what each says.

    ``A`` r x N_s, ``b`` (r,), ``texts`` r; ``signed``: positions of parameters that must not be negative;
    ``shared``: positions (whole, part) of what coupled drives share: (IA_j, IA_k), (FV_j, FVM_k), (FV_k, FVM_k).
    """

    A: Array
    b: Array
    texts: tuple[str, ...]
    signed: tuple[int, ...]
    shared: tuple[tuple[int, int], ...]

    @property
    def mass_rows(self) -> list[int]:
        """Rows that bound the total mass."""
        return [k for k, text in enumerate(self.texts) if text.startswith("total mass")]

    @staticmethod
    def of(robot: Robot, standard: Sequence[str], scale: Array, total_mass: MassBounds | None) -> "RobotRules":
        """Friction and rotor inertias are not negative.

        Of coupled drives IA_j = K_j^2 JA_j + K_k^2 JA_k is at least IA_k = K_k^2 JA_k, and FV_j and FV_k hold the
        viscous friction FVM_k of rotor k beside the joint's own.
        """
        units = np.eye(len(standard))
        signed = tuple(k for k, name in enumerate(standard) if parameter_kind(name) in _NOT_NEGATIVE)
        rows, b, texts = [units[k] for k in signed], [0.0] * len(signed), [f"{standard[k]} >= 0" for k in signed]
        shared = _shared(robot.coupling, standard) if robot.coupling else ()
        for j, k in shared:
            rows.append(units[j] - scale[k] / scale[j] * units[k])
            b.append(0.0)
            texts.append(f"{standard[j]} >= {standard[k]}")
        masses = sum(units[standard.index(f"M{link}")] for link in range(1, robot.n + 1))
        unit = scale[standard.index("M1")]
        for sign, bound, relation in _bounds(total_mass):
            rows.append(sign * masses)
            b.append(-sign * bound / unit)
            texts.append(f"total mass {relation} {bound:g} kg")
        return RobotRules(np.array(rows).reshape(-1, len(standard)), np.array(b), tuple(texts), signed, shared)


def _shared(coupling: Coupling, standard: Sequence[str]) -> tuple[tuple[int, int], ...]:
    j, k = coupling.joints
    pairs = ((f"IA{j}", f"IA{k}"), (f"FV{j}", f"FVM{k}"), (f"FV{k}", f"FVM{k}"))
    return tuple((standard.index(whole), standard.index(part)) for whole, part in pairs)


def _bounds(total_mass: MassBounds | None) -> list[tuple[float, float, str]]:
    if total_mass is None:
        return []
    both = [(1.0, total_mass.low, ">="), (-1.0, total_mass.high, "<=")]
    return [row for row in both if np.isfinite(row[1])]


def typical_length(robot: Robot) -> float:
    """Half the longest distance between two joints [m]; 1 where all axes meet."""
    return max(max(abs(joint.d), abs(joint.r)) for joint in robot.joints) / 2.0 or 1.0


def sizes(robot: Robot, base: BaseParameters, estimate: Estimate) -> Array:
    """Scale of each standard parameter: one mass and one length for all links, from the robot's own numbers."""
    length = typical_length(robot)
    masses = np.array(
        [
            abs(value) / length ** POWERS[parameter_kind(name)]
            for name, value in zip(estimate.names, estimate.values, strict=True)
            if parameter_kind(name) in INERTIAL
        ]
    )
    # Data without noise show many a parameter as zero: they say nothing of the robot's size.
    masses = masses[masses > 1e-6 * masses.max(initial=0.0)]
    mass = float(np.median(masses)) if len(masses) else 1.0
    inertial = {kind: mass * length**power for kind, power in POWERS.items()}
    own = dict(zip(estimate.names, np.maximum(np.abs(estimate.values), estimate.sigma), strict=True))
    return np.array([inertial.get(parameter_kind(name), own.get(name, 1.0)) for name in base.standard])


def link_places(robot: Robot, standard: Sequence[str]) -> list[list[int]]:
    """Positions of each link's ten."""
    return [[standard.index(f"{kind}{link}") for kind in INERTIAL] for link in range(1, robot.n + 1)]
