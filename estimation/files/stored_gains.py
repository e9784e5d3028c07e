"""The document of ``dynident gains``, which ``--drive-gains`` reads."""

from pathlib import Path

import numpy as np
from msgspec import UNSET, UnsetType, field

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import is_covariance
from ...common.schema import Document, Matrix, Vector, WrongKeyError, naming, present, read_json
from ...model import Robot
from ..fit.gain_recordings import GainRecordings
from .parts import ProcessingDocument, Recordings, ResidualDocument, RobustDocument, Ten

_REMEDY = "give the --json of 'dynident gains'"


class LoadDocument(Document, frozen=True):
    """The payload that the gains were identified with."""

    known: dict[str, float] | UnsetType = UNSET
    mass_sigma: float | UnsetType = UNSET
    identified: Ten | UnsetType = UNSET


class GainsTable(Document, frozen=True):
    """Gains [N·m/A or N/A], one for each joint, and the covariance of ln K, n x n."""

    values: Vector
    relative_covariance: Matrix
    sigma: Vector | UnsetType = UNSET
    relative_sigma: Vector | UnsetType = UNSET
    relative_sigma_formula: Vector | UnsetType = UNSET
    relative_sigma_robust: Vector | UnsetType | None = UNSET
    without_constraints: Vector | UnsetType | None = UNSET
    identified: tuple[bool, ...] | UnsetType = UNSET
    rests_on: tuple[str, ...] | UnsetType = UNSET


class StoredGains(Document, frozen=True):
    """Drive gains of a robot, and the recordings and the payload that they come from."""

    robot: str
    drive_gains: GainsTable
    processing: ProcessingDocument | UnsetType = UNSET
    load: LoadDocument | UnsetType = UNSET
    fingerprints: Recordings | UnsetType = field(default=UNSET, name="recordings")
    robust: RobustDocument | UnsetType = UNSET
    relative_residual: ResidualDocument | UnsetType = UNSET

    @property
    def values(self) -> Array:
        """Gains [N·m/A or N/A], shape (n,)."""
        return self.drive_gains.values

    @property
    def relative_covariance(self) -> Array:
        """Of ln K, n x n."""
        return self.drive_gains.relative_covariance

    @property
    def relative_sigma(self) -> Array:
        """Relative standard deviations, shape (n,)."""
        return np.sqrt(np.maximum(np.diag(self.relative_covariance), 0.0))

    @property
    def mass(self) -> float:
        """Mass of the known payload [kg]; nan in files of older versions."""
        load = present(self.load)
        return (present(load.known) or {}).get("M_L", float("nan")) if load else float("nan")

    @property
    def recordings(self) -> GainRecordings:
        """Recordings that the gains were identified from; empty in files of older versions."""
        return GainRecordings.read(present(self.fingerprints))

    def check(self, robot: Robot, path: str | Path) -> None:
        """Refuse gains of another robot.

        Raises:
            InputError: names both.
        """
        if self.robot != robot.name or len(self.values) != robot.n:
            raise InputError(
                f"{path}: gains of {self.robot!r} with {len(self.values)} joints do not belong to {robot.name!r} "
                f"with {robot.n}: identify gains for it"
            )


def read_stored_gains(path: str | Path) -> StoredGains:
    """Read the ``--json`` of ``dynident gains``.

    Raises:
        InputError: if the file holds no gains; the key at fault is named.
    """
    stored = read_json(path, StoredGains, _REMEDY)
    values, C = stored.values, stored.relative_covariance
    with naming(path, _REMEDY):
        if not (np.isfinite(values) & (values != 0.0)).all():
            raise WrongKeyError("drive_gains.values", "a gain is zero or null")
        if len(C) != len(values) or not is_covariance(C):
            raise WrongKeyError("drive_gains.relative_covariance", f"is no covariance of {len(values)} gains")
    return stored
