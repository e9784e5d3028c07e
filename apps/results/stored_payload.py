"""The documents of ``dynident payload`` and ``dynident weigh``, which ``dynident export`` reads."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from msgspec import UNSET, UnsetType, field

from ...common.schema import LARGEST, Document, Matrix, Vector, WrongKeyError, read_json
from .parts import (
    ActiveDocument,
    EliminationDocument,
    GainErrorsDocument,
    Interval,
    Number,
    ProcessingDocument,
    ResidualDocument,
    RobustDocument,
    Ten,
    VerdictDocument,
)

_Intervals = Mapping[str, Interval]
_REMEDY = "give the --json of 'dynident payload' or 'dynident weigh'"


class FreeEstimate(Document, frozen=True, tag_field="estimator", tag="wls"):
    """A payload as a method sees it, about the origin of the frame; as far as its torques determine it."""

    method: int
    parameters: Ten
    sigma: Ten | UnsetType = UNSET
    sigma_robust: Ten | UnsetType | None = UNSET
    interval95: _Intervals | UnsetType | None = UNSET
    interval95_robust: _Intervals | UnsetType | None = UNSET
    robust: RobustDocument | UnsetType = UNSET
    com: Vector | UnsetType | None = UNSET
    com_sigma: Vector | UnsetType | None = UNSET
    com_sigma_robust: Vector | UnsetType | None = UNSET
    inertia_com: Matrix | UnsetType | None = UNSET
    inertia_com_sigma: Matrix | UnsetType | None = UNSET
    inertia_com_sigma_robust: Matrix | UnsetType | None = UNSET
    min_pseudo_inertia_eigenvalue: Number | UnsetType = UNSET
    physically_consistent: bool | UnsetType | None = UNSET
    relative_residual: Number | UnsetType = UNSET


class WeighedDocument(Document, frozen=True):
    """A weighed mass beside the identified one [kg]."""

    mass: float
    sigma: float
    identified: float
    identified_sigma: float
    degrees_of_freedom: Number
    z: Number
    p_value: Number


class PossibleEstimate(Document, frozen=True, tag_field="estimator", tag="constrained"):
    """The nearest payload that can exist, with 95 % intervals."""

    method: int
    parameters: Ten
    sigma: Ten | UnsetType = UNSET
    sigma_robust: Ten | UnsetType | None = UNSET
    sigma_with_gains: Ten | UnsetType | None = UNSET
    gain_sigma: GainErrorsDocument | UnsetType | None = UNSET
    interval95: _Intervals | UnsetType | None = UNSET
    interval95_by: Literal["jackknife", "memory", "formula"] | UnsetType = UNSET
    com: Vector | UnsetType = UNSET
    com_interval95: Matrix | UnsetType = UNSET
    inertia_com: Matrix | UnsetType = UNSET
    inertia_com_interval95: tuple[Matrix, ...] | UnsetType = UNSET
    principal_moments: Vector | UnsetType = UNSET
    principal_moments_interval95: Matrix | UnsetType = UNSET
    min_pseudo_inertia_eigenvalue: float | UnsetType = UNSET
    physically_consistent: bool | UnsetType = UNSET
    constraints: tuple[str, ...] | UnsetType = UNSET
    active: tuple[ActiveDocument, ...] | UnsetType = UNSET
    chi2_rise: float | UnsetType = UNSET
    p_value: Number | UnsetType = UNSET
    conflict: bool | UnsetType = UNSET
    weighed: tuple[WeighedDocument, ...] | UnsetType = UNSET
    solver_status: str | UnsetType = UNSET


class PayloadData(Document, frozen=True):
    """The equations behind a payload."""

    equations: int
    rate: Number = field(name="rate_hz")
    cutoff: Number = field(name="cutoff_hz")
    lag_s: Number
    lags_s: tuple[float, ...]
    max_position_mismatch_rad: Number
    condition_number: Number
    condition_number_scaled: Number
    equations_loaded: int | UnsetType = UNSET
    base_parameters: int | UnsetType = UNSET


class JointsMassDocument(Document, frozen=True):
    """The mass [kg] by some joints alone, and a single joint's factor on what the others show."""

    joints: tuple[int, ...]
    visible: bool
    mass: Number
    sigma: Number
    interval95: Interval | None
    share: Number | UnsetType = UNSET
    share_sigma: Number | UnsetType = UNSET


