"""Results that runs leave in files for others: robots, gains, payloads, equations and the information in them."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import InputError
from ..common.files import write_bytes
from ..common.linear import is_covariance
from ..common.schema import WrongKeyError, naming, read_json
from ..estimation.answers.system import ObservationSystem
from ..estimation.results.payload import PayloadResult
from ..estimation.results.robot import GainsResult, RobotResult

_OF_GAINS = "give the file that --json of 'dynident gains' wrote"
_OF_ROBOT = "give the file that --json of 'dynident identify' wrote"


def read_stored_payload(path: str | Path) -> PayloadResult:
    """Read the JSON of ``dynident payload`` or ``dynident weigh``."""
    return read_json(
        path, PayloadResult, "give the file that --json of 'dynident payload' or 'dynident weigh' wrote"
    )


def read_stored_gains(path: str | Path) -> GainsResult:
    """Read the ``--json`` of ``dynident gains``, unless its own verdict is against these gains."""
    stored = read_json(path, GainsResult, _OF_GAINS)
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


def read_stored_robot(path: str | Path) -> RobotResult:
    """Read the JSON of ``dynident identify``."""
    stored = read_json(path, RobotResult, _OF_ROBOT)
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
