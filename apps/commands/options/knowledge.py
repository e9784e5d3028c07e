"""Options of what is known beforehand: mass and place of the payload, uncertainty of the drive gains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated

from .... import estimation, model
from ....common.errors import InputError
from ..entry import KNOWN, LOGS, Options, about
from ..values import Bounds, Weighed, gain_errors, numbers, word
from .recordings import Setup

_FROM_ROBOT = (
    "These errors are those that the robot's parameters were identified with; both owe them to the same drives."
)
_INSTEAD = (
    "The robot's parameters were identified with another uncertainty of the gains; what is told now goes for both: "
    "the same drives, the same errors."
)
_Box = Annotated[tuple[float, ...], word(partial(numbers, count=6), "X0,X1,Y0,Y1,Z0,Z1")]
_Ellipsoid = Annotated[tuple[float, ...], word(partial(numbers, count=6), "X,Y,Z,A,B,C")]
_Errors = Annotated[tuple[tuple[float, ...], float], word(gain_errors, "2%|S1,S2,..%|common=1%")]


class KnowledgeOptions(Options, group=KNOWN):
    """Knowledge of the payload, which enters the constrained estimate of every method."""

    mass: Weighed | None = None
    """The payload was weighed, with the scale's standard deviation."""
    mass_bounds: Bounds | None = None
    """The payload's mass lies between; either may be left out: ,3."""
    com_within: _Box | None = None
    """Box that holds the centre of mass."""
    ellipsoid: _Ellipsoid | None = None
    """Centre and semi-axes of one that holds all of it."""

    def constraints(self) -> list[estimation.Constraint]:
        """The constraints that are named."""
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


class GainOptions(Options, group=LOGS):
    """Uncertainty of the drive gains."""

    gain_sigma: _Errors | None = None
    """Each joint's error of torque or drive gain, and one that all share: 2%,common=1% (default: what the
    recordings say, else 2%, 1% for torque sensors behind the gears; 0: exact)."""

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
