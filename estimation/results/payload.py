"""Results of ``payload`` and ``weigh``: estimates, quantities with intervals, and whether to use them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np
from msgspec import UNSET, UnsetType, field
from msgspec.structs import replace

from ...common import Array, Brief, Document, Indices, InputError, Mask, Speaks, Vector
from ...common.schema import Matrix, Triple, present
from ...model import INERTIAL, InertialParameters, Pose
from ...model.inertia import payload_spread
from ..diagnosis.evidence import Agreement, Verdict
from ..equations.equations import Equations
from ..fit.covariance import autocorrelation
from ..fit.estimate import Gains
from ..fit.own_equations import TermChoice
from ..payload.by_joints import JointsMass, Repeats
from ..payload.methods import PREFERRED, ConstrainedPayload, PayloadEstimate
from ..payload.short_motion import Standing, Wave
from ..possible.payload import Weighing
from . import parts

_Intervals = Mapping[str, parts.Interval]
_SIZE = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_FORM = re.compile(rf"(box|cylinder):({_SIZE}(?:x{_SIZE})*)")


def numbers(ten: Mapping[str, Any] | UnsetType | None, *shape: int) -> Array:
    """Collect the ten, of a shape each such as intervals', in their order, nan where there is none, 10 x ..."""
    values = present(ten) or {}
    return np.array([array(values.get(kind), *shape) for kind in INERTIAL])


def array(values: Any, *shape: int) -> Array:
    """Make an array of numbers as they were made or read, nan where there is none."""
    return np.full(shape, np.nan) if present(values) is None else np.array(values, dtype=float)


def named(values: Array | None, indices: Sequence[int] = range(10)) -> Any:
    """Name numbers or intervals of some of the ten, nan for the others; None stays None."""
    if values is None:
        return None
    ten = np.full((len(INERTIAL), *values.shape[1:]), np.nan)
    ten[list(indices)] = values
    return dict(zip(INERTIAL, ten.tolist(), strict=True))


class MethodEstimate(Document, frozen=True, tag_field="estimator"):
    """A payload by one method, about the origin of the frame, as far as its torques determine it."""

    method: int
    parameters: parts.Ten
    sigma: parts.Ten | UnsetType = UNSET
    sigma_robust: parts.Ten | UnsetType | None = UNSET
    sigma_with_gains: parts.Ten | UnsetType | None = UNSET
    interval95: _Intervals | UnsetType | None = UNSET
    com: Vector | UnsetType | None = UNSET
    inertia_com: Matrix | UnsetType | None = UNSET
    min_pseudo_inertia_eigenvalue: parts.Number | UnsetType = UNSET
    physically_consistent: bool | UnsetType | None = UNSET
    weighed: tuple[Weighing, ...] | UnsetType = UNSET

    @property
    def ten(self) -> Array:
        """Ten parameters in their order, nan where not determined, shape (10,)."""
        return numbers(self.parameters)

    @property
    def larger_sigma(self) -> Array:
        """The larger of the formula's and the robust standard deviation of each of the ten, shape (10,)."""
        return np.fmax(numbers(self.sigma), numbers(self.sigma_robust))


