"""Whole robot for simulators: a number for everything, who decides each, and its standard deviation.

Data decide a number, a part of it, or nothing. Every table, document and export takes its labels from here.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Literal, NamedTuple

import numpy as np

from ...common import Array, decomposed
from ...model import INERTIAL, BaseParameters, InertialParameters, Robot
from ...model.drives import parameter_kind
from ...model.dynamics import gravity
from ...model.frames import bodies_in_link_frames
from ...model.friction import PAPER
from ...model.inertia import gradients
from ...model.stand_in import POSES, poses_in_range
from ..fit.estimate import Estimate, error_model
from .robot import Origin, origins

_ROUNDING = 1e-9
BODY_NUMBERS = ("mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Numbers of a body: mass [kg], centre of mass [m], inertia there [kg m^2], in the link's frame."""
DRIVE_NUMBERS = {"armature": "IA", "damping": "FV", "friction": "FS", "offset": "OFF"}
"""Numbers of a drive, and its parameter: kg m^2 or kg, N·m·s/rad or N·s/m, N·m or N, N·m or N."""
SIGNED = ("armature", "damping", "friction")  # numbers of a drive that are not negative


class Labelled(NamedTuple):
    """Number with its origin, and the data's standard deviation and 95 % interval where they determine it.

    ``bound``: it stands at the bound of what can exist, which data alone would pass.
    """

    value: float
    origin: Origin = Origin()
    sigma: float | None = None
    interval: tuple[float, float] | None = None
    bound: bool = False

    @property
    def mark(self) -> Literal["data", "rule", "prior"]:
        """Origin in one word; the part that data have in a prior's number is ``origin.share``."""
        return "rule" if self.bound else "data" if self.origin.kind == "identified" else "prior"


class LinkNumbers(NamedTuple):
    """Numbers of one link."""

    link: str
    body: InertialParameters  # in the link's own frame
    numbers: dict[str, Labelled]  # its ``BODY_NUMBERS`` (mass alone if it has none)
    parameters: dict[str, Labelled]  # its standard ones and its drive's, in the modified DH frame

    @property
    def moments(self) -> Array:
        """Principal moments of inertia [kg m^2], shape (3,), rising."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com) if self.body.mass else np.zeros(3), dtype=float)

    @property
    def margin(self) -> float:
        """Distance of the moments from breaking A + B >= C, over their sum; 0 for a body at the edge."""
        a, b, c = self.moments.tolist()
        return (a + b - c) / (a + b + c) if c > 0.0 else 0.0


@dataclass(frozen=True)
class WholeRobot:
    """A robot with a number for everything that a simulator asks for."""

    robot: Robot
    links: tuple[LinkNumbers, ...]
    drives: tuple[dict[str, Labelled], ...]  # of each joint, what is known by the keys of ``DRIVE_NUMBERS``
    coupled: dict[str, Labelled]  # of the drive that turns with both joints of a coupling; empty without one
    apart: tuple[dict[str, Labelled], ...]  # as ``drives`` for who cannot couple joints: the diagonal of both
    groupings: tuple[str, ...]  # the base parameters, in text; none where nothing was identified
    source: str
    prior: str  # what decides where data do not

    @property
    def mass(self) -> float:
        """Mass of the moving links together [kg]."""
        return sum(link.body.mass for link in self.links)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints: of the robot's own file, else the maker's, else joint1 to jointn."""
        robot = self.robot
        if robot.links is not None:
            return robot.links.joints
        return robot.joint_names[0] if robot.joint_names else tuple(f"joint{j + 1}" for j in range(robot.n))

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """Name of the base, then of the links."""
        links = self.robot.links
        return ("base_link" if links is None else links.base, *(link.link for link in self.links))

    def signed(self, chosen: Callable[[Labelled], bool]) -> tuple[str, ...]:
        """Names of the chosen numbers of drives among those that are not negative: ``joint1 damping``."""
        drives = (*zip(self.joint_names, self.drives, strict=True), ("coupled drive", self.coupled))
        there = ((name, quantity, drive) for name, drive in drives for quantity in SIGNED if quantity in drive)
        return tuple(f"{name} {quantity}" for name, quantity, drive in there if chosen(drive[quantity]))

    def heavier_than_the_arm(self) -> tuple[str, ...]:
        """Links that weigh more than the maker says the whole arm does, in text."""
        most = self.robot.mass
        return tuple(
            f"{link.link} would weigh {link.body.mass:.4g} kg, the whole arm weighs {most:g} kg"
            for link in self.links
            if most is not None and link.body.mass > most
        )


