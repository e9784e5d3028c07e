"""Simulated recordings in files: each as CSV, and what is true of them as TOML."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ..common.arrays import Array
from ..common.files import write_text
from ..common.schema import toml_text
from ..common.versions import versions
from ..model import Recording
from ..trajectories import Controller, Experiment

SIMULATED = ("position", "speed", "acceleration", "torque", "parameters")
"""Names of ``model.robot.SOURCED`` that a simulation rests on."""


def csv_text(t: Array, signals: Mapping[str, Array], form: str) -> str:
    """Times, shape (N,), and signals N x n by their names as CSV: columns t, q1, q2, ..."""
    names = [f"{name}{j}" for name, values in signals.items() for j in range(1, values.shape[1] + 1)]
    table, text = np.column_stack([t, *signals.values()]), io.StringIO()
    np.savetxt(text, table, delimiter=",", header=",".join(["t", *names]), comments="", fmt=form)
    return text.getvalue()


def write_recording(path: str | Path, recording: Recording) -> None:
    """Write time, positions and torques as CSV, in the columns that ``dynident payload`` and ``identify`` read.

    Where something is said of the torques' scale, a remark before the header says so.
    """
    remark = "" if recording.gain_sigma is None else f"# gain_sigma = {recording.gain_sigma:g}\n"
    write_text(path, remark + csv_text(recording.t, {"q": recording.q, "tau": recording.torque}, "%.12g"))


def write_truth(path: str | Path, experiment: Experiment, controller: Controller, files: Sequence[str]) -> None:
    """Write all that a simulated experiment was made from; ``files`` are the names of the runs' recordings."""
    robot, assumed = experiment.robot, experiment.robot.assumed(*SIMULATED)
    loads = [run.task.payload for run in experiment.runs if run.task.payload is not None]
    truth = {
        "robot": robot.name,
        "robot_fingerprint": robot.fingerprint,
        "payload_frame": robot.payload_frame,
        "seed": experiment.seed,
        "versions": versions(),
        **({"assumed": assumed} if assumed else {}),
        "parameters": robot.parameters,
        **({"payload": loads[0].named()} if loads else {}),
        "controller": asdict(controller),
        "disturbances": asdict(experiment.disturbances),
        "drawn": {"drive_gains": experiment.gains.tolist(), "ripple_phases": experiment.phases.tolist()},
        "runs": [
            {
                "file": file,
                "trajectory": run.task.name,
                "payload": run.task.payload is not None,
                "tracking_error": run.tracking_error.tolist(),
                "mean_friction": run.friction,
            }
            for file, run in zip(files, experiment.runs, strict=True)
        ],
    }
    write_text(path, "# What dynident simulated. SI units. The payload is in payload_frame.\n\n" + toml_text(truth))
