"""The motion that ``dynident design`` is asked for."""

from __future__ import annotations

import argparse

from .. import trajectories
from ..common.errors import InputError


def asked_shape(
    arguments: argparse.Namespace,
) -> trajectories.FourierShape | trajectories.ViaPointShape | trajectories.BlendShape:
    """The shape of the motion.

    Raises:
        InputError: for options that do not go together.
    """
    if arguments.fourier is None:
        if arguments.duration is not None:
            raise InputError("--duration is the period of --fourier: via points take --max-duration")
        return _via_points(arguments)
    for option in ("rest", "max_duration", "segments", "ramp", "segment_durations"):
        value = getattr(arguments, option)
        if value is not None and value is not False:
            raise InputError(f"--{option.replace('_', '-')} belongs to --via-points: --fourier takes --duration")
    return trajectories.FourierShape(arguments.fourier, _period(arguments))


def known_length(arguments: argparse.Namespace) -> float | None:
    """How long the motion will take [s], or at most; None where nothing says so."""
    if arguments.fourier is not None:
        return _period(arguments)
    fixed = arguments.segment_durations
    if fixed is None:
        length: float | None = arguments.max_duration
        return length
    moves = (arguments.via_points or trajectories.ViaPointShape().count) - 1
    return float(moves * fixed[0] if len(fixed) == 1 else sum(fixed))


def _period(arguments: argparse.Namespace) -> float:

    return float(trajectories.FourierShape().duration if arguments.duration is None else arguments.duration)


def _via_points(arguments: argparse.Namespace) -> trajectories.ViaPointShape | trajectories.BlendShape:

    count = arguments.via_points or trajectories.ViaPointShape().count
    if count < 3:
        raise InputError(f"--via-points {count}: give at least 3")
    if arguments.ramp is not None and arguments.segments != "trapezoid":
        raise InputError("--ramp has no effect without --segments trapezoid")
    fixed = _fixed(arguments)
    if arguments.segments == "blend":
        if arguments.rest:
            raise InputError("--segments blend passes the via points: --segments trapezoid rests in each")
        return trajectories.BlendShape(count, fixed=fixed)
    segment: trajectories.motions.Segment = trajectories.motions.Quintic()
    if arguments.segments == "trapezoid":
        segment = trajectories.Trapezoid() if arguments.ramp is None else trajectories.Trapezoid(arguments.ramp)
    return trajectories.ViaPointShape(
        count, passing=segment.passes and not arguments.rest, fixed=fixed, segment=segment
    )


def _fixed(arguments: argparse.Namespace) -> float | tuple[float, ...] | None:
    """Times from point to point [s], if they are fixed."""
    fixed: tuple[float, ...] | None = arguments.segment_durations
    if fixed is not None and arguments.max_duration is not None:
        raise InputError("--segment-durations fixes the whole duration: leave --max-duration out")
    return fixed[0] if fixed is not None and len(fixed) == 1 else fixed
