"""``dynident design --evaluate``: the motion of a file."""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from .. import estimation, model
from ..common.errors import InputError


def logged_motion(arguments: argparse.Namespace, robot: model.Robot) -> model.Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording."""
    if arguments.log_map:
        recording = _mapped(arguments, robot)
    else:
        table = estimation.recordings.read_trajectory(arguments.evaluate, robot)
        if table.qd is not None and table.qdd is not None:
            if arguments.cutoff is not None:
                raise InputError(f"{arguments.evaluate}: has accelerations and is not filtered: leave --cutoff out")
            return model.Motion(table.t, table.q, table.qd, table.qdd)
        recording = model.Recording(table.t, table.q, np.zeros_like(table.q), table.qd, arguments.evaluate)
    processing = robot.processing
    if arguments.cutoff is not None:
        processing = replace(processing, cutoff=arguments.cutoff)
    return estimation.signals.measurement(recording, processing).motion


def _mapped(arguments: argparse.Namespace, robot: model.Robot) -> model.Recording:
    """A log as its map says; of currents the motion counts alone, whatever the gains."""
    log_map = estimation.read_log_map(arguments.log_map)
    currents = estimation.recordings.holds_currents_only(arguments.evaluate, robot, log_map)
    return estimation.read_recording(arguments.evaluate, robot, (1.0,) * robot.n if currents else None, log_map)