class Recommended(Document, frozen=True):
    """The estimate to use, and why that method's where there are others."""

    method: int
    estimator: Literal["wls", "constrained"] | UnsetType = UNSET
    reason: str = ""


class Assumed(Document, frozen=True):
    """An inertia that was not measured but asked for, and the ten with it."""

    inertia: str
    parameters: Ten


class VisibilityDocument(Document, frozen=True):
    """Which of the ten the torques of some joints show."""

    joints: tuple[int, ...]
    rank: int
    parameters: dict[str, str]
    combinations: tuple[str, ...]


class RippleDocument(Document, frozen=True):
    """A wave over the turn of a joint in one recording, and the probability of any such wave in noise alone."""

    source: str
    joint: int
    waves: float = field(name="waves_per_turn")
    amplitude: float
    probability_by_noise: float


class QuantityDocument(Document, frozen=True):
    """Mass, centre of mass or inertia: whether to use it, its value, 95 % interval and standard deviation."""

    use: str
    why: str | None
    value: Any
    interval95: Any
    sigma: Any


class RepeatsDocument(Document, frozen=True):
    """The mass [kg] by each recording alone, how much more it scatters than it should, and how it drifts."""

    sources: tuple[str, ...]
    masses: tuple[Number, ...]
    sigmas: tuple[Number, ...]
    spread: Number
    excess: Number
    drift_per_recording: Number
    drift_sigma: Number
    drifts: bool


class ConstantTorques(Document, frozen=True):
    """Joints whose constant torque was held near zero, and by which standard deviation [N·m]."""

    joints: tuple[int, ...]
    sigma: Vector


class AgreementDocument(Document, frozen=True):
    """Another way to the mass [kg] and the centre of mass [m]."""

    name: str
    mass: Number
    com: Vector


class FlangeDocument(Document, frozen=True):
    """Where the maker's flange stands in the payload's frame, if that is another one, and who says so."""

    xyz: Vector
    rpy_deg: Vector
    source: str

    def __post_init__(self) -> None:
        """Refuse what is no place."""
        for name in ("xyz", "rpy_deg"):
            values = getattr(self, name)
            if len(values) != 3 or not np.all(np.abs(values) <= LARGEST):
                raise WrongKeyError(name, "must be three finite numbers")


class StoredPayload(Document, frozen=True, kw_only=True):
    """A payload by the methods that were used, and what only a weighing by a short motion tells.

    ``frame`` is where it is given, in words; ``assumed`` an inertia that was asked for instead of a measured one.
    """

    robot: str | UnsetType = UNSET
    frame: str
    flange_in_payload_frame: FlangeDocument | UnsetType = UNSET
    rated_payload_kg: Number | UnsetType = UNSET
    processing: ProcessingDocument | UnsetType = UNSET
    relative_residual: ResidualDocument | UnsetType = UNSET
    data: PayloadData | UnsetType = UNSET
    estimates: tuple[FreeEstimate | PossibleEstimate, ...]
    recommended: Recommended | None = None
    mass_by_joints: tuple[JointsMassDocument, ...] | UnsetType = UNSET
    essential: EliminationDocument | UnsetType | None = UNSET
    left_out: dict[str, str] | UnsetType = UNSET
    verdict: VerdictDocument
    joints: tuple[int, ...] | UnsetType = UNSET
    visibility: VisibilityDocument | UnsetType = UNSET
    constant_torques: ConstantTorques | UnsetType = UNSET
    ripple: tuple[RippleDocument, ...] | UnsetType = UNSET
    quantities: dict[str, QuantityDocument] | UnsetType = UNSET
    mass_from_scale: bool | UnsetType = UNSET
    agreement: tuple[AgreementDocument, ...] | UnsetType = UNSET
    repeats: RepeatsDocument | UnsetType | None = UNSET
    assumed: Assumed | UnsetType | None = UNSET


def read_stored_payload(path: str | Path) -> StoredPayload:
    """Read the JSON of ``dynident payload`` or ``dynident weigh``.

    Raises:
        InputError: if the file is no such JSON; the key at fault is named.
    """
    return read_json(path, StoredPayload, _REMEDY)
