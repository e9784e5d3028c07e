"""Labels of a whole robot's numbers: who decides each, and how sure it is."""

from collections.abc import Container, Mapping, Sequence

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.drives import parameter_kind
from ...model.frames import bodies_in_link_frames
from ...model.inertia import gradients
from ..fit.estimate import Estimate, error_model
from .labelled import BODY_NUMBERS, DRIVE_NUMBERS, SIGNED, Labelled, LinkNumbers, WholeRobot
from .origin import origins_of

_AT_BOUND = 1e-3
"""Of its standard deviation, or of the largest such number: a smaller one stands at its bound, zero."""
_ROUNDING = 1e-9


def whole_robot(
    robot: Robot,
    parameters: Mapping[str, float],
    source: str,
    base: BaseParameters | None = None,
    estimate: Estimate | None = None,
    prior: str = "the robot's own description",
) -> WholeRobot:
    """All numbers of a robot, labelled.

    A body's number, such as the centre of mass h/M, is no standard parameter: its gradient tells whether small
    changes that no motion shows move it. Standard deviations are those of the identified base parameters.

    Args:
        parameters: its standard parameters by name, the ten of every link; of its drives what is known.
        source: where they come from, in words.
        base: its base parameters, where they were identified.
        estimate: of all of them; without it all numbers are the prior's.
        prior: what decides where data do not, in words.

    Raises:
        InputError: if parameters of a link are missing.
    """
    bodies = bodies_in_link_frames(robot, parameters)
    labels = _Labels(robot, base, estimate, parameters)
    links = []
    for j, ((name, body), move) in enumerate(zip(bodies.items(), _into_link_frames(robot), strict=True), start=1):
        ten = [f"{kind}{j}" for kind in INERTIAL]
        values = _numbers(body)
        labelled = labels.of(values, [dict(zip(ten, row, strict=True)) for row in _gradients(body) @ move])
        numbers = dict(zip(BODY_NUMBERS, labelled, strict=False)) | {"mass": labels.own[f"M{j}"]}
        own = [name for name in parameters if name == f"{parameter_kind(name)}{j}"]
        links.append(LinkNumbers(name, body, numbers, {name: labels.own[name] for name in own}))
    rows, shared = _drive_slopes(robot, parameters)
    *drives, coupled = labels.drives([*_coupled_apart(robot, rows, shared), shared])
    groupings = tuple(base.groupings()) if base is not None and estimate is not None else ()
    apart = tuple(labels.drives(rows))
    return WholeRobot(robot, tuple(links), tuple(drives), coupled, apart, groupings, source, prior)


Slopes = dict[str, float]
"""Derivatives of a number by standard parameters."""


class _Labels:
    """Makes labels of numbers by their slopes."""

    def __init__(
        self,
        robot: Robot,
        base: BaseParameters | None,
        estimate: Estimate | None,
        values: Mapping[str, float],
    ) -> None:
        self._robot, self._values = robot, values
        self._known = None if base is None or estimate is None else (base, error_model(estimate))
        if self._known is not None:
            base, errors = self._known
            self._moved = errors.values - base.value(values)
        labelled = self.of(list(values.values()), [{name: 1.0} for name in values])
        self.own = dict(zip(values, labelled, strict=True))

    def of(self, numbers: Sequence[float], slopes: Sequence[Slopes]) -> list[Labelled]:
        """Labels of numbers, each with its slopes."""
        if self._known is None:
            return [Labelled(number) for number in numbers]
        base, errors = self._known
        places = {name: k for k, name in enumerate(base.standard)}
        gradients = np.zeros((len(places), len(numbers)))
        for column, row in enumerate(slopes):
            gradients[[places[name] for name in row], column] = list(row.values())
        origins = origins_of(self._robot, base, gradients)
        by_base = np.asarray(np.linalg.lstsq(base.grouping.T, gradients, rcond=None)[0].T, dtype=float)
        spread = errors.mapped(by_base, tuple(map(str, range(len(numbers)))))
        # To first order the free estimate's own number, for what can exist may be moved away from it.
        free = np.asarray(numbers) + by_base @ self._moved
        half = np.diff(spread.interval95)[:, 0] / 2.0
        return [
            Labelled(number, origin, float(spread.sigma[k]), (float(free[k] - half[k]), float(free[k] + half[k])))
            if origin.kind == "identified"
            else Labelled(number, origin)
            for k, (number, origin) in enumerate(zip(numbers, origins, strict=True))
        ]

    def drives(self, rows: Sequence[dict[str, Slopes]]) -> list[dict[str, Labelled]]:
        """Labels of drives' numbers, those that stand at their bound marked."""
        drives = [
            dict(zip(row, self.of([*map(self._sum, row.values())], [*row.values()]), strict=True)) for row in rows
        ]
        if self._known is None:
            return drives
        largest = {
            quantity: max((abs(d[quantity].value) for d in drives if quantity in d), default=0.0)
            for quantity in SIGNED
        }
        return [
            {
                quantity: label._replace(bound=quantity in SIGNED and _bounded(label, largest[quantity]))
                for quantity, label in d.items()
            }
            for d in drives
        ]

    def _sum(self, slopes: Slopes) -> float:
        terms = [slope * self._values[name] for name, slope in slopes.items()]
        return 0.0 if abs(sum(terms)) < _ROUNDING * max(map(abs, terms)) else sum(terms)