_AT_BOUND = 1e-3
"""Fraction of its standard deviation, or of the largest such number: a smaller one stands at its bound, zero."""
Slopes = dict[str, float]  # derivatives of a number by standard parameters


def _add_plain_friction(drives: Sequence[dict[str, Slopes]], robot: Robot, parameters: Mapping[str, float]) -> None:
    """Add to each drive the Coulomb and viscous friction nearest to each other term, per unit of its parameter.

    Under the mean size of the links' weight, over speeds up to the joint's limit (1 without one), laws of one's own
    in mid-range.
    """
    chi = np.array([parameters.get(name, 0.0) for name in robot.standard])[:, None]
    weights = np.array(gravity(robot).map(POSES)(poses_in_range(robot, POSES).T, np.tile(chi, POSES)))
    every = zip(drives, robot.joints, np.abs(weights).mean(axis=1), strict=True)
    for j, (drive, joint, load) in enumerate(every, start=1):
        top = joint.limits.speed if np.isfinite(joint.limits.speed) else 1.0
        speed, one = np.linspace(0.02, 1.0, 50) * top, np.ones(50)
        middle = one * np.mean(np.clip(joint.limits.position, -10.0, 10.0))
        for term in robot.drives.friction:
            if term not in PAPER and (name := f"{term.kind}{j}") in parameters:
                law = term.value(speed, one, middle, load * one)
                dry, viscous = decomposed(np.column_stack([one, speed])).solution(law).tolist()
                drive.setdefault("friction", {})[name] = dry
                drive.setdefault("damping", {})[name] = viscous


