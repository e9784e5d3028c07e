"""``dynident design --evaluate``: the motion of a file."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..model import Motion, Recording, Robot


def logged_motion(arguments: argparse.Namespace, robot: Robot) -> Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording."""
    from dataclasses import replace

    import numpy as np

    from ..common.errors import InputError
    from ..estimation.recordings import read_trajectory
    from ..estimation.signals import measurement
    from ..model import Motion, Recording

    if arguments.log_map:
        recording = _mapped(arguments, robot)
    else:
        table = read_trajectory(arguments.evaluate, robot)
        if table.qd is not None and table.qdd is not None:
            if arguments.cutoff is not None:
                raise InputError(f"{arguments.evaluate}: has accelerations and is not filtered: leave --cutoff out")
            return Motion(table.t, table.q, table.qd, table.qdd)
        recording = Recording(table.t, table.q, np.zeros_like(table.q), table.qd, arguments.evaluate)
    processing = robot.processing
    if arguments.cutoff is not None:
        processing = replace(processing, cutoff=arguments.cutoff)
    return measurement(recording, processing).motion


def _mapped(arguments: argparse.Namespace, robot: Robot) -> Recording:
    """A log as its map says; of currents the motion counts alone, whatever the gains."""
    from ..estimation import read_log_map, read_recording
    from ..estimation.recordings import holds_currents_only

    log_map = read_log_map(arguments.log_map)
    currents = holds_currents_only(arguments.evaluate, robot, log_map)
    return read_recording(arguments.evaluate, robot, (1.0,) * robot.n if currents else None, log_map)
