"""Parts of the JSON documents that later runs read again.

Keys without a default are needed to read a document; those with one are absent where there is nothing to
say. null stands for a number that was not determined. All in SI units.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, Meta, UnsetType, field

from ...common.schema import Document, Vector, present
from ...estimation.fit.drive_gains import Fingerprints

Number = float | None
"""null where it was not determined."""
Ten = Mapping[str, Number]
"""Numbers of the ten parameters by name, XX to M."""
Interval = tuple[Number, Number]
Sigma = Annotated[float, Meta(ge=0.0)]
_Share = Annotated[float, Meta(ge=0.0, lt=1.0)]


class ProcessingDocument(Document, frozen=True):
    """Settings, so that a result can be repeated."""

    drive_gains: tuple[float, ...] | UnsetType | None = UNSET
    offsets: bool | UnsetType = UNSET
    coulomb: Literal["sum", "paper"] | UnsetType | None = UNSET
    rate: Number | UnsetType = field(default=UNSET, name="rate_hz")
    cutoff: Number | UnsetType = field(default=UNSET, name="cutoff_hz")
    decimate: int | UnsetType = UNSET
    equation_rate: Number | UnsetType = field(default=UNSET, name="equations_hz")
    still_speed: float | UnsetType = UNSET
    slow_fraction: float | UnsetType = UNSET
    slow_speed: float | tuple[float, ...] | UnsetType = UNSET
    max_mismatch: float | UnsetType = UNSET


class ResidualDocument(Document, frozen=True):
    """Norm of what a model leaves unexplained over that of the torque, of all joints and of each."""

    relative: Number = field(name="all")
    relative_per_joint: Vector | None = field(name="per_joint")
    validation: "ResidualDocument | UnsetType | None" = UNSET


class RobustDocument(Document, frozen=True):
    """Basis of robust standard deviations, or why there are none."""

    blocks: int | None
    block_length: float | UnsetType = field(default=UNSET, name="block_length_s")
    degrees_of_freedom: int | UnsetType = UNSET
    warning: str | UnsetType | None = UNSET
    unavailable: str | UnsetType | None = UNSET


class VerdictDocument(Document, frozen=True):
    """Use that may be made of the numbers, and what speaks against them."""

    level: Literal["use", "mass_and_com_only", "identified_only", "do_not_use"]
    reasons: tuple[str, ...]
    notes: tuple[str, ...] | UnsetType = UNSET


class GainErrorsDocument(Document, frozen=True):
    """Relative errors of drive gains; of identified ones also covariance, recordings and payload."""

    per_joint: tuple[_Share, ...]
    common: _Share
    identified: tuple[tuple[float, ...], ...] | UnsetType = UNSET
    recordings: Fingerprints | UnsetType = UNSET
    mass: Number | UnsetType = UNSET
    notes: tuple[str, ...] | UnsetType = UNSET
    assumed: bool | UnsetType = UNSET


class ParameterDocument(Document, frozen=True):
    """A base parameter with its uncertainty."""

    value: float
    name: str | UnsetType = UNSET
    grouping: str | UnsetType = UNSET
    sigma: Sigma | UnsetType = UNSET
    relative_sigma_percent: Number | UnsetType = UNSET
    sigma_robust: Number | UnsetType = UNSET
    interval95: Interval | UnsetType = UNSET
    interval95_robust: Interval | UnsetType | None = UNSET
    sigma_by_gains: Number | UnsetType = UNSET
    interval95_with_gains: Interval | UnsetType | None = UNSET
    essential: bool | UnsetType = UNSET


class EliminationStep(Document, frozen=True):
    """The parameter that a step left out, and what followed."""

    eliminated: str | None
    remaining: int
    sigma_ratio: Number
    largest_relative_sigma_percent: Number


class EliminationDocument(Document, frozen=True):
    """How essential parameters were found, and what they are without the others."""

    rule: Literal["ratio", "sigma"]
    description: str
    essential: int
    sigma_ratio: Number
    largest_relative_sigma_percent: Number
    relative_residual: Number
    parameters: tuple[ParameterDocument, ...]
    path: tuple[EliminationStep, ...]
    warnings: tuple[str, ...]


class ActiveDocument(Document, frozen=True):
    """A constraint that holds an estimate back."""

    multiplier: float
    description: str | UnsetType = UNSET
    constraint: str | UnsetType = UNSET
    p_value: Number | UnsetType = UNSET


class PossibleParameter(Document, frozen=True):
    """A parameter of a robot that can exist: how far it was moved, or who decides it."""

    name: str
    value: float
    free: float | UnsetType = UNSET
    moved_in_sigma: Number | UnsetType = UNSET
    kind: Literal["identified", "combination", "prior"] | UnsetType = UNSET
    base: tuple[str, ...] | UnsetType = UNSET
    share: float | UnsetType = UNSET
    decided_by: str | UnsetType = UNSET


class PriorDocument(Document, frozen=True):
    """The prior that a robot was kept near to."""

    source: str
    budget: float | UnsetType = UNSET
    weight: Number | UnsetType = UNSET
    distances: tuple[float, ...] | UnsetType = UNSET


class HorizonDocument(Document, frozen=True):
    """Errors some time after the start, by what predicted the motion: median and 90 % of the starts [rad or m]."""

    seconds: float
    in_motion: dict[str, tuple[Number, Number]] | None
    at_rest: dict[str, tuple[Number, Number]] | None


class RolloutDocument(Document, frozen=True):
    """How far predicted motion strays from a recording's; the torque error of a controller on its path."""

    source: str
    starts_in_motion: int
    starts_at_rest: int
    diverged: int
    horizons: tuple[HorizonDocument, ...]
    growth: Number
    replay_relative: float
    replay_joints: Vector
    replay_strayed: float


class PossibleRobotDocument(Document, frozen=True):
    """The nearest robot that can exist: its base parameters, and with a prior the standard ones."""

    gauge: Literal["base", "prior"]
    chi2_rise: float
    status: str | UnsetType = UNSET
    p_value: Number | UnsetType = UNSET
    active: tuple[ActiveDocument, ...] | UnsetType = UNSET
    min_eigenvalues: dict[str, float] | UnsetType = UNSET
    base_parameters: tuple[PossibleParameter, ...] | UnsetType = UNSET
    unidentifiable: tuple[str, ...] | UnsetType = UNSET
    prior: PriorDocument | UnsetType = UNSET
    parameters: tuple[PossibleParameter, ...] | UnsetType = UNSET

    @property
    def standard(self) -> dict[str, float]:
        """The standard parameters by name."""
        return {parameter.name: parameter.value for parameter in present(self.parameters) or ()}

    @property
    def source(self) -> str:
        """Where the prior comes from; empty without one."""
        prior = present(self.prior)
        return prior.source if prior else ""