class FreeEstimate(MethodEstimate, frozen=True, tag="wls"):
    """Payload by a method, whether or not a body can have it."""

    interval95_robust: _Intervals | UnsetType | None = UNSET
    robust: parts.RobustDocument | UnsetType = UNSET
    com_sigma: Vector | UnsetType | None = UNSET
    com_sigma_robust: Vector | UnsetType | None = UNSET
    inertia_com_sigma: Matrix | UnsetType | None = UNSET
    inertia_com_sigma_robust: Matrix | UnsetType | None = UNSET
    relative_residual: parts.Number | UnsetType = UNSET
    from_scale: bool | UnsetType = UNSET

    @classmethod
    def made(cls, result: PayloadEstimate) -> Self:
        """Collect what a method determines; positive definite inertia is not enough for a body that exists."""
        estimate, indices = result.estimate, result.indices
        own: dict[str, Any] = {
            "method": result.method,
            "parameters": named(estimate.values, indices),
            "sigma": named(estimate.sigma, indices),
            "sigma_robust": named(estimate.sigma_robust, indices),
            "robust": parts.RobustDocument.made(estimate.robust, result.without_robust),
            "from_scale": result.from_scale or UNSET,
        }
        if len(indices) < len(INERTIAL):
            return cls(**own, interval95=None, com=None, inertia_com=None, physically_consistent=None)
        spread, basis = payload_spread(result.ten, estimate.covariance, indices), estimate.robust
        robust = basis and payload_spread(result.ten, basis.covariance, indices)
        there = {
            "com_sigma": spread.com,
            "com_sigma_robust": robust and robust.com,
            "inertia_com_sigma": spread.inertia_com,
            "inertia_com_sigma_robust": robust and robust.inertia_com,
        }
        return cls.of(
            result.body,
            **own,
            **(there if result.mass != 0.0 else dict.fromkeys((*there, "com", "inertia_com"))),
            interval95=named(estimate.interval95),
            interval95_robust=named(estimate.robust_interval95),
            relative_residual=estimate.fit.relative,
        )


class PossibleEstimate(MethodEstimate, frozen=True, tag="constrained"):
    """Nearest payload that can exist, with 95 % intervals."""

    gain_sigma: Gains | UnsetType | None = UNSET
    interval95_by: Literal["jackknife", "memory", "formula"] | UnsetType = UNSET
    com_interval95: Matrix | UnsetType = UNSET
    inertia_com_interval95: tuple[Matrix, ...] | UnsetType = UNSET
    principal_moments: Vector | UnsetType = UNSET
    principal_moments_interval95: Matrix | UnsetType = UNSET
    constraints: tuple[str, ...] | UnsetType = UNSET
    active: tuple[parts.ActiveDocument, ...] | UnsetType = UNSET
    chi2_rise: float | UnsetType = UNSET
    p_value: parts.Number | UnsetType = UNSET
    conflict: bool | UnsetType = UNSET
    solver_status: str | UnsetType = UNSET

    @classmethod
    def made(cls, payload: ConstrainedPayload) -> Self:
        """Collect a payload that can exist, with intervals."""
        free, result, intervals = payload.free.estimate, payload.result, payload.intervals
        return cls.of(
            result,
            payload.body,
            payload,
            parameters=named(result.values),
            sigma=named(free.sigma),
            sigma_robust=named(free.sigma_robust),
            sigma_with_gains=named(result.free.sigma) if payload.gains else None,
            gain_sigma=payload.gains,
            interval95=named(intervals.parameters),
            interval95_by="formula" if free.robust is None else "memory" if free.robust.by_memory else "jackknife",
            com_interval95=intervals.com,
            inertia_com_interval95=tuple(intervals.inertia_com),
            principal_moments_interval95=intervals.principal_moments,
            constraints=tuple(constraint.description for constraint in result.constraints),
            active=tuple(
                parts.ActiveDocument(active.multiplier, constraint=active.description, p_value=active.p_value)
                for active in payload.tested
            ),
            weighed=result.weighings,
            solver_status=result.status,
        )

    @property
    def body(self) -> InertialParameters:
        """Payload as a body."""
        return InertialParameters(self.ten)


class PayloadData(Document, frozen=True):
    """Equations behind a payload."""

    equations: int
    rate: parts.Number = field(name="rate_hz")
    cutoff: parts.Number = field(name="cutoff_hz")
    lag_s: parts.Number
    lags_s: tuple[float, ...]
    max_position_mismatch_rad: parts.Number
    condition_number: parts.Number
    condition_number_scaled: parts.Number
    equations_loaded: int | UnsetType = UNSET
    base_parameters: int | UnsetType = UNSET
    rms_position_mismatch_rad: parts.Number | UnsetType = UNSET
    friction: Literal["own", "may differ", "free"] | UnsetType = UNSET
    torque_noise: Vector | UnsetType = UNSET
    independent: float | UnsetType = field(default=UNSET, name="independent_rate_hz")


