"""Writes simulated recordings as CSV, and what is true of them as TOML."""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..common.files import write_text
from ..model import Recording
from ..trajectories import Controller, Experiment

SIMULATED = ("position", "speed", "acceleration", "torque", "parameters")
"""Of ``model.SOURCED``, what a simulation rests on."""


def write_recording(path: str | Path, recording: Recording) -> None:
    """Write time, positions and torques in the columns that ``dynident payload`` and ``identify`` read."""
    n = recording.q.shape[1]
    header = ["t", *(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, n + 1))]
    text = io.StringIO()
    table = np.column_stack([recording.t, recording.q, recording.torque])
    np.savetxt(text, table, delimiter=",", header=",".join(header), comments="", fmt="%.12g")
    write_text(path, text.getvalue())


def write_truth(
    path: str | Path,
    experiment: Experiment,
    controller: Controller,
    files: Sequence[str],
    versions: Mapping[str, str],
) -> None:
    """Write what the recordings were made from, so that a result can be compared and the experiment repeated.

    Args:
        path: file.
        experiment: the experiment.
        controller: that ran it.
        files: name of each run's recording.
        versions: of the programs that made it.
    """
    robot, errors = experiment.robot, experiment.errors
    lines = ["# What dynident simulated. SI units. The payload is in payload_frame.", ""]
    about_robot = {
        "robot": robot.name,
        "robot_fingerprint": robot.fingerprint,
        "payload_frame": robot.payload_frame,
    }
    lines += _lines(about_robot | {"seed": experiment.seed})
    lines += _table("versions", versions)
    assumed = robot.assumed(*SIMULATED)
    lines += _table("assumed", assumed) if assumed else []
    lines += _table("parameters", robot.parameters)
    bodies = [run.task.payload for run in experiment.runs if run.task.payload is not None]
    if bodies:
        lines += _table("payload", bodies[0].named())
    lines += _table("controller", asdict(controller))
    lines += _table("disturbances", asdict(experiment.disturbances))
    drawn = {"drive_gains": errors.gains.tolist(), "ripple_phases": errors.phases.tolist()}
    lines += _table("drawn", drawn)
    for file, run in zip(files, experiment.runs, strict=True):
        about = {
            "file": file,
            "trajectory": run.task.name,
            "payload": run.task.payload is not None,
            "tracking_error": run.tracking_error.tolist(),
        }
        lines += ["", "[[runs]]", *_lines(about), *_lines({"mean_friction": run.friction})]
    write_text(path, "\n".join(lines) + "\n")


def _table(name: str, values: Mapping[str, Any]) -> list[str]:
    return ["", f"[{name}]", *_lines(values)]


def _lines(values: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_text(value)}" for key, value in values.items()]


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_text(entry)}" for key, entry in value.items()) + "}"
    # Text, numbers, booleans and lists of them read the same in JSON and in TOML.
    return json.dumps(value, allow_nan=False)
