"""Parts that results share: settings, residuals, parameters, elimination; each result is its own document.

Keys without a default are needed to read a document; those with one are absent where there is nothing to say. null
stands for a number that was not determined. All in SI units.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from msgspec import UNSET, Meta, UnsetType, field

from ...common.schema import Document, Vector
from ...model import BaseParameters, Processing, Robot
from ...model.friction import term_names
from ..fit.covariance import RobustCovariance
from ..fit.estimate import Estimate
from ..fit.linear_problem import Elimination, SigmaRatio

Number = float | None  # number that is null where it was not determined
Ten = Mapping[str, Number]  # numbers of the ten parameters by name, XX to M
Interval = tuple[Number, Number]
Sigma = Annotated[float, Meta(ge=0.0)]


class ProcessingDocument(Document, frozen=True):
    """Settings, so that a result can be repeated."""

    drive_gains: tuple[float, ...] | UnsetType | None = UNSET
    offsets: bool | UnsetType = UNSET
    friction: tuple[str, ...] | UnsetType = UNSET
    coulomb: Literal["sum", "paper"] | UnsetType | None = UNSET
    rate: Number | UnsetType = field(default=UNSET, name="rate_hz")
    cutoff: Number | UnsetType = field(default=UNSET, name="cutoff_hz")
    decimate: int | UnsetType = UNSET
    equation_rate: Number | UnsetType = field(default=UNSET, name="equations_hz")
    still_speed: float | UnsetType = UNSET
    slow_fraction: float | UnsetType = UNSET
    slow_speed: float | tuple[float, ...] | UnsetType = UNSET
    max_mismatch: float | UnsetType = UNSET
    torque_side: Literal["motor", "link"] | UnsetType = UNSET

    @classmethod
    def made(cls, robot: Robot, processing: Processing, drive_gains: Sequence[float]) -> Self:
        """Collect settings of recordings; ``drive_gains``: torque per current, empty for torques."""
        return cls.of(
            processing,
            equation_rate=UNSET if processing.equation_rate is None else processing.equation_rate,
            drive_gains=tuple(drive_gains) or None,
            offsets=robot.drives.offsets,
            friction=term_names(robot.drives.friction),
            coulomb=robot.coupling.coulomb if robot.coupling else None,
            torque_side=robot.drives.side,
        )


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
    by_memory: bool | UnsetType = UNSET

    @classmethod
    def made(cls, robust: RobustCovariance | None, reason: str) -> Self:
        """State the basis of a covariance; ``reason``: why there is none."""
        if robust is None:
            return cls(None, unavailable=reason or None)
        return cls.of(robust, warning=robust.warning or None, by_memory=robust.by_memory or UNSET)


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

    @classmethod
    def rows(cls, estimate: Estimate, **columns: Any) -> tuple[Self, ...]:
        """Make one row a parameter, with further columns."""
        own = ("sigma", "relative_sigma_percent", "sigma_robust", "sigma_by_gains")
        every = columns | {"value": estimate.values, **{name: getattr(estimate, name) for name in own}}
        there = {key: [None] * len(estimate.names) if column is None else column for key, column in every.items()}
        return tuple(cls(**dict(zip(there, row, strict=True))) for row in zip(*there.values(), strict=True))


class EliminationStep(Document, frozen=True):
    """The parameter that a step left out, and what followed."""

    eliminated: str | None
    remaining: int
    sigma_ratio: Number
    largest_relative_sigma_percent: Number


class EliminationDocument(Document, frozen=True):
    """Essential parameters, the steps to them, and what they are without the others.

    Their sigmas take the others as zero and know nothing of the bias that this brings: intervals are those with all
    parameters (``base_parameters``).
    """

    rule: Literal["ratio", "sigma"]
    description: str
    essential: int
    sigma_ratio: Number
    largest_relative_sigma_percent: Number
    relative_residual: Number
    parameters: tuple[ParameterDocument, ...]
    path: tuple[EliminationStep, ...]
    warnings: tuple[str, ...]
    limit: float | UnsetType = UNSET

    @classmethod
    def made(cls, elimination: Elimination, warnings: Sequence[str], base: BaseParameters) -> Self:
        """Collect the essential parameters, each step to them, and what speaks against them."""
        labels = dict(zip(base.columns, base.names, strict=True))  # "MX2" -> "MX2R"
        estimate, path = elimination.estimate, list[EliminationStep]()
        steps = zip((None, *elimination.order), elimination.path.tolist(), strict=True)
        for gone, (name, (ratio, sigma)) in enumerate(steps):
            label = labels.get(name, name) if name else None
            path.append(EliminationStep(label, len(elimination.order) - gone, ratio, 100.0 * sigma))
        return cls.of(
            path[len(elimination.eliminated)],
            elimination.rule,
            rule="ratio" if isinstance(elimination.rule, SigmaRatio) else "sigma",
            essential=len(elimination.essential),
            relative_residual=estimate.fit.relative,
            parameters=ParameterDocument.rows(estimate, name=[labels.get(name, name) for name in estimate.names]),
            path=tuple(path),
            warnings=tuple(warnings),
        )


class ActiveDocument(Document, frozen=True):
    """A constraint that holds an estimate back."""

    multiplier: float
    description: str | UnsetType = UNSET
    constraint: str | UnsetType = UNSET
    p_value: Number | UnsetType = UNSET
