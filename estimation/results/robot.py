"""Results of ``identify`` and ``gains``, and what they tell later runs."""

from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
from msgspec import UNSET, UnsetType, field

from ...common import Array, InputError, Speaks
from ...common.schema import Document, Float, Matrix, Vector, WrongKeyError, at, present
from ...model import BaseParameters, Robot
from ...model.friction import friction_terms
from ..diagnosis.evidence import Verdict
from ..fit.covariance import RobustCovariance
from ..fit.estimate import Estimate, Fingerprints, Fit, Gains, Parameter
from ..fit.own_equations import TermChoice
from ..possible.robot import PossibleRobot
from ..possible.whole_robot import PriorRobot
from . import parts
from .parts import ActiveDocument, Number, Ten


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


class Rollout(Document, frozen=True, kw_only=True, dict=True):
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
        free, more = result.free, dict[str, Any](prior=UNSET, parameters=UNSET)
        if isinstance(result, PriorRobot):
            bodies = enumerate(result.prior.bodies, start=1)
            reported = {f"{kind}{link}": x for link, body in bodies for kind, x in body.named().items()}
            source, rise = result.prior.source, result.nearest.chi2_rise
            more["prior"] = PriorDocument.of(result, source=source, nearest_chi2_rise=rise)
            every = ((name, value, result.origins[name]) for name, value in result.parameters.items())
            more["parameters"] = tuple(
                PossibleParameter.of(
                    origin, name=name, value=value, decided_by=origin.decided_by(), prior=reported.get(name, UNSET)
                )
                for name, value, origin in every
            )
        moved = (result.values - free.values) / free.sigma
        return cls.of(
            result,
            gauge="prior" if more["prior"] else "base",
            active=tuple(ActiveDocument(holding.multiplier, holding.description) for holding in result.active),
            min_eigenvalues={str(link): value for link, value in enumerate(result.min_eigenvalues, start=1)},
            base_parameters=tuple(map(PossibleParameter, base.names, result.values, free.values, moved)),
            **more,
        )


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


class GainsResult(Speaks, Document, frozen=True, kw_only=True, dict=True):
    """Drive gains of a robot, and the recordings and the payload that they come from."""

    kind: Literal["gains"] = "gains"
    version: Literal[1] = 1
    robot: str
    robot_title: str | UnsetType = UNSET
    drive_gains: GainsTable
    processing: parts.ProcessingDocument | UnsetType = UNSET
    load: LoadDocument | UnsetType = UNSET
    fingerprints: Fingerprints | UnsetType = field(default=UNSET, name="recordings")
    robust: parts.RobustDocument | UnsetType = UNSET
    relative_residual: parts.ResidualDocument | UnsetType = UNSET
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


class RobotResult(Speaks, Document, frozen=True, kw_only=True, dict=True):
    """Base parameters of a robot, and what they belong to; ``fingerprint`` is of its description and drives."""

    kind: Literal["robot"] = "robot"
    version: Literal[1] = 1
    robot: str
    robot_title: str | UnsetType = UNSET
    joints: tuple[Literal["revolute", "prismatic"], ...] | UnsetType = UNSET
    fingerprint: str = field(name="robot_fingerprint")
    processing: parts.ProcessingDocument
    data: RobotData
    columns: tuple[str, ...]
    covariance: Matrix
    covariance_robust: Matrix | None
    robust: parts.RobustDocument | None
    base_parameters: tuple[parts.ParameterDocument, ...]
    elimination: parts.EliminationDocument | UnsetType = UNSET
    constrained: PossibleRobotDocument | None = None
    friction: tuple[TermChoice, ...] | UnsetType = UNSET
    chi2_by: str | UnsetType = UNSET
    condition_number: Number | UnsetType = UNSET
    condition_number_scaled: Number | UnsetType = UNSET
    gain_sensitivity: Matrix | None
    gains: Gains | None = field(default=None, name="gain_sigma")
    relative_residual: parts.ResidualDocument | UnsetType = UNSET
    validation: parts.ResidualDocument | UnsetType | None = UNSET
    rollouts: tuple[Rollout, ...] | UnsetType = UNSET
    reasons_against_use: tuple[str, ...] | UnsetType = UNSET
    verdict: Verdict | UnsetType = UNSET

    @property
    def headline(self) -> str:
        """State robot, parameters and what they leave unexplained in a line."""
        relative = 100.0 * self.estimate.fit.relative
        return f"{self.robot}, {len(self.columns)} base parameters, {relative:.2f} % of the torque unexplained"

    @property
    def judged(self) -> Verdict:
        """Verdict; of a file that holds none by its reasons."""
        reasons = present(self.reasons_against_use) or ()
        return present(self.verdict) or Verdict("do_not_use" if reasons else "use", reasons)

    @property
    def essential(self) -> tuple[str, ...]:
        """Columns of the essential parameters."""
        rows = zip(self.columns, self.base_parameters, strict=True)
        return tuple(name for name, row in rows if row.essential is True)

    @property
    def title(self) -> str:
        """Title of the robot, or its name."""
        return self.robot_title or self.robot

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
                given = stored or parts.RobustDocument(None)
                blocks, length, degrees = (
                    given.blocks,
                    present(given.block_length),
                    present(given.degrees_of_freedom),
                )
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
