"""Knowledge from earlier recordings for the next motion, read from the files of an identification."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..common.schema import present, read_json
from ..estimation.equations.equations import PAYLOAD, Equations, triangular
from ..trajectories import INDEPENDENT, Earlier
from ..trajectories.design.goal import MEMORY
from .results import read_stored_payload, read_stored_robot

_OF_BOTH = "give the --json of 'dynident identify', or of 'dynident payload --unloaded'"


def shown_noise(path: str | Path) -> tuple[Array, float]:
    """Torque errors of an earlier recording, what their memory adds included.

    Of a JSON of ``dynident identify`` or ``payload``, or the NPZ of their ``--npz``, whose memory is not known: the
    standard deviation of each joint [N·m or N], shape (n,), and independent samples a second [Hz].
    """
    if _is_npz(path):
        Equations.load(path)
        with np.load(path, allow_pickle=False) as data:
            if "weights" not in data:
                raise InputError(f"{path}: has no weights: give --torque-noise, or --like JSON")
            return MEMORY / np.asarray(data["weights"]), INDEPENDENT
    if read_json(path, dict[str, Any], _OF_BOTH).get("kind") == "payload":
        shown = present(read_stored_payload(path).data)
        sigma, rate = (present(shown.torque_noise), present(shown.independent)) if shown else (None, None)
        if sigma is None or rate is None:
            raise InputError(f"{path}: has no torque noise of recordings without payload: {_OF_BOTH}")
        return np.asarray(sigma), rate
    own = read_stored_robot(path).data
    sigma, rate = present(own.torque_noise), present(own.independent)
    if sigma is None or rate is None:  # without robust standard deviations
        return MEMORY / np.asarray(own.weights), INDEPENDENT
    return np.asarray(sigma), rate


def read_earlier(paths: Sequence[str | Path], noise: Array | None, payload: Sequence[str] = ()) -> Earlier:
    """Read R of the observation matrix, rows counted as often as their noise is independent.

    Args:
        paths: NPZ of ``--npz`` of ``dynident identify`` or ``payload``, or JSON of ``identify --json``.
        noise: torque noise per joint that rows are divided by [N·m or N], shape (n,); None for rows as they are.
        payload: how the ten of a payload are called, all other parameters being known; empty for all parameters.

    Raises:
        InputError: if a file does not fit, or a JSON is asked for rows without weights.
    """
    parts = [_factor(path, noise) for path in paths]
    columns = parts[0].columns
    for path, part in zip(paths, parts, strict=True):
        if set(part.columns) != set(columns):
            raise InputError(f"{path}: has other columns than {paths[0]}: give files of one model")
    if payload and not {*PAYLOAD} <= {*columns}:
        raise InputError("earlier recordings have no payload: give the --npz of 'dynident payload', or none")
    chosen = PAYLOAD if payload else columns
    rows = [triangular(part.factor[:, [part.columns.index(name) for name in chosen]]) for part in parts]
    return Earlier(tuple(payload) or columns, np.vstack(rows))


def _factor(path: str | Path, noise: Array | None) -> Earlier:
    if _is_npz(path):
        problem = Equations.load(path)
        if noise is not None and len(noise) != len(problem.factors):
            raise InputError(f"{path}: is of a robot with {len(problem.factors)} joints, not {len(noise)}")
        rows = problem.stacked(None if noise is None else 1.0 / noise)[:, :-1]
        return Earlier(problem.columns, np.sqrt(problem.independent) * rows)
    if noise is None:
        fault = "a covariance holds no unweighted rows, which condition numbers need"
        raise InputError(f"{path}: {fault}: give the --npz of 'dynident identify'")
    estimate = read_stored_robot(path).estimate
    try:
        lower = np.linalg.cholesky(estimate.covariance)
    except np.linalg.LinAlgError:
        raise InputError(f"{path}: the covariance is not positive definite") from None
    return Earlier(estimate.names, np.linalg.inv(lower))


def _is_npz(path: str | Path) -> bool:
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    return Path(path).suffix.lower() == ".npz"
