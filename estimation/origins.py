"""What data say about each standard parameter: all, a part, or nothing."""

from typing import Literal, NamedTuple

import numpy as np

from ..model import BaseParameters, Robot
from ..model.arrays import Array
from ..model.names import parameter_kind
from .robot_rules import POWERS, typical_length

_ROUNDING = 1e-9


class Origin(NamedTuple):
    """Who decides a standard parameter.

    ``kind``: "identified" if its unit vector lies in the row space of the grouping G, so that base parameters alone
    determine it; "combination" if it has a column in G but only combinations with others are determined; "prior" if
    its column is zero: no motion shows it. ``base``: names of the base parameters it is part of. ``share``: squared
    length of the part of its unit vector in the row space, in units of one mass and one length for all links: 1 if
    identified, 0 if decided by the prior alone.
    """

    kind: Literal["identified", "combination", "prior"]
    base: tuple[str, ...]
    share: float

    @property
    def text(self) -> str:
        """In words, for tables."""
        if self.kind == "combination":
            return f"prior within {', '.join(self.base)}"
        return self.kind


def origins(robot: Robot, base: BaseParameters) -> dict[str, Origin]:
    """The origin of every standard parameter, by name."""
    length = typical_length(robot)
    units = np.array([length ** POWERS.get(parameter_kind(name), 0) for name in base.standard])
    G = base.grouping * units
    rows = np.linalg.svd(G / np.linalg.norm(G, axis=1, keepdims=True), full_matrices=False)[2]
    shares = np.sum(rows * rows, axis=0)
    return {name: _origin(base, k, float(min(max(shares[k], 0.0), 1.0))) for k, name in enumerate(base.standard)}


def _origin(base: BaseParameters, k: int, share: float) -> Origin:
    part_of = tuple(base.names[i] for i in np.flatnonzero(base.grouping[:, k]))
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