class Recommended(Document, frozen=True):
    """Method of the estimate to use, and the reason for it where there are others."""

    method: int
    estimator: Literal["wls", "constrained"] | UnsetType = UNSET
    reason: str = ""


class Assumed(Document, frozen=True):
    """Inertia that was not measured but asked for, and the ten with it."""

    inertia: str
    parameters: parts.Ten


class VisibilityDocument(Document, frozen=True):
    """Visibility of the ten in the torques of some joints."""

    joints: tuple[int, ...]
    rank: int
    parameters: dict[str, str]
    combinations: tuple[str, ...]


class Quantity(Document, frozen=True):
    """Mass, centre of mass or inertia there: whether to use it, its value, 95 % interval and standard deviation.

    Numbers are arrays of one shape, those of the interval with one axis more, [low, high].
    """

    use: str
    why: str | None
    value: Any
    interval95: Any
    sigma: Any

    @property
    def low(self) -> Array:
        """Lower ends of the 95 % interval, nan where there is none."""
        return np.asarray(self.interval95[..., 0])

    @property
    def high(self) -> Array:
        """Upper ends of the 95 % interval, nan where there is none."""
        return np.asarray(self.interval95[..., 1])

    def __float__(self) -> float:
        """Convert the mass alone."""
        return float(self.value)


class ConstantTorques(Document, frozen=True):
    """Joints whose constant torque has a prior near zero, and its standard deviation [N·m]."""

    joints: tuple[int, ...]
    sigma: Vector


class FlangeDocument(Document, frozen=True):
    """Pose of the maker's flange in the payload's frame, if that is another one, and who says so."""

    xyz: Triple
    rpy_deg: Triple
    source: str


@dataclass(frozen=True)
class StandIn:
    """Nominal inertia where none was measured: that of an evenly filled body. Assumed, and called so."""

    kind: str  # "box" or "cylinder"
    sizes: tuple[float, ...]  # along x, y, z; of a cylinder diameter and length along z [m]

    def __post_init__(self) -> None:
        """Refuse sizes that no body has."""
        known = len(self.sizes) == {"box": 3, "cylinder": 2}.get(self.kind)
        if not (known and all(0.0 < size < np.inf for size in self.sizes)):
            raise InputError(
                f"an assumed inertia of {self.kind} {self.sizes}: give box:AxBxC (along x, y, z) or cylinder:DxL "
                "(diameter, and length along z), in mm"
            )

    @staticmethod
    def parse(text: str) -> "StandIn":
        """Parse "box:60x60x350" or "cylinder:80x200", in mm."""
        match = _FORM.fullmatch(text.strip().lower())
        if match is None:
            raise InputError(f"--inertia {text!r}: write box:60x60x350 or cylinder:80x200, in mm")
        return StandIn(match[1], tuple(1e-3 * float(size) for size in match[2].split("x")))

    @property
    def description(self) -> str:
        """Describe it with its sizes in mm."""
        sizes = " x ".join(f"{1e3 * size:g}" for size in self.sizes)
        along = "along x, y, z" if self.kind == "box" else "(diameter, length along z)"
        return f"evenly filled {self.kind} of {sizes} mm {along} about the centre of mass"

    def body(self, mass: float, com: Array) -> InertialParameters:
        """Give the payload this inertia, its mass spread evenly."""
        # A box's moment is m/12 of the squares of both other sides, a cylinder's across m/12 (3 r^2 + h^2).
        squares = np.square(self.sizes)
        if self.kind == "cylinder":
            squares = np.array([0.75, 0.75, 1.0]) * squares[[0, 0, 1]]
        return InertialParameters.from_com(mass, com, np.diag(mass / 12.0 * (squares.sum() - squares)))


