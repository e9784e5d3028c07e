"""Documents of ``dynident identify`` and ``dynident gains``, and what they tell later runs."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec import UNSET, UnsetType, field

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import is_covariance
from ...common.schema import Document, Matrix, Vector, WrongKeyError, at, naming, present, read_json
from ...estimation.equations.equations import PAYLOAD, Equations, triangular
from ...estimation.fit.covariance import RobustCovariance
from ...estimation.fit.drive_gains import Fingerprints, Gains
from ...estimation.fit.estimate import Estimate, Fit
from ...model import Robot
from .parts import (
    EliminationDocument,
    GainErrorsDocument,
    Number,
    ParameterDocument,
    PossibleRobotDocument,
    ProcessingDocument,
    ResidualDocument,
    RobustDocument,
    RolloutDocument,
    Ten,
    VerdictDocument,
)

_OF_GAINS = "give the --json of 'dynident gains'"


class MountingDocument(Document, frozen=True):
    """The payload as identified in one of several mountings."""

    mounting: int
    identified: Ten


class LoadDocument(Document, frozen=True):
    """The payload that the gains were identified with; ``identified`` in the first mounting."""

    known: dict[str, float] | UnsetType = UNSET
    mass_sigma: float | UnsetType = UNSET
    identified: Ten | UnsetType = UNSET
    mountings: tuple[MountingDocument, ...] | UnsetType = UNSET


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
    fingerprints: Fingerprints | UnsetType = field(default=UNSET, name="recordings")
    robust: RobustDocument | UnsetType = UNSET
    relative_residual: ResidualDocument | UnsetType = UNSET
    disagreement: float | UnsetType = UNSET
    verdict: VerdictDocument | UnsetType = UNSET


def read_stored_gains(path: str | Path) -> Gains:
    """Read the ``--json`` of ``dynident gains``.

    Raises:
        InputError: if the file holds no gains, the key at fault is named; or if their own verdict is against them.
    """
    stored = read_json(path, StoredGains, _OF_GAINS)
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


_OF_ROBOT = "give the --json of 'dynident identify'"


class RobotData(Document, frozen=True):
    """The equations behind an identification."""

    rows_per_joint: tuple[int, ...]
    degrees_of_freedom: float
    error_norms: Vector
    torque_norms: Vector
    weights: Vector
    equations: int | UnsetType = UNSET


class StoredRobot(Document, frozen=True, kw_only=True, dict=True):
    """A robot's base parameters and what they belong to; ``fingerprint`` is of its description with its drives."""

    robot: str
    fingerprint: str = field(name="robot_fingerprint")
    processing: ProcessingDocument
    data: RobotData
    columns: tuple[str, ...]
    covariance: Matrix
    covariance_robust: Matrix | None
    robust: RobustDocument | None
    base_parameters: tuple[ParameterDocument, ...]
    elimination: EliminationDocument | UnsetType = UNSET
    constrained: PossibleRobotDocument | None = None
    chi2_by: str | UnsetType = UNSET
    condition_number: Number | UnsetType = UNSET
    condition_number_scaled: Number | UnsetType = UNSET
    gain_sensitivity: Matrix | None
    gain_sigma: GainErrorsDocument | None = None
    relative_residual: ResidualDocument | UnsetType = UNSET
    validation: ResidualDocument | UnsetType | None = UNSET
    rollouts: tuple[RolloutDocument, ...] | UnsetType = UNSET
    reasons_against_use: tuple[str, ...] | UnsetType = UNSET

    @property
    def drive_gains(self) -> tuple[float, ...] | None:
        """Torque per current [N·m/A] with which currents were read; None for torques."""
        return present(self.processing.drive_gains) or None

    @cached_property
    def gains(self) -> Gains | None:
        """Uncertainty of the drive gains that was given then; None where they were taken as exact."""
        stored = self.gain_sigma
        if stored is None:
            return None
        recordings, identified = present(stored.recordings) or {}, present(stored.identified) or ()
        known = recordings, present(stored.mass)
        return Gains(stored.per_joint, stored.common, identified, *known, assumed=bool(present(stored.assumed)))

    @cached_property
    def estimate(self) -> Estimate:
        """Values and covariance.

        Raises:
            WrongKeyError: if numbers do not fit each other.
        """
        data, gains = self.data, self.gains
        with at("base_parameters"):
            return Estimate(
                names=self.columns,
                values=np.array([parameter.value for parameter in self.base_parameters]),
                covariance=self.covariance,
                degrees_of_freedom=data.degrees_of_freedom,
                fit=Fit(data.error_norms, data.torque_norms, data.rows_per_joint),
                weights=data.weights,
                robust=self._robust(),
                gain_sensitivity=self.gain_sensitivity,
                gain_covariance=gains.covariance(len(data.rows_per_joint)) if gains is not None else None,
            )

    @property
    def possible_values(self) -> Array:
        """Base parameters of the nearest robot that can exist, where they were stored, else the free ones."""
        robot = self.constrained
        stored = present(robot.base_parameters) if robot is not None else None
        if stored is None:
            return self.estimate.values
        return np.array([parameter.value for parameter in stored])

    def _robust(self) -> RobustCovariance | None:
        """Robust covariance, none where the recordings did not allow one."""
        C, stored = self.covariance_robust, self.robust
        if C is None:
            return None
        blocks, length = (stored.blocks, present(stored.block_length)) if stored else (None, None)
        degrees = present(stored.degrees_of_freedom) if stored else None
        if blocks is None or length is None or degrees is None:
            raise WrongKeyError("robust", "must hold blocks, degrees_of_freedom and block_length_s")
        if not (np.diag(C) >= 0.0).all():
            raise WrongKeyError("covariance_robust", "variances must not be negative")
        return RobustCovariance(C, blocks, degrees, length)

    @property
    def nearest_prior(self) -> PossibleRobotDocument | None:
        """The robot nearest to a prior, where it was stored."""
        robot = self.constrained
        return robot if robot is not None and robot.gauge == "prior" else None

    def applied_to(self, robot: Robot) -> Robot:
        """The robot with the model structure under which the parameters were identified.

        Raises:
            InputError: if the file is another robot's, or the robot's description has changed.
        """
        if robot.name != self.robot:
            raise InputError(
                f"the stored parameters are of robot {self.robot!r}, not {robot.name!r}: give those of "
                f"'dynident identify --robot {robot.name}'"
            )
        robot = robot.with_offsets(self.processing.offsets is True)
        coulomb = present(self.processing.coulomb)
        if coulomb is not None and robot.coupling is not None:
            robot = robot.with_coulomb(coulomb)
        if robot.fingerprint != self.fingerprint:
            raise InputError(
                f"the stored parameters are of a {robot.name} with other geometry, gravity or drives than this "
                "description: identify the robot again"
            )
        return robot

    def check_gains(self, drive_gains: tuple[float, ...] | None) -> None:
        """Refuse other drive gains than those the parameters were identified with."""
        if drive_gains != self.drive_gains:
            raise InputError(
                f"the stored parameters were identified with {_gains(self.drive_gains)}, recordings are now read "
                f"with {_gains(drive_gains)}: use the same"
            )


def _gains(gains: tuple[float, ...] | None) -> str:
    return f"drive gains {','.join(f'{gain:g}' for gain in gains)}" if gains else "torques, no drive gains"


def read_stored_robot(path: str | Path) -> StoredRobot:
    """Read the JSON of ``dynident identify``.

    Raises:
        InputError: if the file is not such a JSON; the key at fault is named.
    """
    stored = read_json(path, StoredRobot, _OF_ROBOT)
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


def _is_npz(path: str | Path) -> bool:
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    return Path(path).suffix.lower() == ".npz"
