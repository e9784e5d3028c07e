"""What data say about each standard parameter, and about each number made of them: all, a part, or nothing.

Every table, document and export takes its labels from here.
"""

from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import decomposed
from ...model import BaseParameters, Robot
from ...model.drives import parameter_kind
from .robot_rules import POWERS, typical_length

_ROUNDING = 1e-9
_NOTHING = 1e-12
"""Of a gradient's largest entry: less is a rotation's rounding."""


class Origin(NamedTuple):
    """Who decides a number of the robot.

    ``kind``: "identified" if its gradient (of a standard parameter: its unit vector) lies in the row space of the
    grouping G, so that base parameters alone determine it; "combination" if only combinations with others are
    determined; "prior" if no motion shows it. ``base``: names of the base parameters it is part of. ``share``:
    squared length of the part of the unit gradient in the row space, in units of one mass and one length for all
    links: 1 if identified, 0 if decided by the prior alone.
    """

    kind: Literal["identified", "combination", "prior"]
    base: tuple[str, ...]
    share: float

    def decided_by(self) -> str:
        """The label of every table, document and export: "data", "prior", or "prior within MX2R, ZZ2R"."""
        if self.kind == "identified":
            return "data"
        return f"prior within {', '.join(self.base)}" if self.kind == "combination" else "prior"


def origins(robot: Robot, base: BaseParameters) -> dict[str, Origin]:
    """The origin of every standard parameter, by name."""
    by_parameter = origins_of(robot, base, np.eye(len(base.standard)))
    return dict(zip(base.standard, by_parameter, strict=True))


def origins_of(robot: Robot, base: BaseParameters, gradients: Array) -> list[Origin]:
    """Origins of numbers whose gradients by the standard parameters are the columns of ``gradients``, N_s x m."""
    length = typical_length(robot)
    units = np.array([length ** POWERS.get(parameter_kind(name), 0) for name in base.standard])
    G = base.grouping * units
    rows = decomposed(G.T).range.T
    scaled = gradients * units[:, None]
    scaled[np.abs(scaled) < _NOTHING * np.abs(scaled).max(axis=0)] = 0.0
    shares = np.sum((rows @ scaled) ** 2, axis=0) / np.sum(scaled**2, axis=0)
    return [
        _origin(base, column, float(min(max(share, 0.0), 1.0)))
        for column, share in zip(scaled.T, shares, strict=True)
    ]


def _origin(base: BaseParameters, gradient: Array, share: float) -> Origin:
    part_of = tuple(base.names[i] for i in np.flatnonzero(base.grouping[:, gradient != 0.0].any(axis=1)))
    if not part_of:
        return Origin("prior", (), 0.0)
    return Origin("identified", part_of, 1.0) if share > 1.0 - _ROUNDING else Origin("combination", part_of, share)


def hidden_directions(base: BaseParameters) -> tuple[str, ...]:
    """Changes of the standard parameters that change no torque, N_s - N_b texts: "YY2 + XX2", "M1"."""
    eliminated = [k for k in range(len(base.standard)) if k not in base.chosen]
    return tuple(_direction(base, k, base.grouping[:, k]) for k in eliminated)


def _direction(base: BaseParameters, k: int, column: Array) -> str:
    """One more of parameter k is the same as less of those that it is grouped into."""
    text = base.standard[k]
    for name, factor in zip(base.columns, column, strict=True):
        if factor:
            size = "" if abs(abs(factor) - 1.0) < _ROUNDING else f"{abs(factor):.6g} "
            text += f" {'-' if factor > 0.0 else '+'} {size}{name}"
    return text