def _bounded(label: Labelled, largest: float) -> bool:
    return label.value <= _AT_BOUND * (label.sigma or largest)


def _drive_slopes(robot: Robot, known: Container[str]) -> tuple[list[dict[str, Slopes]], dict[str, Slopes]]:
    """Numbers of each joint's drive, and of the one that turns with two joints, as far as they are known."""
    rows = [
        {quantity: {f"{kind}{j}": 1.0} for quantity, kind in DRIVE_NUMBERS.items() if f"{kind}{j}" in known}
        for j in range(1, robot.n + 1)
    ]
    if robot.coupling is None:
        return rows, {}
    k = robot.coupling.joints[1]
    both = {"armature": f"IA{k}", "damping": f"FVM{k}", "friction": f"FSM{k}"}
    return rows, {quantity: {name: 1.0} for quantity, name in both.items() if name in known}


def _coupled_apart(
    robot: Robot, rows: Sequence[dict[str, Slopes]], shared: Mapping[str, Slopes]
) -> list[dict[str, Slopes]]:
    """Numbers of the joints' drives without what rotor k, which turns with q_j + q_k (8), has of them.

    Its inertia IA_k and viscous friction FVM_k act on that sum; IA_j - IA_k, FV_j - FVM_k and FV_k - FVM_k remain.
    """
    remaining = [dict(row) for row in rows]
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        if "armature" in shared:
            remaining[j - 1]["armature"] = {f"IA{j}": 1.0, f"IA{k}": -1.0}
            del remaining[k - 1]["armature"]
        if "damping" in shared:
            for joint in (j, k):
                remaining[joint - 1]["damping"] = {f"FV{joint}": 1.0, f"FVM{k}": -1.0}
    return remaining


def _into_link_frames(robot: Robot) -> list[Array]:
    """Per link, the ten in its own frame by the ten in the modified DH frame, 10 x 10."""
    columns = []
    for unit in np.eye(len(INERTIAL)):
        ten = dict(zip(INERTIAL, unit, strict=True))
        parameters = {f"{kind}{j}": value for j in range(1, robot.n + 1) for kind, value in ten.items()}
        columns.append([there.vector for there in bodies_in_link_frames(robot, parameters).values()])
    return list(np.array(columns).transpose(1, 2, 0))


def _numbers(body: InertialParameters) -> list[float]:
    if body.mass == 0.0:
        return [0.0]
    return [body.mass, *body.com.tolist(), *body.inertia_com[np.triu_indices(3)].tolist()]


def _gradients(body: InertialParameters) -> Array:
    """Derivatives of a body's numbers by its ten; of the mass alone where there is none."""
    mass = np.eye(len(INERTIAL))[-1:]
    return mass if body.mass == 0.0 else np.vstack([mass, gradients(body.vector)])
