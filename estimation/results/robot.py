"""Results of ``identify`` and ``gains``, what they tell later runs, and the parts that they share with others.

Each is its own document. Keys without a default are needed to read a document; those with one are absent where
there is nothing to say. null stands for a number that was not determined. All in SI units.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any, Literal, Self

import numpy as np
from msgspec import UNSET, Meta, UnsetType, field

from ...common import Array, InputError
from ...common.schema import Document, Float, Matrix, Vector, Worked, WrongKeyError, at, present
from ...common.speech import Speaks
from ...model import BaseParameters, Processing, Robot
from ...model.friction import friction_terms, term_names
from ..diagnosis.evidence import Verdict
from ..fit.covariance import RobustCovariance
from ..fit.estimate import Estimate, Fingerprints, Fit, Gains, Parameter
from ..fit.linear_problem import Elimination, SigmaRatio
from ..fit.own_equations import TermChoice
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


class MountingDocument(Document, frozen=True):
    """Payload as identified in one of several mountings."""

    mounting: int
    identified: Ten


class LoadDocument(Document, frozen=True):
    """Payload that the gains were identified with; ``identified`` in the first mounting."""

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


class GainsResult(Result, frozen=True, kw_only=True, dict=True):
    """Drive gains of a robot, and the recordings and the payload that they come from."""

    kind: Literal["gains"] = "gains"
    version: Literal[1] = 1
    robot: str
    robot_title: str | UnsetType = UNSET
    drive_gains: GainsTable
    processing: ProcessingDocument | UnsetType = UNSET
    load: LoadDocument | UnsetType = UNSET
    fingerprints: Fingerprints | UnsetType = field(default=UNSET, name="recordings")
    robust: RobustDocument | UnsetType = UNSET
    relative_residual: ResidualDocument | UnsetType = UNSET
    disagreement: float | UnsetType = UNSET
    verdict: Verdict | UnsetType = UNSET

    @property
    def errors(self) -> Gains:
        """Errors of the gains as estimators take them."""
        load, C = present(self.load), self.drive_gains.relative_covariance
        mass = (present(load.known) or {}).get("M_L") if load else None
        return Gains(identified=C.tolist(), recordings=present(self.fingerprints) or {}, mass=mass)

    @property
    def judged(self) -> Verdict:
        """Verdict; "use" where a file holds none."""
        return present(self.verdict) or Verdict("use", ())

    @property
    def headline(self) -> str:
        """State robot, number of known gains and verdict in a line."""
        identified = present(self.drive_gains.identified) or ()
        known = f"{sum(identified)} of {len(self.drive_gains.values)} gains identified"
        return f"{self.robot}, {known}, {self.judged.level.replace('_', ' ')}"


class RobotData(Document, frozen=True):
    """Equations behind an identification."""

    rows_per_joint: tuple[int, ...]
    degrees_of_freedom: float
    error_norms: Vector
    torque_norms: Vector
    weights: Vector
    equations: int | UnsetType = UNSET
    torque_noise: Vector | UnsetType = UNSET
    independent: float | UnsetType = field(default=UNSET, name="independent_rate_hz")


class RobotResult(Result, frozen=True, kw_only=True, dict=True):
    """Base parameters of a robot, and what they belong to; ``fingerprint`` is of its description and drives."""

    kind: Literal["robot"] = "robot"
    version: Literal[1] = 1
    robot: str
    robot_title: str | UnsetType = UNSET
    joints: tuple[Literal["revolute", "prismatic"], ...] | UnsetType = UNSET
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
    friction: tuple[TermChoice, ...] | UnsetType = UNSET
    chi2_by: str | UnsetType = UNSET
    condition_number: Number | UnsetType = UNSET
    condition_number_scaled: Number | UnsetType = UNSET
    gain_sensitivity: Matrix | None
    gains: Gains | None = field(default=None, name="gain_sigma")
    relative_residual: ResidualDocument | UnsetType = UNSET
    validation: ResidualDocument | UnsetType | None = UNSET
    rollouts: tuple[Rollout, ...] | UnsetType = UNSET
    reasons_against_use: tuple[str, ...] | UnsetType = UNSET
    verdict: Verdict | UnsetType = UNSET

    @property
    def headline(self) -> str:
        """State robot, parameters and what they leave unexplained in a line."""
        relative = 100.0 * self.estimate.fit.relative
        return f"{self.robot}, {len(self.columns)} base parameters, {relative:.2f} % of the torque unexplained"

    @property
    def title(self) -> str:
        """Title of the robot."""
        return self.robot_title or self.robot

    @property
    def judged(self) -> Verdict:
        """Verdict; of a file that holds none by its reasons."""
        reasons = present(self.reasons_against_use) or ()
        return present(self.verdict) or Verdict("do_not_use" if reasons else "use", reasons)

    @property
    def essential(self) -> tuple[str, ...]:
        """Columns of the essential parameters."""
        return tuple(
            name for name, row in zip(self.columns, self.base_parameters, strict=True) if row.essential is True
        )

    @property
    def drive_gains(self) -> tuple[float, ...] | None:
        """Torque per current [N·m/A] with which currents were read; None for torques."""
        return present(self.processing.drive_gains) or None

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """Base parameters by their names in tables: ``result.parameters["MX2R"].sigma``."""
        names = (row.name or name for row, name in zip(self.base_parameters, self.columns, strict=True))
        return dict(zip(names, self.estimate.parameters, strict=True))

    def __getitem__(self, name: str) -> Parameter:
        """One base parameter by its name, "MX2R" or "MX2"."""
        found = self.parameters.get(name) or self.parameters.get(f"{name}R")
        if found is None:
            raise InputError(f"no parameter {name!r}: there are {', '.join(self.parameters)}")
        return found

    @cached_property
    def estimate(self) -> Estimate:
        """Values and covariance; a robust one where the recordings allowed it."""
        data, gains, C, stored, robust = self.data, self.gains, self.covariance_robust, self.robust, None
        with at("base_parameters"):
            if C is not None:
                blocks, length = (stored.blocks, present(stored.block_length)) if stored else (None, None)
                degrees = present(stored.degrees_of_freedom) if stored else None
                if blocks is None or length is None or degrees is None:
                    raise WrongKeyError("robust", "must hold blocks, degrees_of_freedom and block_length_s")
                if not (np.diag(C) >= 0.0).all():
                    raise WrongKeyError("covariance_robust", "variances must not be negative")
                robust = RobustCovariance(C, blocks, degrees, length)
            return Estimate(
                names=self.columns,
                values=np.array([parameter.value for parameter in self.base_parameters]),
                covariance=self.covariance,
                degrees_of_freedom=data.degrees_of_freedom,
                fit=Fit(data.error_norms, data.torque_norms, data.rows_per_joint),
                weights=data.weights,
                robust=robust,
                gain_sensitivity=self.gain_sensitivity,
                gain_covariance=gains.covariance(len(data.rows_per_joint)) if gains is not None else None,
            )

    @property
    def possible_values(self) -> Array:
        """Base parameters of the nearest robot that can exist, where they were stored, else the free ones."""
        stored = present(self.constrained.base_parameters) if self.constrained is not None else None
        return np.array([parameter.value for parameter in stored or self.base_parameters])

    def applied_to(self, robot: Robot) -> Robot:
        """Robot with the model structure under which the parameters were identified.

        Raises:
            InputError: if the file is another robot's, or the robot's description has changed.
        """
        if robot.name != self.robot:
            raise InputError(
                f"the stored parameters are of robot {self.robot!r}, not {robot.name!r}: give those of "
                f"'dynident identify --robot {robot.name}'"
            )
        robot = robot.with_offsets(self.processing.offsets is True)
        if terms := present(self.processing.friction):
            robot = robot.with_friction(friction_terms(terms))
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
            then, now = (
                f"drive gains {','.join(f'{gain:g}' for gain in gains)}" if gains else "torques, no drive gains"
                for gains in (self.drive_gains, drive_gains)
            )
            raise InputError(
                f"the stored parameters were identified with {then}, recordings are now read with {now}: use the "
                "same"
            )
