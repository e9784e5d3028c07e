"""What the links of a robot were thought to be before any data: from the robot's file, or from its geometry."""

from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError
from ...model import INERTIAL, InertialParameters, Robot
from ...model.stand_in import cylinder_radius, cylinders


@dataclass(frozen=True)
class RobotPrior:
    """Links as they are thought to be.

    Attributes:
        bodies: one per link, in its own frame; each has some extent (positive definite pseudo-inertia).
        source: where they come from, in words.
    """

    bodies: tuple[InertialParameters, ...]
    source: str

    def __post_init__(self) -> None:
        """Refuse a link from which no distance can be measured.

        Raises:
            InputError: names the link.
        """
        for link, body in enumerate(self.bodies, start=1):
            if body.mass <= 0.0 or body.min_pseudo_inertia_eigenvalue <= 0.0:
                raise InputError(
                    f"prior of link {link} ({self.source}): smallest eigenvalue of its pseudo-inertia "
                    f"{body.min_pseudo_inertia_eigenvalue:.2g}: give a body with mass and some extent"
                )

    @property
    def total_mass(self) -> float:
        """Mass of all links [kg]."""
        return sum(body.mass for body in self.bodies)


def robot_prior(robot: Robot, total_mass: float | None = None) -> RobotPrior:
    """The prior of a robot: the inertial parameters of its file, or cylinders of a stated total mass.

    Args:
        robot: the robot.
        total_mass: of all moving links [kg]; asks for the cylinders even if the file has parameters.

    Raises:
        InputError: if neither is there, or the file holds only some of the parameters.
    """
    if total_mass is not None:
        return cylinder_prior(robot, total_mass)
    names = [f"{kind}{link}" for link in range(1, robot.n + 1) for kind in INERTIAL]
    missing = [name for name in names if name not in robot.parameters]
    if len(missing) == len(names):
        raise InputError(
            f"robot {robot.name!r} has no inertial parameters in its file to serve as prior: give them under "
            "[parameters] of a robot file of your own, or the total mass of its links (--prior-mass KG)"
        )
    if missing:
        raise InputError(
            f"robot {robot.name!r}: {', '.join(missing[:6])} missing in [parameters]: a prior needs the ten of "
            "every link"
        )
    vectors = np.array([robot.parameters[name] for name in names]).reshape(robot.n, 10)
    return RobotPrior(tuple(map(InertialParameters, vectors)), f"the robot file of {robot.name}")


def cylinder_prior(robot: Robot, total_mass: float) -> RobotPrior:
    """Cylinders of a total mass [kg] as ``model.stand_in.cylinders`` makes them.

    Raises:
        InputError: if the mass is not positive.
    """
    source = f"cylinders of one density, radius {cylinder_radius(robot):.3g} m, {total_mass:g} kg in all"
    return RobotPrior(cylinders(robot, total_mass), source)
