"""Writes recordings as CSV, what is true of simulated ones as TOML, and their equations as NPZ."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ...common.files import write_bytes, write_text
from ...common.schema import toml_text
from ...estimation.answers.system import ObservationSystem
from ...model import Recording
from ...trajectories import Controller, Experiment

SIMULATED = ("position", "speed", "acceleration", "torque", "parameters")
"""Names of ``model.robot.SOURCED`` that a simulation rests on."""


def write_recording(path: str | Path, recording: Recording) -> None:
    """Write time, positions and torques as CSV, in the columns that ``dynident payload`` and ``identify`` read.

    Where something is said of the torques' scale, a remark before the header says so.
    """
    kinds, text = ("q", "tau"), io.StringIO()
    header = ["t", *(f"{kind}{j}" for kind in kinds for j in range(1, recording.q.shape[1] + 1))]
    if recording.gain_sigma is not None:
        text.write(f"# gain_sigma = {recording.gain_sigma:g}\n")
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
    """Write all that a simulated experiment was made from; ``files`` are the names of the runs' recordings."""
    robot = experiment.robot
    assumed = robot.assumed(*SIMULATED)
    loads = [run.task.payload for run in experiment.runs if run.task.payload is not None]
    truth = {
        "robot": robot.name,
        "robot_fingerprint": robot.fingerprint,
        "payload_frame": robot.payload_frame,
        "seed": experiment.seed,
        "versions": versions,
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


def write_npz(path: str | Path, system: ObservationSystem) -> None:
    """Write an observation system as NPZ; the file's name is kept as it is.

    It holds ``columns``, ``W`` (r x c), ``Y``, ``joint`` (from 1), ``recording`` (from 0, in ``sources``), ``t``,
    ``loaded``, ``weights`` (per joint) and ``row_weights``; ``rows``, ``effective_rows`` and ``factor0`` to
    ``factor<n-1>``: R of the QR decomposition of each joint's [W_j Y_j], which ``Equations.load`` reads; of coupled
    drives ``shared<joint>_<motor>`` (from 0), Q_j' times what another joint's motor makes of Y_j; ``known``: values
    of the first columns, where they are known.

    Raises:
        OSError: if it cannot be written.
    """
    names = ("W", "Y", "joint", "recording", "t", "loaded", "weights")
    arrays: dict[str, Any] = {name: getattr(system, name) for name in names} | system.reduced.arrays()
    arrays |= {"sources": np.array(system.sources), "row_weights": system.weights[system.joint - 1]}
    arrays |= {"known": system.known} if system.known is not None else {}
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    write_bytes(path, content.getvalue())