def whole_robot(
    robot: Robot,
    parameters: Mapping[str, float],
    source: str,
    base: BaseParameters | None = None,
    estimate: Estimate | None = None,
    prior: str = "the robot's own description",
) -> WholeRobot:
    """Collect all numbers of a robot, labelled.

    A body's number, such as the centre of mass h/M, is no standard parameter: its gradient tells whether small
    changes that no motion shows move it. Standard deviations are those of the identified base parameters.

    Args:
        parameters: its standard parameters by name, the ten of every link; of its drives what is known.
        source: where they come from, in text.
        base: its base parameters, where they were identified.
        estimate: of all of them; without it all numbers are the prior's.
        prior: what decides where data do not, in text.

    Raises:
        InputError: if parameters of a link are missing.
    """
    bodies, links = bodies_in_link_frames(robot, parameters), list[LinkNumbers]()

    def labels(numbers: Sequence[float], slopes: Sequence[Slopes]) -> list[Labelled]:
        """Label numbers by their gradients, standard deviations where the data determine them."""
        if base is None or estimate is None:
            return [Labelled(number) for number in numbers]
        errors, by_standard = error_model(estimate), np.zeros((len(base.standard), len(numbers)))
        for column, row in enumerate(slopes):
            by_standard[[base.standard.index(name) for name in row], column] = list(row.values())
        by_base = np.asarray(np.linalg.lstsq(base.grouping.T, by_standard, rcond=None)[0].T, dtype=float)
        # To first order the free estimate's own number, for what can exist may be moved away from it.
        free = errors.mapped(by_base, tuple(map(str, range(len(numbers)))))
        moved = by_base @ (errors.values - base.value(parameters)) - free.values
        ends = (np.asarray(numbers) + moved)[:, None] + free.interval95
        every = zip(numbers, origins(robot, base, by_standard), free.sigma.tolist(), ends.tolist(), strict=True)
        return [
            Labelled(number, origin, *((sigma, tuple(interval)) if origin.share == 1.0 else ()))
            for number, origin, sigma, interval in every
        ]

    by_parameter = labels(list(parameters.values()), [{name: 1.0} for name in parameters])
    own, every = dict(zip(parameters, by_parameter, strict=True)), [*product(range(1, robot.n + 1), INERTIAL)]
    # Per link, the ten in its own frame by the ten in the modified DH frame, 10 x 10.
    units = ({f"{kind}{j}": float(kind == unit) for j, kind in every} for unit in INERTIAL)
    columns = [[there.vector for there in bodies_in_link_frames(robot, one).values()] for one in units]
    moves = np.array(columns).transpose(1, 2, 0)
    for j, ((name, body), move) in enumerate(zip(bodies.items(), moves, strict=True), start=1):
        numbers = {"mass": own[f"M{j}"]}  # of a body without mass there is no more than that
        if body.mass != 0.0:
            ten = [f"{kind}{j}" for kind in INERTIAL]
            values = [*body.com.tolist(), *body.inertia_com[np.triu_indices(3)].tolist()]
            slopes = [dict(zip(ten, row, strict=True)) for row in gradients(body.vector) @ move]
            numbers |= dict(zip(BODY_NUMBERS[1:], labels(values, slopes), strict=True))
        its = {name: label for name, label in own.items() if name == f"{parameter_kind(name)}{j}"}
        links.append(LinkNumbers(name, body, numbers, its))

    def drives(rows: Sequence[dict[str, Slopes]]) -> list[dict[str, Labelled]]:
        """Label drives' numbers, those that stand at their bound marked."""
        drives = []
        for row in rows:
            terms = [[slope * parameters[name] for name, slope in slopes.items()] for slopes in row.values()]
            # What is left of a difference may be rounding.
            sums = [0.0 if abs(sum(own)) < _ROUNDING * max(map(abs, own)) else sum(own) for own in terms]
            drives.append(dict(zip(row, labels(sums, list(row.values())), strict=True)))
        for quantity in SIGNED if groupings else ():
            largest = max((abs(drive[quantity].value) for drive in drives if quantity in drive), default=0.0)
            for drive in (drive for drive in drives if quantity in drive):
                label = drive[quantity]
                drive[quantity] = label._replace(bound=label.value <= _AT_BOUND * (label.sigma or largest))
        return drives

    # Numbers of each joint's drive as far as they are known.
    apart = [
        {quantity: {f"{kind}{j}": 1.0} for quantity, kind in DRIVE_NUMBERS.items() if f"{kind}{j}" in parameters}
        for j in range(1, robot.n + 1)
    ]
    _add_plain_friction(apart, robot, parameters)
    # Rotor k turns with q_j + q_k (8): its inertia IA_k and viscous friction FVM_k act on that sum, and
    # IA_j - IA_k, FV_j - FVM_k and FV_k - FVM_k remain.
    remaining, shared = [dict(row) for row in apart], dict[str, Slopes]()
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        both = {"armature": f"IA{k}", "damping": f"FVM{k}", "friction": f"FSM{k}"}
        shared = {quantity: {name: 1.0} for quantity, name in both.items() if name in parameters}
        if "armature" in shared:
            remaining[j - 1]["armature"] = {f"IA{j}": 1.0, f"IA{k}": -1.0}
            del remaining[k - 1]["armature"]
        if "damping" in shared:
            for joint in (j, k):
                remaining[joint - 1]["damping"] = {**remaining[joint - 1]["damping"], f"FVM{k}": -1.0}
    groupings = base.groupings() if base is not None and estimate is not None else ()
    *joints, coupled = drives([*remaining, shared])
    return WholeRobot(robot, tuple(links), tuple(joints), coupled, tuple(drives(apart)), groupings, source, prior)
