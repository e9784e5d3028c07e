"""What the user knows beforehand, from the command line: mass, place, uncertainty of the drive gains."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .. import estimation, model
from ..common.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence


_FROM_ROBOT = (
    "These errors are those that the robot's parameters were identified with; both owe them to the same drives."
)
_INSTEAD = (
    "The robot's parameters were identified with another uncertainty of the gains; what is told now goes for both: "
    "the same drives, the same errors."
)


def knowledge_arguments(parser: argparse.ArgumentParser) -> None:
    """Options about the payload and the drives; each enters the constrained estimate of every method."""
    group = parser.add_argument_group("what is known beforehand", "lengths in m, in the frame of the answer")
    group.add_argument("--mass", type=float, metavar="KG", help="the payload was weighed; needs --mass-sigma")
    group.add_argument("--mass-sigma", type=float, metavar="KG", help="standard deviation of the scale")
    group.add_argument("--mass-min", type=float, metavar="KG", help="the payload has at least this mass")
    group.add_argument("--mass-max", type=float, metavar="KG", help="the payload has at most this mass")
    group.add_argument(
        "--com-within",
        type=six,
        metavar="X0,X1,Y0,Y1,Z0,Z1",
        help="box that holds the centre of mass; with = before a list that begins with minus",
    )
    group.add_argument(
        "--ellipsoid", type=six, metavar="X,Y,Z,A,B,C", help="centre and semi-axes of one that holds all of it"
    )
    gain_arguments(group)


def gain_arguments(group: Any) -> None:
    """How sure the drive gains are."""
    group.add_argument(
        "--gain-sigma",
        type=relative_list,
        metavar="2%|S1%,S2%,..",
        help="each joint's error of torque or drive gain",
    )
    group.add_argument(
        "--gain-sigma-common", type=relative, metavar="1%", help="error of the torques that all joints share"
    )


def constraints_of(arguments: argparse.Namespace) -> list[estimation.possible.Constraint]:
    """The constraints that the command line names.

    Raises:
        InputError: if they make no sense.
    """
    if (arguments.mass is None) != (arguments.mass_sigma is None):
        raise InputError("--mass and --mass-sigma belong together: a scale errs too, by how much must be said")
    found: list[estimation.possible.Constraint] = [estimation.PossibleBody()]
    if arguments.mass is not None:
        found.append(estimation.KnownMass(arguments.mass, arguments.mass_sigma))
    if arguments.mass_min is not None or arguments.mass_max is not None:
        low = arguments.mass_min if arguments.mass_min is not None else 0.0
        found.append(estimation.MassBounds(low, arguments.mass_max if arguments.mass_max is not None else math.inf))
    if arguments.com_within is not None:
        found.append(estimation.CentreOfMassInBox(arguments.com_within[::2], arguments.com_within[1::2]))
    if arguments.ellipsoid is not None:
        found.append(estimation.InEllipsoid(arguments.ellipsoid[:3], arguments.ellipsoid[3:]))
    return found


def friction_argument(parser: argparse.ArgumentParser, of: str) -> None:
    """``--friction-change``; ``of``: where it counts."""
    parser.add_argument(
        "--friction-change",
        type=relative,
        metavar="SHARE",
        help=f"{of}: by how much friction under load may differ from the robot's own, 1 sigma, 0 for not at all "
        "(default: 10%%)",
    )


def friction_change(arguments: argparse.Namespace) -> float:
    """What was said of it, or the default."""
    told: float | None = arguments.friction_change
    return estimation.payload.FRICTION_CHANGE if told is None else told


def gain_errors_of(
    arguments: argparse.Namespace,
    robot: model.Robot,
    loaded: Sequence[model.Recording],
    unloaded: Sequence[model.Recording],
    stored: estimation.files.StoredRobot | None = None,
    compared: bool = False,
) -> estimation.Gains | None:
    """The uncertainty of the drive gains; None where nothing is said of it.

    What is said now, by options or a file of gains, goes before what was said when the robot was identified: the
    drives are the same, and so is their error. Recordings that the gains come from are named in its notes.

    Args:
        arguments: the command line.
        robot: whose drives.
        loaded: recordings with the payload that is asked for.
        unloaded: without, or the robot's own.
        stored: the robot's parameters from a file.
        compared: whether these are no part of the answer.

    Raises:
        InputError: if it cannot be used, before any work is done.
    """
    then = stored.gains if stored is not None else None
    gains = _told_now(arguments)
    notes: tuple[str, ...] = (_FROM_ROBOT,)
    if gains is not None:
        gains.covariance(robot.n)
        notes = (_INSTEAD,) if then is not None and not gains.says_as(then, robot.n) else ()
    elif then is not None:
        gains = then
    else:
        return None
    if stored is not None and stored.estimate.gain_sensitivity is None and not compared:
        raise InputError(estimation.fit.NOT_TOLD)
    # The same gains, even if they are told by numbers now.
    source = then if then is not None and not any(gains.recordings.values()) else gains
    used = source.reused(loaded, unloaded)
    return replace(gains, recordings=source.recordings, mass=source.mass, notes=(*used, *notes))


def _told_now(arguments: argparse.Namespace) -> estimation.Gains | None:
    """The uncertainty by options or a file of gains."""
    file = arguments.stored_gains
    if arguments.gain_sigma is None and arguments.gain_sigma_common is None and file is None:
        return None
    return replace(
        file or estimation.Gains(),
        per_joint=arguments.gain_sigma or (0.0,),
        common=arguments.gain_sigma_common or 0.0,
    )


def six(text: str) -> tuple[float, ...]:
    """Six numbers separated by commas."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of 6 numbers separated by commas")
    return numbers


def relative(text: str) -> float:
    """A share: 2% or 0.02."""
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a share: write 2% or 0.02")
    return value


def relative_list(text: str) -> tuple[float, ...]:
    """Shares separated by commas; a percent sign at the end stands for all of them."""
    parts = text.split(",")
    if text.endswith("%"):
        parts = [part if part.endswith("%") else f"{part}%" for part in parts]
    elif text.count("%"):
        raise argparse.ArgumentTypeError(f"{text!r}: write the percent sign at the end, or after every number")
    return tuple(relative(part) for part in parts)
