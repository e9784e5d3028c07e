"""The answer to "what hangs on the flange" from a short motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters
from ...model.inertia import PayloadSpread, payload_spread
from ..diagnosis.evidence import Evidence, Weighed
from ..diagnosis.finding import Verdict
from ..diagnosis.quantities import Agreement, Judged, allowing, judge_com, judge_inertia, judge_mass
from ..diagnosis.verdict import judge
from ..equations.equations import merged
from ..fit.drive_gains import GainErrors
from ..fit.estimate import Estimate, error_model
from ..fit.least_squares import weighted
from ..fit.robust import student95
from ..payload.by_joints import ByJoints
from ..payload.constrained import ConstrainedPayload, constrain_payload
from ..payload.repeats import Repeats, repeats_of, widened
from ..payload.result import PayloadEstimate
from ..payload.short_motion import WeighProblem
from ..payload.stand_in import StandIn
from ..payload.weighing import solve_weighing, weigh_by_joints
from ..possible.constraints import Constraint, KnownMass
from ..possible.result import Weighing
from ..possible.scaling import POSSIBLE


@dataclass(frozen=True, eq=False)
class WeighAnswer:
    """What hangs on the flange, quantity by quantity.

    Attributes:
        problem: the recordings.
        found: the free estimate of the determined parameters, with its standard deviations.
        model: the same with the covariance that its errors really have, gains and repeats included.
        constrained: the nearest payload that can exist; None where not all ten are determined.
        scale: what was weighed.
        gains: uncertainty of the drive gains.
        spread: standard deviations of what is told, the scale counted.
        judged: "mass", "centre of mass", "inertia".
        agreement: other ways to the same numbers.
        by_joints: the mass as groups of joints see it.
        repeats: with several recordings, each of them alone.
        verdict: of all together.
        stand_in: an assumed inertia, where it was asked for and none was measured well enough.
    """

    problem: WeighProblem
    found: PayloadEstimate
    model: Estimate
    constrained: ConstrainedPayload | None
    scale: KnownMass | None
    gains: GainErrors | None
    spread: PayloadSpread
    judged: dict[str, Judged]
    agreement: tuple[Agreement, ...]
    by_joints: ByJoints
    repeats: Repeats | None
    verdict: Verdict
    stand_in: StandIn | None = None

    @cached_property
    def ten(self) -> Array:
        """The ten as told, nan where not determined, shape (10,)."""
        if self.constrained is not None:
            return self.constrained.body.vector
        values = np.full(10, np.nan)
        values[list(self.found.places)] = _scaled(self.model, self.found, self.scale)[:, 0]
        return values

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.ten[9])

    @property
    def com(self) -> Array:
        """Centre of mass [m], nan where not determined, shape (3,)."""
        return np.asarray(self.ten[6:9] / self.ten[9])

    @property
    def mass_interval(self) -> tuple[float, float]:
        """95 % interval of the mass [kg]; nan where a constraint contradicts the data."""
        if self.constrained is not None:
            low, high = self.constrained.intervals.parameters[9]
            return float(low), float(high)
        return self._around(self.mass, self.spread.mass)

    @property
    def com_interval(self) -> Array:
        """95 % intervals of the centre of mass [m], 3 x 2."""
        if self.constrained is not None:
            return self.constrained.intervals.com
        return np.array([self._around(x, s) for x, s in zip(self.com, self.spread.com, strict=True)])

    @property
    def assumed(self) -> InertialParameters | None:
        """The payload with the assumed inertia, where there is one."""
        if self.stand_in is None:
            return None
        return self.stand_in.body(self.mass, self.com)

    @property
    def weighing(self) -> Weighing | None:
        """The scale beside the identified mass; None where the scale gave the mass, or nothing was weighed."""
        if self.scale is None or self.found.from_scale:
            return None
        if self.constrained is not None:
            return self.constrained.weighings[0]
        k = self.model.names.index("M_L")
        own, sigma = float(self.model.values[k]), float(self.model.sigma[k])
        return Weighing(self.scale.mass, self.scale.sigma, own, sigma, self.model.degrees_of_freedom)

    def _around(self, value: float, sigma: float) -> tuple[float, float]:
        half = student95(self.model.degrees_of_freedom) * sigma
        return (value - half, value + half) if np.isfinite(half) else (float("nan"), float("nan"))


def answer_weighing(
    problem: WeighProblem,
    *,
    constraints: Sequence[Constraint] = POSSIBLE,
    gains: GainErrors | None = None,
    stand_in: StandIn | None = None,
    others: Sequence[WeighProblem] = (),
) -> WeighAnswer:
    """Weigh a payload and judge the result.

    Args:
        problem: the recordings.
        constraints: what is known of the payload, a weighed mass among it; that it can exist is always demanded.
        gains: uncertainty of the drive gains; taken as exact by default.
        stand_in: an inertia to assume where none was measured well enough.
        others: the same payload reduced in another way, for comparison.

    Raises:
        InputError: "mass not visible" where neither torques nor a scale show the mass.
        SolverError: if no payload holds the constraints.
    """
    scale = next((known for known in constraints if isinstance(known, KnownMass)), None)
    found = solve_weighing(problem, scale)
    repeats = repeats_of(problem, scale)
    by_joints = weigh_by_joints(problem, found.estimate.weights)
    agreement = (*_without_friction(problem), *_others(others, scale))
    if repeats is not None:
        found = widened(found, repeats.excess)
    model = error_model(found.estimate, gains)
    hard = [c for c in constraints if not (isinstance(c, KnownMass) and found.from_scale)]
    constrained = constrain_payload(found, hard, gains) if found.complete else None
    scaled = _scaled(model, found, scale)
    ten = np.full(10, np.nan)
    ten[list(found.places)] = scaled[:, 0]
    if constrained is not None:
        ten = np.array(constrained.body.vector)
    spread = payload_spread(ten, scaled[:, 1:], found.places)
    wide = allowing(spread, model.degrees_of_freedom)
    moments = np.diag(constrained.body.inertia_com) if constrained else np.full(3, np.nan)
    judged = {
        "mass": judge_mass(ten[9], wide, found.from_scale),
        "centre of mass": judge_com(ten, wide),
        "inertia": judge_inertia(moments, wide),
    }
    weighed = Weighed(
        mass=model["M_L"],
        sigma=float(model.sigma[model.names.index("M_L")]),
        from_scale=found.from_scale,
        unexplained=found.unexplained(problem.torque_rms),
        judged=judged,
        repeats=repeats,
        agreement=agreement,
    )
    payloads = (constrained,) if constrained is not None else ()
    verdict = judge(Evidence(problem.robot, constrained=payloads, by_joints=by_joints, weighed=weighed))
    answer = WeighAnswer(
        problem, found, model, constrained, scale, gains, spread, judged, agreement, by_joints, repeats, verdict
    )
    return _assumed(answer, stand_in) if stand_in is not None else answer


def _scaled(model: Estimate, found: PayloadEstimate, scale: KnownMass | None) -> Array:
    """Values (first column) and covariance, the scale counted once."""
    if scale is None or found.from_scale:
        return np.column_stack([model.values, model.covariance])
    return _with_scale(model.values, model.covariance, found.places, scale.sigma, scale.mass)


def _with_scale(values: Array, covariance: Array, places: tuple[int, ...], sigma: float, mass: float) -> Array:
    """Values and covariance once the scale counts too, k x (k + 1): values in the first column."""
    k = places.index(9)
    gain = covariance[:, k] / (covariance[k, k] + sigma**2)
    return np.column_stack([values + gain * (mass - values[k]), covariance - np.outer(gain, covariance[k])])


def _without_friction(problem: WeighProblem) -> list[Agreement]:
    """The same with friction as it was in the recording without payload; left out where it is not determined."""
    if problem.method != 3 or not problem.visibility.mass_visible or problem.visibility.rank < 10:
        return []
    try:
        values = weighted(merged(run.frictional for run in problem.runs)).values
    except InputError:
        return []
    return [Agreement("friction not freed", float(values[9]), values[6:9] / values[9], counts=False)]


def _others(problems: Sequence[WeighProblem], scale: KnownMass | None) -> list[Agreement]:
    found = []
    for other in problems:
        ten = solve_weighing(other, scale).ten
        name = "robot's parameters (method 1)" if other.method == 1 else "torque difference (method 3)"
        found.append(Agreement(name, float(ten[9]), ten[6:9] / ten[9]))
    return found


def _assumed(answer: WeighAnswer, stand_in: StandIn) -> WeighAnswer:
    """With an assumed inertia, unless one was measured.

    Raises:
        InputError: if there is no place to put it.
    """
    if answer.judged["inertia"].use == "use":
        return answer
    if not np.isfinite(answer.com).all():
        raise InputError(
            f"an inertia cannot be assumed about a centre of mass that is not known: "
            f"{answer.judged['centre of mass'].why}"
        )
    judged = answer.judged | {"inertia": Judged("assumed", stand_in.description)}
    return replace(answer, judged=judged, stand_in=stand_in)
