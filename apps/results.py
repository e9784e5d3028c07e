"""Results that runs leave in files for others: robots, gains, payloads, equations, what a next motion knows."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import estimation, trajectories  # rooms of theirs are loaded where they are asked for
from ..common import Array, InputError
from ..common.files import write_bytes
from ..common.linear import is_covariance
from ..common.schema import WrongKeyError, naming, present, read_json
from ..estimation import PAYLOAD, Equations, ObservationSystem, PayloadResult
from ..estimation.equations.equations import triangular

_OF_GAINS = "give the file that --json of 'dynident gains' wrote"
_OF_ROBOT = "give the file that --json of 'dynident identify' wrote"
_OF_BOTH = "give the --json of 'dynident identify', or of 'dynident payload --unloaded'"


def read_stored_payload(path: str | Path) -> PayloadResult:
    """Read the JSON of ``dynident payload`` or ``dynident weigh``."""
    return read_json(
        path, PayloadResult, "give the file that --json of 'dynident payload' or 'dynident weigh' wrote"
    )


def read_stored_gains(path: str | Path) -> estimation.GainsResult:
    """Read the ``--json`` of ``dynident gains``, unless its own verdict is against these gains."""
    stored = read_json(path, estimation.GainsResult, _OF_GAINS)
    if stored.judged.level == "do_not_use":
        reason = next(iter(stored.judged.reasons), "no reason is given")
        against = f"the verdict on these drive gains is: do not use ({reason})"
        raise InputError(
            f"{path}: {against}; identify them again, or give the maker's as numbers with --gain-sigma"
        )
    values, C = stored.drive_gains.values, stored.drive_gains.relative_covariance
    with naming(path, _OF_GAINS):
        if not (np.isfinite(values) & (values != 0.0)).all():
            raise WrongKeyError("drive_gains.values", "a gain is zero or null")
        if len(C) != len(values) or not is_covariance(C):
            raise WrongKeyError("drive_gains.relative_covariance", f"is not a covariance of {len(values)} gains")
    return stored


def read_stored_robot(path: str | Path) -> estimation.RobotResult:
    """Read the JSON of ``dynident identify``."""
    stored = read_json(path, estimation.RobotResult, _OF_ROBOT)
    with naming(path, _OF_ROBOT):
        stored.estimate.names  # noqa: B018  numbers that do not fit each other are refused here
    return stored


def write_npz(path: str | Path, system: ObservationSystem) -> None:
    """Write an observation system as NPZ; the file's name is kept as it is.

    It holds ``columns``, ``W`` (r x c), ``Y``, ``joint`` (from 1), ``recording`` (from 0, in ``sources``), ``t``,
    ``loaded``, ``weights`` (per joint) and ``row_weights``; ``rows``, ``effective_rows`` and ``factor0`` to
    ``factor<n-1>``: R of the QR decomposition of each joint's [W_j Y_j], which ``Equations.load`` reads; of coupled
    drives ``shared<joint>_<motor>`` (from 0), Q_j' times what another joint's motor makes of Y_j; ``known``: values
    of the first columns, where they are known.
    """
    names = ("W", "Y", "joint", "recording", "t", "loaded", "weights")
    arrays: dict[str, Any] = {name: getattr(system, name) for name in names} | system.reduced.arrays()
    arrays |= {"sources": np.array(system.sources), "row_weights": system.weights[system.joint - 1]}
    arrays |= {"known": system.known} if system.known is not None else {}
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    write_bytes(path, content.getvalue())


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
            return trajectories.MEMORY / np.asarray(data["weights"]), trajectories.INDEPENDENT
    payload = read_json(path, dict[str, Any], _OF_BOTH).get("kind") == "payload"
    robot = None if payload else read_stored_robot(path).data
    shown = robot or present(read_stored_payload(path).data)
    sigma, rate = (present(shown.torque_noise), present(shown.independent)) if shown else (None, None)
    if sigma is not None and rate is not None:
        return np.asarray(sigma), rate
    if robot is None:
        raise InputError(f"{path}: has no torque noise of recordings without payload: {_OF_BOTH}")
    # A robot without robust standard deviations.
    return trajectories.MEMORY / np.asarray(robot.weights), trajectories.INDEPENDENT


def read_earlier(
    paths: Sequence[str | Path], noise: Array | None, payload: Sequence[str] = ()
) -> trajectories.Earlier:
    """Read R of the observation matrix, rows counted as often as their noise is independent.

    Args:
        paths: NPZ of ``--npz`` of ``dynident identify`` or ``payload``, or JSON of ``identify --json``.
        noise: torque noise per joint that rows are divided by [N·m or N], shape (n,); None for rows as they are.
        payload: how the ten of a payload are called, all other parameters being known; empty for all parameters.

    Raises:
        InputError: if a file does not fit, or a JSON is asked for rows without weights.
    """
    columns, rows = tuple[str, ...](), []
    for path in paths:
        if _is_npz(path):
            problem = Equations.load(path)
            if noise is not None and len(noise) != len(problem.factors):
                raise InputError(f"{path}: is of a robot with {len(problem.factors)} joints, not {len(noise)}")
            names = problem.columns
            factor = np.sqrt(problem.independent) * problem.stacked(None if noise is None else 1.0 / noise)[:, :-1]
        elif noise is None:
            fault = "a covariance holds no unweighted rows, which condition numbers need"
            raise InputError(f"{path}: {fault}: give the --npz of 'dynident identify'")
        else:
            estimate = read_stored_robot(path).estimate
            names = estimate.names
            try:
                factor = np.linalg.inv(np.linalg.cholesky(estimate.covariance))
            except np.linalg.LinAlgError:
                raise InputError(f"{path}: the covariance is not positive definite") from None
        columns = columns or names
        if set(names) != set(columns):
            raise InputError(f"{path}: has other columns than {paths[0]}: give files of one model")
        if payload and not {*PAYLOAD} <= {*columns}:
            raise InputError("earlier recordings have no payload: give the --npz of 'dynident payload', or none")
        rows.append(triangular(factor[:, [names.index(name) for name in (PAYLOAD if payload else columns)]]))
    return trajectories.Earlier(tuple(payload) or columns, np.vstack(rows))


def _is_npz(path: str | Path) -> bool:
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    return Path(path).suffix.lower() == ".npz"
