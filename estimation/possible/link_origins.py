"""Origins of all numbers of a link: its standard parameters, and its body as a simulator holds it."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.frames import bodies_in_link_frames
from ...model.inertia import skew
from ...model.names import parameter_kind
from .data_share import Gauge, Origin, origins, origins_of

BODY_NUMBERS = ("mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""A body as simulators hold it: mass [kg], centre of mass [m], inertia there [kg m^2], in the link's frame."""


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
    pairs = zip(bodies_in_link_frames(robot, parameters), _into_link_frames(robot), strict=True)
    for j, (there, move) in enumerate(pairs, start=1):
        places = [base.standard.index(f"{kind}{j}") for kind in INERTIAL]
        gradients = np.zeros((len(base.standard), len(numbers := _numbers(there.body))))
        gradients[places] = (_gradients(there.body) @ move).T
        found = zip(BODY_NUMBERS, numbers, origins_of(robot, base, gradients), strict=False)
        body = {name: Labelled(value, origin) for name, value, origin in found}
        names = [name for name in base.standard if name == f"{parameter_kind(name)}{j}"]
        links.append(LinkOrigins(there.link, body, {name: Labelled(parameters[name], own[name]) for name in names}))
    return RobotOrigins(gauge, tuple(links), tuple(base.groupings()))


def _into_link_frames(robot: Robot) -> list[Array]:
    """Per link, the ten in its own frame by the ten in the modified DH frame, 10 x 10."""
    columns = []
    for unit in np.eye(len(INERTIAL)):
        ten = dict(zip(INERTIAL, unit, strict=True))
        one = {f"{kind}{j}": value for j in range(1, robot.n + 1) for kind, value in ten.items()}
        columns.append([there.body.vector for there in bodies_in_link_frames(robot, one)])
    return list(np.array(columns).transpose(1, 2, 0))


def _numbers(body: InertialParameters) -> list[float]:
    if body.mass == 0.0:
        return [0.0]
    return [body.mass, *body.com.tolist(), *body.inertia_com[np.triu_indices(3)].tolist()]


def _gradients(body: InertialParameters) -> Array:
    """Derivatives of a body's numbers by its ten; of the mass alone where there is none."""
    rows = [np.eye(10)[9]]
    if body.mass != 0.0:
        rows += [(np.eye(10)[6 + k] - body.com[k] * rows[0]) / body.mass for k in range(3)]
        c = skew(body.com)
        # I_com = I + h^ h^ / M, h^ the cross product with h = M c.
        change = [InertialParameters(unit) for unit in np.eye(10)]
        of_inertia = [
            one.inertia + skew(one.first_moments) @ c + c @ skew(one.first_moments) - one.mass * c @ c
            for one in change
        ]
        rows += list(np.array([inertia[np.triu_indices(3)] for inertia in of_inertia]).T)
    return np.array(rows)
