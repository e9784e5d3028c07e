"""What earlier recordings have taught, as a plain triangular factor: for designing the next motion."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import read_text
from ...estimation.equations.equations import PAYLOAD, Equations, triangular
from .stored import read_stored_robot


class Information(NamedTuple):
    """R of a QR decomposition of an observation matrix W.

    Attributes:
        columns: names of its columns, c.
        factor: k x c; its Gram matrix is W'W, rows weighted or not as asked, and counted as often as
            their noise is independent.
    """

    columns: tuple[str, ...]
    factor: Array

    def of_payload(self, names: Sequence[str]) -> "Information":
        """The payload's columns under other names, all other parameters taken as known.

        Args:
            names: of the ten, in the order of (6).

        Raises:
            InputError: if there was no payload.
        """
        missing = [name for name in PAYLOAD if name not in self.columns]
        if missing:
            raise InputError(
                "the earlier recordings have no payload: give the --npz of 'dynident payload', or leave them out"
            )
        places = [self.columns.index(name) for name in PAYLOAD]
        return Information(tuple(names), triangular(self.factor[:, places]))


def recorded_noise(path: str | Path) -> Array | None:
    """Standard deviation of the torque error of each joint [N·m or N] in a file of ``dynident identify``.

    Args:
        path: NPZ of ``--npz`` (of ``dynident payload`` too) or JSON of ``--json``.

    Returns:
        Shape (n,); None if an NPZ file carries no weights.

    Raises:
        InputError: if the file is neither.
    """
    if not _is_npz(path):
        return np.asarray(1.0 / read_stored_robot(path).estimate.weights)
    Equations.load(path)
    with np.load(path, allow_pickle=False) as data:
        return np.asarray(1.0 / data["weights"]) if "weights" in data else None


def read_information(path: str | Path, noise: Array | None) -> Information:
    """Read what recordings have taught.

    Args:
        path: NPZ of ``--npz`` of ``dynident identify`` or ``payload``, or JSON of ``identify --json``.
        noise: torque noise per joint that rows are divided by [N·m or N], shape (n,); None for rows as they are.

    Raises:
        InputError: if the file does not fit, or a JSON is asked for rows without weights.
    """
    if _is_npz(path):
        problem = Equations.load(path)
        if noise is not None and len(noise) != len(problem.factors):
            raise InputError(f"{path}: is of a robot with {len(problem.factors)} joints, not {len(noise)}")
        rows = problem.stacked(None if noise is None else 1.0 / noise)[:, :-1]
        independent = np.sqrt(sum(problem.effective_rows) / problem.equations)
        return Information(problem.columns, triangular(independent * rows))
    if noise is None:
        raise InputError(
            f"{path}: a covariance holds no unweighted rows, which condition numbers need: give the --npz of "
            "'dynident identify'"
        )
    estimate = read_stored_robot(path).estimate
    try:
        lower = np.linalg.cholesky(estimate.covariance)
    except np.linalg.LinAlgError:
        raise InputError(f"{path}: the covariance is not positive definite") from None
    return Information(estimate.names, triangular(np.linalg.inv(lower)))


def _is_npz(path: str | Path) -> bool:
    """Whether the file is NPZ rather than JSON."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if path.suffix.lower() == ".npz":
        return True
    text = read_text(path)
    try:
        json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{path}: neither an NPZ nor a JSON of 'dynident identify' ({error})") from None
    return False
