"""Results that earlier runs left in files: robots, gains, payloads, information."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..common.linear import is_covariance
from ..common.schema import WrongKeyError, naming, present, read_json
from ..estimation.equations.equations import PAYLOAD, Equations, triangular
from ..estimation.fit.drive_gains import Gains
from ..estimation.results.payload import PayloadResult
from ..estimation.results.robot import GainsResult, RobotResult
from ..trajectories.design.goal import INDEPENDENT, MEMORY

_OF_GAINS = "give the --json of 'dynident gains'"
_OF_ROBOT = "give the --json of 'dynident identify'"
_OF_PAYLOAD = "give the --json of 'dynident payload' or 'dynident weigh'"


def read_stored_payload(path: str | Path) -> PayloadResult:
    """Read the JSON of ``dynident payload`` or ``dynident weigh``.

    Raises:
        InputError: if the file is no such JSON; the key at fault is named.
    """
    return read_json(path, PayloadResult, _OF_PAYLOAD)


def read_stored_gains(path: str | Path) -> Gains:
    """Read the ``--json`` of ``dynident gains``.

    Raises:
        InputError: if the file holds no gains, the key at fault is named; or if their own verdict is against them.
    """
    stored = read_json(path, GainsResult, _OF_GAINS)
    verdict = present(stored.verdict)
    if verdict is not None and verdict.level == "do_not_use":
        reason = verdict.reasons[0] if verdict.reasons else "no reason is told"
        raise InputError(
            f"{path}: the verdict on these drive gains is: do not use ({reason}); identify them again, or give the "
            "maker's as numbers with --gain-sigma"
        )
    values, C, load = stored.drive_gains.values, stored.drive_gains.relative_covariance, present(stored.load)
    with naming(path, _OF_GAINS):
        if not (np.isfinite(values) & (values != 0.0)).all():
            raise WrongKeyError("drive_gains.values", "a gain is zero or null")
        if len(C) != len(values) or not is_covariance(C):
            raise WrongKeyError("drive_gains.relative_covariance", f"is no covariance of {len(values)} gains")
    return Gains(
        identified=C.tolist(),
        recordings=present(stored.fingerprints) or {},
        mass=(present(load.known) or {}).get("M_L") if load else None,
        values=tuple(values.tolist()),
        robot=stored.robot,
    )


def read_stored_robot(path: str | Path) -> RobotResult:
    """Read the JSON of ``dynident identify``.

    Raises:
        InputError: if the file is not such a JSON; the key at fault is named.
    """
    stored = read_json(path, RobotResult, _OF_ROBOT)
    with naming(path, _OF_ROBOT):
        stored.estimate.names  # noqa: B018  numbers that do not fit each other are refused here
    return stored


class Information(NamedTuple):
    """R of a QR decomposition of an observation matrix W: what earlier recordings have taught, for the next motion.

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


def shown_noise(path: str | Path) -> tuple[Array, float]:
    """Torque errors of an earlier recording, what their memory adds included.

    Args:
        path: JSON of ``dynident identify``; NPZ of its ``--npz`` or ``payload``'s, whose memory is not known.

    Returns:
        Standard deviation of each joint [N·m or N], shape (n,), and independent samples a second [Hz].

    Raises:
        InputError: if the file is neither, or tells no errors.
    """
    if _is_npz(path):
        Equations.load(path)
        with np.load(path, allow_pickle=False) as data:
            if "weights" not in data:
                raise InputError(f"{path}: carries no weights: give --torque-noise, or --like JSON")
            return MEMORY / np.asarray(data["weights"]), INDEPENDENT
    stored = read_stored_robot(path)
    data, robust, memory, seconds = stored.data, stored.robust, MEMORY, 0.0
    if stored.covariance_robust is not None and robust is not None and robust.blocks:
        ratios = np.diag(np.array(stored.covariance_robust)) / np.diag(np.array(stored.covariance))
        memory, seconds = float(np.exp(0.5 * np.log(ratios).mean())), robust.blocks * (robust.block_length or 0.0)
    independent = (data.degrees_of_freedom + len(stored.columns)) / len(data.rows_per_joint)
    return memory / stored.estimate.weights, independent / seconds if seconds else INDEPENDENT


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
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    return Path(path).suffix.lower() == ".npz"
