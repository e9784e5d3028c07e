"""Options of what is known beforehand: mass and place of the payload, uncertainty of the drive gains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from .... import estimation, model
from ....common.errors import InputError
from ... import results
from ..values import number, numbers, relative, relative_list
from .reading import Options, about, option
from .recordings import Setup

_FROM_ROBOT = (
    "These errors are those that the robot's parameters were identified with; both owe them to the same drives."
)
_INSTEAD = (
    "The robot's parameters were identified with another uncertainty of the gains; what is told now goes for both: "
    "the same drives, the same errors."
)


def six(text: str) -> tuple[float, ...]:
    """Six finite numbers separated by commas."""
    return numbers(text, 6)


@dataclass(frozen=True)
class KnowledgeOptions(Options):
    """What is known of the payload; it enters the constrained estimate of every method."""

    GROUP: ClassVar[str] = "what is known beforehand"
    ABOUT: ClassVar[str] = "lengths in m, in the frame of the answer"

    mass: float | None = option(type=number, metavar="KG", help="the payload was weighed; needs --mass-sigma")
    mass_sigma: float | None = option(type=number, metavar="KG", help="standard deviation of the scale")
    mass_min: float | None = option(type=number, metavar="KG", help="the payload has at least this mass")
    mass_max: float | None = option(type=number, metavar="KG", help="the payload has at most this mass")
    com_within: tuple[float, ...] | None = option(
        type=six,
        metavar="X0,X1,Y0,Y1,Z0,Z1",
        help="box that holds the centre of mass; with = before a list that begins with minus",
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
        if (self.mass is None) != (self.mass_sigma is None):
            raise InputError("--mass and --mass-sigma belong together: a scale errs too, by how much must be said")
        if self.mass is not None and self.mass_sigma is not None:
            with about("--mass", "--mass-sigma"):
                constraints.append(estimation.KnownMass(self.mass, self.mass_sigma))
        if self.mass_min is not None or self.mass_max is not None:
            least = 0.0 if self.mass_min is None else self.mass_min
            with about("--mass-min", "--mass-max"):
                constraints.append(
                    estimation.MassBounds(least, math.inf if self.mass_max is None else self.mass_max)
                )
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
        type=relative,
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

    gain_sigma: tuple[float, ...] | None = option(
        type=relative_list, metavar="2%|S1%,S2%,..", help="each joint's error of torque or drive gain"
    )
    gain_sigma_common: float | None = option(
        type=relative, metavar="1%", help="error of the torques that all joints share"
    )

    def errors(
        self,
        setup: Setup,
        loaded: Sequence[model.Recording],
        unloaded: Sequence[model.Recording],
        stored: results.StoredRobot | None = None,
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
        gains, n = self._told_now(setup.identified), setup.robot.n
        notes: tuple[str, ...] = (_FROM_ROBOT,)
        if gains is not None:
            with about("--gain-sigma"):
                gains.covariance(n)
            notes = (_INSTEAD,) if then is not None and not gains.says_as(then, n) else ()
        elif then is not None:
            gains = then
        else:
            return None
        # The same gains, even if they are told by numbers now.
        source = then if then is not None and not any(gains.recordings.values()) else gains
        used = source.reused(loaded, unloaded)
        return replace(gains, recordings=source.recordings, mass=source.mass, notes=(*used, *notes))

    def _told_now(self, file: estimation.Gains | None) -> estimation.Gains | None:
        """The uncertainty by options or a file of gains."""
        if self.gain_sigma is None and self.gain_sigma_common is None and file is None:
            return None
        return replace(
            file or estimation.Gains(),
            per_joint=self.gain_sigma or (0.0,),
            common=self.gain_sigma_common or 0.0,
        )
