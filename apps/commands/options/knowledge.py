"""Options of what is known beforehand: mass and place of the payload, uncertainty of the drive gains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from .... import estimation, model
from ....common.errors import InputError
from ..values import bounds, gain_errors, share, six, with_sigma
from .reading import Options, about, option
from .recordings import Setup

_FROM_ROBOT = (
    "These errors are those that the robot's parameters were identified with; both owe them to the same drives."
)
_INSTEAD = (
    "The robot's parameters were identified with another uncertainty of the gains; what is told now goes for both: "
    "the same drives, the same errors."
)


@dataclass(frozen=True)
class KnowledgeOptions(Options):
    """What is known of the payload; it enters the constrained estimate of every method."""

    GROUP: ClassVar[str] = "what is known beforehand"
    ABOUT: ClassVar[Mapping[str, str]] = {
        "what is known beforehand": "lengths in m, in the frame of the answer; = before a leading minus"
    }

    mass: tuple[tuple[float, ...], float | None] | None = option(
        type=with_sigma, metavar="KG+-KG", help="the payload was weighed, with the scale's standard deviation"
    )
    mass_bounds: tuple[float | None, float | None] | None = option(
        type=bounds, metavar="LEAST,MOST", help="the payload's mass lies between; either may be left out: ,3"
    )
    com_within: tuple[float, ...] | None = option(
        type=six, metavar="X0,X1,Y0,Y1,Z0,Z1", help="box that holds the centre of mass"
    )
    ellipsoid: tuple[float, ...] | None = option(
        type=six, metavar="X,Y,Z,A,B,C", help="centre and semi-axes of one that holds all of it"
    )

    def constraints(self) -> list[estimation.Constraint]:
        """The constraints that are named.

        Raises:
            InputError: if they make no sense.
        """
        constraints: list[estimation.Constraint] = [estimation.PossibleBody()]
        if self.mass is not None:
            masses, sigma = self.mass
            if len(masses) > 1 or sigma is None:
                raise InputError(
                    "--mass: a scale errs too, by how much must be said: give one mass and its standard "
                    f"deviation, such as {masses[0]:g}+-0.01"
                )
            constraints.append(estimation.KnownMass(masses[0], sigma))
        if self.mass_bounds is not None:
            least, most = self.mass_bounds
            with about("--mass-bounds"):
                constraints.append(estimation.MassBounds(least or 0.0, math.inf if most is None else most))
        if self.com_within is not None:
            with about("--com-within"):
                constraints.append(estimation.CentreOfMassInBox(self.com_within[::2], self.com_within[1::2]))
        if self.ellipsoid is not None:
            with about("--ellipsoid"):
                constraints.append(estimation.InEllipsoid(self.ellipsoid[:3], self.ellipsoid[3:]))
        return constraints


@dataclass(frozen=True)
class FrictionOptions(Options):
    """How far friction under load may differ from the robot's own."""

    friction_change: float | None = option(
        type=share,
        metavar="SHARE",
        help="method 4 and --robot-parameters: by how much friction under load may differ from the robot's own, "
        "1 sigma, 0 for not at all (default: 10%%)",
    )

    @property
    def change(self) -> float:
        """What was said of it, or the default."""
        return estimation.FRICTION_CHANGE if self.friction_change is None else self.friction_change


@dataclass(frozen=True)
class GainOptions(Options):
    """How sure the drive gains are."""

    GROUP: ClassVar[str] = "drive gains"

    gain_sigma: tuple[tuple[float, ...], float] | None = option(
        type=gain_errors,
        metavar="2%|S1,S2,..%|common=1%",
        help="each joint's error of torque or drive gain, and one that all share: 2%%,common=1%% (default: what "
        "the recordings say, else 2%%, 1%% for torque sensors behind the gears; 0: exact)",
    )

    def errors(
        self,
        setup: Setup,
        loaded: Sequence[model.Recording],
        unloaded: Sequence[model.Recording],
        stored: estimation.RobotResult | None = None,
    ) -> estimation.Gains | None:
        """The uncertainty of the drive gains; None where nothing is said of it.

        What is said now, by options or a file of gains, goes before what was said when the robot was identified:
        the drives are the same, and so is their error. Recordings that the gains come from are named in its notes.

        Args:
            loaded: recordings with the payload that is asked for.
            unloaded: without, or the robot's own.
            stored: the robot's parameters from a file.

        Raises:
            InputError: if it cannot be used, before any work is done.
        """
        then = stored.gains if stored is not None else None
        now, n = setup.identified, setup.robot.n
        if self.gain_sigma is not None or now is not None:
            per_joint, common = self.gain_sigma or ((0.0,), 0.0)
            now = replace(now or estimation.Gains(), per_joint=per_joint, common=common)
        notes: tuple[str, ...] = (_FROM_ROBOT,)
        if now is not None:
            with about("--gain-sigma"):
                now.covariance(n)
            notes = (_INSTEAD,) if then is not None and not now.says_as(then, n) else ()
        gains = now or then
        if gains is None:
            return None
        # The same gains, even if they are told by numbers now.
        source = then if then is not None and not any(gains.recordings.values()) else gains
        used = source.reused(loaded, unloaded)
        return replace(gains, recordings=source.recordings, mass=source.mass, notes=(*used, *notes))