@dataclass(frozen=True, eq=False, repr=False)
class TorquePrediction(Brief):
    """Measured and predicted torques of one recording, joint by joint, without slow rows."""

    source: str
    loaded: bool
    held_out: bool
    t: tuple[Array, ...]  # [s], (r_j,)
    measured: tuple[Array, ...]  # [N·m or N], (r_j,)
    curves: dict[str, tuple[Array, ...]]  # predictions by what they are; residuals are those of the first

    def residual(self, joint: int) -> Array:
        """Measured less predicted torque of a joint, counted from 0."""
        return np.asarray(self.measured[joint] - next(iter(self.curves.values()))[joint])

    @property
    def relative_per_joint(self) -> Array:
        """Norm of the residual over norm of the torque, shape (n,); nan without torque."""
        torques = [float(np.linalg.norm(torque)) or np.nan for torque in self.measured]
        return np.array([np.linalg.norm(self.residual(j)) / torque for j, torque in enumerate(torques)])

    @property
    def step(self) -> float:
        """Time between neighbouring rows [s]; nan if no joint has two."""
        return min((float(np.median(np.diff(t))) for t in self.t if len(t) > 1), default=float("nan"))

    def autocorrelation(self, joint: int, span: float = 2.0) -> tuple[Array, Array]:
        """Lags [s] up to ``span`` and the residual's autocorrelation there; a joint counted from 0."""
        t, step = self.t[joint], self.step
        if len(t) < 3:
            return np.zeros(1), np.ones(1)
        lags = max(1, min(round(span / step), int((t[-1] - t[0]) / step) // 2))
        return np.arange(lags + 1.0) * step, autocorrelation([(t, self.residual(joint))], step)[: lags + 1]


@dataclass(frozen=True, eq=False, repr=False)
class ObservationSystem(Brief):
    """System Y = W chi + rho as an estimator sees it: filtered, decimated, without the rows that are not used.

    Rows stand recording by recording, in each joint by joint, in each by time.
    """

    columns: tuple[str, ...]  # c
    W: Array  # SI units, r x c
    Y: Array  # torques [N·m or N], known ones (a spring) moved there, (r,)
    joint: Indices  # each row's joint, from 1, (r,)
    recording: Indices  # each row's recording in ``sources``, from 0, (r,)
    t: Array  # [s], (r,)
    loaded: Mask  # whether each row's recording is with payload, (r,)
    sources: tuple[str, ...]  # the recordings
    weights: Array  # per joint, of the weighted least squares [1/(N·m) or 1/N], (n,)
    reduced: Equations  # the same equations as triangular factors
    known: Array | None = None  # values of the first columns that are known from an earlier identification


class PayloadResult(Speaks, Document, frozen=True, kw_only=True, dict=True):
    """A payload by the methods that were used, and what only a weighing by a short motion tells.

    ``frame`` is where it is given, as text; ``assumed`` an inertia that was asked for instead of a measured one;
    ``scale`` a weighed mass and its standard deviation [kg]; ``joints`` those of a short motion, else absent.
    """

    kind: Literal["payload"] = "payload"
    version: Literal[1] = 1
    robot: str | UnsetType = UNSET
    robot_title: str | UnsetType = UNSET
    frame: str
    flange_in_payload_frame: FlangeDocument | UnsetType = UNSET
    rated_payload_kg: parts.Number | UnsetType = UNSET
    processing: parts.ProcessingDocument | UnsetType = UNSET
    relative_residual: parts.ResidualDocument | UnsetType = UNSET
    data: PayloadData | UnsetType = UNSET
    estimates: tuple[FreeEstimate | PossibleEstimate, ...]
    recommended: Recommended | None = None
    gain_sigma: Gains | UnsetType | None = UNSET
    mass_by_joints: tuple[JointsMass, ...] | UnsetType = UNSET
    joint_that_agrees_least: str | UnsetType | None = UNSET
    friction: tuple[TermChoice, ...] | UnsetType = UNSET
    essential: parts.EliminationDocument | UnsetType | None = UNSET
    left_out: dict[str, str] | UnsetType = UNSET
    verdict: Verdict
    joints: tuple[int, ...] | UnsetType = UNSET
    visibility: VisibilityDocument | UnsetType = UNSET
    constant_torques: ConstantTorques | UnsetType = UNSET
    ripple: tuple[Wave, ...] | UnsetType = UNSET
    quantities: dict[str, Quantity] | UnsetType = UNSET
    mass_from_scale: bool | UnsetType = UNSET
    agreement: tuple[Agreement, ...] | UnsetType = UNSET
    repeats: Repeats | UnsetType | None = UNSET
    standing: Standing | UnsetType | None = UNSET
    assumed: Assumed | UnsetType | None = UNSET
    scale: tuple[float, float] | UnsetType = UNSET

    @property
    def headline(self) -> str:
        """State mass, interval and verdict in a line."""
        mass, level = self.mass, self.verdict.level.replace("_", " ")
        return f"{self.robot}, mass {mass.value:.6g} kg (95 % from {mass.low:.6g} to {mass.high:.6g}), {level}"

    @property
    def title(self) -> str:
        """Title of the robot, or its name."""
        return self.robot_title or self.robot or ""

    @property
    def free(self) -> tuple[FreeEstimate, ...]:
        """Free estimates of each method."""
        return tuple(estimate for estimate in self.estimates if isinstance(estimate, FreeEstimate))

    @property
    def possible(self) -> tuple[PossibleEstimate, ...]:
        """Nearest payload that can exist, of each method that determines all ten."""
        return tuple(estimate for estimate in self.estimates if isinstance(estimate, PossibleEstimate))

    @property
    def method(self) -> int:
        """Number of the method to use."""
        if self.recommended is not None:
            return self.recommended.method
        return min((estimate.method for estimate in self.estimates), key=PREFERRED.index)

    @property
    def best(self) -> PossibleEstimate | None:
        """Possible payload to use, of ``method``; None where not all ten are determined."""
        return next((estimate for estimate in self.possible if estimate.method == self.method), None)

    @property
    def best_free(self) -> FreeEstimate:
        """Free estimate to use."""
        return next(estimate for estimate in self.free if estimate.method == self.method)

    @property
    def gains(self) -> Gains | None:
        """Errors of the drive gains that intervals allow for; None where gains are taken as exact."""
        return present(self.gain_sigma)

    @property
    def flange(self) -> Pose | None:
        """Pose of the flange in ``frame``, if that is another frame and it is known."""
        stored = present(self.flange_in_payload_frame)
        return Pose.from_rpy(stored.xyz, np.radians(stored.rpy_deg).tolist()) if stored else None

    @property
    def mass(self) -> Quantity:
        """Mass [kg]: ``result.mass.low`` is the lower end of its 95 % interval."""
        return self._quantity("mass")

    @property
    def com(self) -> Quantity:
        """Centre of mass [m], shape (3,)."""
        return self._quantity("centre_of_mass", 3)

    @property
    def inertia(self) -> Quantity:
        """Inertia at the centre of mass [kg m^2], axes of the frame, 3 x 3."""
        return self._quantity("inertia", 3, 3)

    def _quantity(self, name: str, *shape: int) -> Quantity:
        told = (present(self.quantities) or {}).get(name, Quantity("", None, None, None, None))
        value, ends = array(told.value, *shape), array(told.interval95, *shape, 2)
        return Quantity(told.use, told.why, value, ends, array(told.sigma, *shape))

    def assuming(self, stand_in: StandIn) -> "PayloadResult":
        """Assume an inertia, unless one was measured well enough."""
        if self.inertia.use in ("use", "do not use"):
            return self
        if not np.isfinite(self.com.value).all():
            raise InputError(
                f"an inertia cannot be assumed about a centre of mass that is not known: {self.com.why}"
            )
        body, text = stand_in.body(float(self.mass), self.com.value), stand_in.description
        inertia = Quantity("assumed", text, body.inertia_com, None, None)
        quantities, assumed = {**(present(self.quantities) or {}), "inertia": inertia}, Assumed(text, body.named())
        return replace(self, quantities=quantities, assumed=assumed).made_by(self.working)

    def export(self, to: str, despite_verdict: bool = False) -> str:
        """Write the payload in the format of a controller or simulator; see ``dynident export --to``.

        Args:
            to: name of the format, such as "ur".
            despite_verdict: give it whatever the verdict is.

        Raises:
            InputError: for another name, or a payload that must not be used.
        """
        return str(Speaks.shown_by().export(self, to, despite_verdict))
