"""The kinds of motion among which a design chooses: small values, and the families they stand for."""

from dataclasses import dataclass

from ..common.arrays import Array
from ..common.errors import InputError
from ..model import Robot
from .bounds import JointBounds
from .fourier import FreeFourier
from .free_blends import FreeBlends
from .free_via_points import FreeViaPoints
from .samples import Family
from .segments import QUINTIC, Segment


@dataclass(frozen=True)
class ViaPointShape:
    """A motion through via points.

    Attributes:
        count: number of points.
        passing: whether it passes the inner points, or rests in each.
        samples: parts of a segment between samples while optimising.
        durations: shortest and longest time from point to point [s].
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
        segment: ``Quintic()``, or ``Trapezoid(ramp)``, which rests in each point.
    """

    count: int = 14
    passing: bool = True
    samples: int = 12
    durations: tuple[float, float] = (0.1, 3.0)
    fixed: float | tuple[float, ...] | None = None
    segment: Segment = QUINTIC


@dataclass(frozen=True)
class BlendShape:
    """Moves at constant speed that blend into each other about the via points, ``BlendedPoints``.

    Attributes:
        count: number of points.
        samples: parts of a move and a blend together between samples while optimising.
        durations: shortest and longest time from point to point [s].
        fixed: the times from point to point themselves [s], count - 1 of them or one for all; None for free.
    """

    count: int = 14
    samples: int = 12
    durations: tuple[float, float] = (0.1, 3.0)
    fixed: float | tuple[float, ...] | None = None


@dataclass(frozen=True)
class FourierShape:
    """A Fourier series of a fixed duration.

    Attributes:
        harmonics: number of harmonics.
        duration: period [s].
        samples: while optimising; 0 for 24 per period of the highest harmonic.
    """

    harmonics: int = 5
    duration: float = 10.0
    samples: int = 0


Shape = ViaPointShape | BlendShape | FourierShape
"""The kinds of motion among which a design chooses."""


def family_of(
    robot: Robot,
    bounds: JointBounds,
    shape: Shape,
    duration: float | None,
    start: Array | None,
) -> Family:
    """The motions of a shape.

    Args:
        robot: the robot.
        bounds: limits of its joints.
        shape: of the motion.
        duration: longest time that a motion through via points may take [s]; None for any.
        start: where it begins [rad or m], shape (n,); None for anywhere.

    Raises:
        InputError: if something does not fit.
    """
    if isinstance(shape, FourierShape):
        if duration not in (None, shape.duration):
            raise InputError("a Fourier motion's duration stands in its shape: leave duration out")
        return FreeFourier(robot, bounds, shape.harmonics, shape.duration, samples=shape.samples, start=start)
    if shape.fixed is not None and duration is not None:
        raise InputError("the durations of the moves are fixed: leave the longest duration of the motion out")
    if isinstance(shape, BlendShape):
        return FreeBlends(
            robot,
            bounds,
            shape.count,
            samples=shape.samples,
            durations=shape.durations,
            fixed=shape.fixed,
            start=start,
        )
    return FreeViaPoints(
        robot,
        bounds,
        shape.count,
        passing=shape.passing,
        samples=shape.samples,
        durations=shape.durations,
        fixed=shape.fixed,
        segment=shape.segment,
        start=start,
    )
