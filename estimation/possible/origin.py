"""What data say about each standard parameter, and about each number of a body: all, a part, or nothing.

Every table, document and export takes its labels from here.
"""

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import decomposed
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.frames import bodies_in_link_frames
from ...model.inertia import gradients
from ...model.names import parameter_kind
from .robot_rules import POWERS, typical_length

Gauge = Literal["base", "prior"]
"""What decides where data do not: a convention ("base": one of all robots alike to the data), or a prior."""
DECIDER: dict[Gauge, str] = {"base": "convention", "prior": "prior"}
_ROUNDING = 1e-9
_NOTHING = 1e-12
"""Of a gradient's largest entry: less is a rotation's rounding."""
BODY_NUMBERS = ("mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""A body as simulators hold it: mass [kg], centre of mass [m], inertia there [kg m^2], in the link's frame."""


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

    def decided_by(self, gauge: Gauge = "prior") -> str:
        """The label of every table, document and export: "data", "prior", or "prior within MX2R, ZZ2R"."""
        if self.kind == "identified":
            return "data"
        alone = DECIDER[gauge]
        return f"{alone} within {', '.join(self.base)}" if self.kind == "combination" else alone


class Labelled(NamedTuple):
    """A number and who decides it."""

    value: float
    origin: Origin


class LinkOrigins(NamedTuple):
    """One link: ``body``, its ``BODY_NUMBERS`` (mass alone if it has none); ``parameters``, its standard ones."""

    link: str
    body: dict[str, Labelled]
    parameters: dict[str, Labelled]


class RobotOrigins(NamedTuple):
    """A robot whose numbers are labelled.

    ``gauge``: what decided where data did not; ``links``: base to tip; ``groupings``: the base parameters, in text.
    """

    gauge: Gauge
    links: tuple[LinkOrigins, ...]
    groupings: tuple[str, ...]


def origins(robot: Robot, base: BaseParameters) -> dict[str, Origin]:
    """The origin of every standard parameter, by name."""
    found = origins_of(robot, base, np.eye(len(base.standard)))
    return dict(zip(base.standard, found, strict=True))


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


def robot_origins(
    robot: Robot, base: BaseParameters, parameters: Mapping[str, float], gauge: Gauge
) -> RobotOrigins:
    """Origins of all numbers of every link, those of its body in the link's own frame too.

    A body's number, such as the centre of mass h/M, is no standard parameter: its gradient tells whether small
    changes that no motion shows move it.

    Args:
        robot: the robot.
        base: its base parameters.
        parameters: all its standard parameters by name.
        gauge: what decided where data did not.

    Raises:
        InputError: if parameters of a link are missing.
    """
    own = origins(robot, base)
    links = []
    pairs = zip(bodies_in_link_frames(robot, parameters).items(), _into_link_frames(robot), strict=True)
    for j, ((link, there), move) in enumerate(pairs, start=1):
        places = [base.standard.index(f"{kind}{j}") for kind in INERTIAL]
        gradients = np.zeros((len(base.standard), len(numbers := _numbers(there))))
        gradients[places] = (_gradients(there) @ move).T
        found = zip(BODY_NUMBERS, numbers, origins_of(robot, base, gradients), strict=False)
        body = {name: Labelled(value, origin) for name, value, origin in found}
        names = [name for name in base.standard if name == f"{parameter_kind(name)}{j}"]
        links.append(LinkOrigins(link, body, {name: Labelled(parameters[name], own[name]) for name in names}))
    return RobotOrigins(gauge, tuple(links), tuple(base.groupings()))


def _into_link_frames(robot: Robot) -> list[Array]:
    """Per link, the ten in its own frame by the ten in the modified DH frame, 10 x 10."""
    columns = []
    for unit in np.eye(len(INERTIAL)):
        ten = dict(zip(INERTIAL, unit, strict=True))
        one = {f"{kind}{j}": value for j in range(1, robot.n + 1) for kind, value in ten.items()}
        columns.append([there.vector for there in bodies_in_link_frames(robot, one).values()])
    return list(np.array(columns).transpose(1, 2, 0))


def _numbers(body: InertialParameters) -> list[float]:
    if body.mass == 0.0:
        return [0.0]
    return [body.mass, *body.com.tolist(), *body.inertia_com[np.triu_indices(3)].tolist()]


def _gradients(body: InertialParameters) -> Array:
    """Derivatives of a body's numbers by its ten; of the mass alone where there is none."""
    mass = np.eye(len(INERTIAL))[-1:]
    return mass if body.mass == 0.0 else np.vstack([mass, gradients(body.vector)])
