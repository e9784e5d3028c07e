"""Results that runs leave in files for others: robots, gains, payloads, equations and the information in them."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..common.files import write_bytes
from ..common.linear import is_covariance
from ..common.schema import WrongKeyError, naming, present, read_json
from ..estimation.answers.system import ObservationSystem
from ..estimation.equations.equations import PAYLOAD, Equations, triangular
from ..estimation.fit.drive_gains import Gains
from ..estimation.results.payload import PayloadResult
from ..estimation.results.robot import GainsResult, RobotResult

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


def _is_npz(path: str | Path) -> bool:
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    return Path(path).suffix.lower() == ".npz"
