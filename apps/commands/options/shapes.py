"""Options of the motion to be designed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from .... import model, trajectories
from ....common.arrays import Array
from ....common.errors import InputError
from ..values import gains_list, number, positive, positive_number
from .reading import Options, in_si, option

_FEWEST = 3
_OF_VIA_POINTS = ("rest", "max_duration", "segments", "ramp", "segment_durations")


@dataclass(frozen=True)
class ShapeOptions(Options):
    """Via points or a Fourier series, how it goes between points, times, and where it starts."""

    GROUP: ClassVar[str] = "motion"

    via_points: int | None = option(
        either="kind", type=positive, metavar="N", help="number of points (default: 14)"
    )
    fourier: int | None = option(
        either="kind", type=positive, metavar="H", help="a Fourier series of H harmonics instead"
    )
    segments: str | None = option(
        choices=("quintic", "trapezoid"),
        help="default: quintic; trapezoid: as movej runs it, at rest in each point",
    )
    ramp: float | None = option(
        type=number, metavar="SHARE", help="of each move's time, in either ramp of a trapezoid (0.25)"
    )
    segment_durations: tuple[float, ...] | None = option(
        type=gains_list,
        metavar="S|S1,S2,..",
        help="fixed times from point to point, one for all or one each (default: free)",
    )
    rest: bool = option(action="store_true", help="rest in each via point instead of passing it")
    duration: float | None = option(type=positive_number, metavar="S", help="period of --fourier (default: 10)")
    max_duration: float | None = option(type=positive_number, metavar="S", help="longest time through via points")
    start: tuple[float, ...] | None = option(type=gains_list, metavar="Q1,Q2,..", help="where it starts [deg or m]")

    def shape(self) -> trajectories.motions.Shape:
        """The shape of the motion.

        Raises:
            InputError: for options that do not go together.
        """
        if self.fourier is None:
            self.refuse("duration", "is the period of --fourier: via points take --max-duration")
            return self._through_points()
        for name in _OF_VIA_POINTS:
            self.refuse(name, "belongs to --via-points: --fourier takes --duration")
        return trajectories.FourierShape(self.fourier, self._period)

    def known_length(self) -> float | None:
        """How long the motion will take [s], or at most; None where nothing says so."""
        if self.fourier is not None:
            return self._period
        fixed, moves = self.segment_durations, self._count - 1
        if fixed is None:
            return self.max_duration
        return float(moves * fixed[0] if len(fixed) == 1 else sum(fixed))

    def start_pose(self, robot: model.Robot) -> Array | None:
        """The pose where the motion begins, checked in the units it was given in."""
        if not self.start:
            return None
        pose = in_si(self.start, robot)
        for j, (joint, value, position) in enumerate(zip(robot.joints, self.start, pose, strict=True), 1):
            low, high = joint.limits.position
            if not low <= position <= high:
                unit = "deg" if joint.revolute else "m"
                shown = [math.degrees(limit) if joint.revolute else limit for limit in (low, high)]
                raise InputError(
                    f"--start: joint {j} at {value:g} {unit} is outside {shown[0]:g} to {shown[1]:g} {unit}"
                )
        return pose

    @property
    def _count(self) -> int:
        return self.via_points or trajectories.ViaPointShape().count

    @property
    def _period(self) -> float:
        return float(trajectories.FourierShape().duration if self.duration is None else self.duration)

    def _through_points(self) -> trajectories.ViaPointShape:
        if self._count < _FEWEST:
            raise InputError(f"--via-points {self._count}: give at least {_FEWEST}")
        if self.segments != "trapezoid":
            self.refuse("ramp", "has no effect without --segments trapezoid")
        times = self.segment_durations
        if times is not None and self.max_duration is not None:
            raise InputError("--segment-durations fixes the whole duration: leave --max-duration out")
        fixed = times[0] if times is not None and len(times) == 1 else times
        segment: trajectories.motions.Segment = trajectories.motions.Quintic()
        if self.segments == "trapezoid":
            segment = trajectories.Trapezoid() if self.ramp is None else trajectories.Trapezoid(self.ramp)
        passing = segment.passes and not self.rest
        return trajectories.ViaPointShape(self._count, passing=passing, fixed=fixed, segment=segment)
