"""Parts that several results have.

Keys without a default are needed to read a document; those with one are absent where there is nothing to
say. null stands for a number that was not determined. All in SI units.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from msgspec import UNSET, Meta, UnsetType, field

from ...common.schema import Document, Float, Vector, Worked, present
from ...common.speech import Speaks
from ...model import BaseParameters, Processing, Robot
from ...model.friction import term_names
from ..fit.covariance import RobustCovariance
from ..fit.estimate import Estimate
from ..fit.linear_problem import Elimination, SigmaRatio
from ..possible.robot import PossibleRobot, PriorRobot

Number = float | None  # number that is null where it was not determined
Ten = Mapping[str, Number]  # numbers of the ten parameters by name, XX to M
Interval = tuple[Number, Number]
Sigma = Annotated[float, Meta(ge=0.0)]


class Result(Speaks, Worked, frozen=True, kw_only=True, dict=True):
    """Answer to a whole question, its own document; ``working``: equations and estimates that it was made from."""


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
        rows: list[dict[str, Any]] = [
            {key: None if column is None else column[k] for key, column in every.items()}
            for k in range(len(estimate.names))
        ]
        return tuple(cls(**row) for row in rows)


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
    def made(cls, elimination: Elimination, warnings: Sequence[str], labels: Mapping[str, str]) -> Self:
        """Collect the essential parameters, each step to them, and what speaks against them.

        ``labels``: name of a column -> name of the parameter ("MX2" -> "MX2R").
        """
        estimate, numbers = elimination.estimate, (elimination.path * [1.0, 100.0]).tolist()
        order, (ratio, largest) = elimination.order, numbers[len(elimination.eliminated)]
        names = [None, *(labels.get(name, name) for name in order)]
        return cls.of(
            elimination,
            elimination.rule,
            rule="ratio" if isinstance(elimination.rule, SigmaRatio) else "sigma",
            essential=len(elimination.essential),
            sigma_ratio=ratio,
            largest_relative_sigma_percent=largest,
            relative_residual=estimate.fit.relative,
            parameters=ParameterDocument.rows(estimate, name=[labels.get(name, name) for name in estimate.names]),
            path=tuple(
                EliminationStep(name, len(order) - k, *pair)
                for k, (name, pair) in enumerate(zip(names, numbers, strict=True))
            ),
            warnings=tuple(warnings),
        )


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
    prior: float | UnsetType = UNSET


class PriorDocument(Document, frozen=True):
    """The prior that a robot was kept near to."""

    source: str
    budget: float | UnsetType = UNSET
    weight: Number | UnsetType = UNSET
    distances: tuple[float, ...] | UnsetType = UNSET
    nearest_chi2_rise: float | UnsetType = UNSET


class Horizon(Document, frozen=True):
    """Errors some time after the start, by what predicted the motion: median and 90 % of the starts [rad or m]."""

    seconds: float
    in_motion: dict[str, tuple[Float, Float]] | None
    at_rest: dict[str, tuple[Float, Float]] | None


class Rollout(Worked, frozen=True, kw_only=True, dict=True):
    """Distance of predicted motion from a recording's, and the replay: a controller that follows its path.

    ``working`` are the errors of every start.
    """

    source: str
    starts_in_motion: int
    starts_at_rest: int
    diverged: int  # starts after which the identified robot ran away altogether
    horizons: tuple[Horizon, ...]  # those beyond half the recording left out
    growth: Float  # median factor of an error of the start after half a second; nan if the recording is too short
    replay_relative: float  # norm of replayed less measured torque over that of the measured one, without slow rows
    replay_joints: Vector  # the same joint by joint, shape (n,); nan where nothing was measured
    replay_strayed: float  # root mean square distance from the path over all joints [rad or m]


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

    @classmethod
    def made(cls, result: PossibleRobot, base: BaseParameters) -> Self:
        """Collect base parameters, and with a prior the standard ones with who decides each."""
        free, prior = result.free, result if isinstance(result, PriorRobot) else None
        moved = (result.values - free.values) / free.sigma
        more: dict[str, Any] = {"prior": UNSET, "parameters": UNSET}
        if prior is not None:
            bodies = enumerate(prior.prior.bodies, start=1)
            reported = {f"{kind}{link}": x for link, body in bodies for kind, x in body.named().items()}
            source, rise = prior.prior.source, prior.nearest.chi2_rise
            more["prior"] = PriorDocument.of(prior, source=source, nearest_chi2_rise=rise)
            every = ((name, value, prior.origins[name]) for name, value in prior.parameters.items())
            more["parameters"] = tuple(
                PossibleParameter.of(
                    origin, name=name, value=value, decided_by=origin.decided_by(), prior=reported.get(name, UNSET)
                )
                for name, value, origin in every
            )
        return cls.of(
            result,
            gauge="base" if prior is None else "prior",
            active=tuple(ActiveDocument(holding.multiplier, holding.description) for holding in result.active),
            min_eigenvalues={str(link): value for link, value in enumerate(result.min_eigenvalues, start=1)},
            base_parameters=tuple(map(PossibleParameter, base.names, result.values, free.values, moved)),
            **more,
        )

    @property
    def standard(self) -> dict[str, float]:
        """Standard parameters by name."""
        return {parameter.name: parameter.value for parameter in present(self.parameters) or ()}

    @property
    def source(self) -> str:
        """Source of the prior; empty without one."""
        prior = present(self.prior)
        return prior.source if prior else ""
