"""What each recording of an arm says while the rest is fixed from all of them: friction, payload, drive scales."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.equations.equations import PAYLOAD, Equations, merged
from ...estimation.fit.estimate import Estimate
from ...estimation.fit.least_squares import joint_weights, weighted
from ...estimation.fit.linear_problem import LinearProblem
from ...estimation.fit.robust import jackknifed
from ...model.names import FRICTION, parameter_kind
from ...model.regressors import payload_columns
from .comparing import TINY, compared_sigma
from .identity import Exchange, exchange_of
from .stored import Stored

MASS = "mass"
"""The payload's mass less what the controller was told [kg], as a quantity of a night."""

_CLEARLY = 4.0  # sigmas: such a change of the mass is taken for one


class Measured(NamedTuple):
    """A number of a night and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True)
class Night:
    """What one recording of an arm says.

    Attributes:
        arm: its name.
        day: ISO date or time.
        temperature: [deg C], nan where it is not known.
        told: mass that the controller was told [kg].
        numbers: by name: frictions ("FS2"), ``MASS``, and "scale 2", by which share a drive's torque is larger than
            on the whole.
    """

    arm: str
    day: str
    temperature: float
    told: float
    numbers: dict[str, Measured]


@dataclass(frozen=True)
class Arm:
    """An arm by all of its recordings.

    Attributes:
        name: of the arm.
        pooled: its base parameters by those with the payload it was told most often, to compare with other arms.
        exchange: recordings under its name that are of another robot; None where all may be of one.
    """

    name: str
    nights: tuple[Night, ...]
    pooled: Estimate
    exchange: Exchange | None = None


def arm_of(recordings: Sequence[Stored]) -> Arm:
    """An arm by its recordings, which name it and the day.

    Raises:
        InputError: if one does not, or a recording does not determine what is asked of it.
    """
    for recording in recordings:
        if not {"arm", "day"} <= set(recording.about):
            name = recording.name
            raise InputError(f"{name}: its arm and day are not known: give --pattern or --table to reduce")
    ordered = sorted(recordings, key=lambda recording: recording.about["day"])
    masses = [float(recording.about.get("payload", "0")) for recording in ordered]
    usual = Counter(masses).most_common(1)[0][0]
    same = [recording.equations for recording, mass in zip(ordered, masses, strict=True) if mass == usual]
    whole = weighted(merged(replace(equations, leave_one_out=()) for equations in same))
    nights = tuple(night_of(recording, whole, mass, usual) for recording, mass in zip(ordered, masses, strict=True))
    last = weighted(same[-1])
    excess = compared_sigma(last, robust_sigma(same[-1])) / np.maximum(last.sigma, TINY)
    wide = replace(whole, covariance=whole.covariance * np.outer(excess, excess))
    return Arm(ordered[0].about["arm"], nights, wide, _exchange(ordered, whole, excess))


def bodies_of(estimate: Estimate) -> Estimate:
    """What a robot's bodies tell, without friction and constant torques."""
    return estimate.part([name for name in estimate.names if parameter_kind(name) not in FRICTION])


def _exchange(recordings: Sequence[Stored], whole: Estimate, excess: Array) -> Exchange | None:
    """Recordings that are of another robot, whatever is carried and however the drives are scaled."""
    first = recordings[0]
    nights, inertial = [], [k for k, name in enumerate(whole.names) if parameter_kind(name) not in FRICTION]
    for recording in recordings:
        night = weighted(recording.equations)
        nights.append(bodies_of(replace(night, covariance=night.covariance * np.outer(excess, excess))))
    scaled = [
        whole.covariance @ (weight**2 * factor[:, :-1].T @ (factor[:, :-1] @ whole.values))
        for factor, weight in zip(first.equations.factors, whole.weights, strict=True)
    ]
    explained = np.column_stack([first.base.effect_of(payload_columns(first.robot)), *scaled])[inertial]
    return exchange_of(first.about["arm"], [recording.about["day"] for recording in recordings], nights, explained)


def night_of(recording: Stored, whole: Estimate, stated_mass: float, usual: float) -> Night:
    """One recording: friction and a change of payload together, then each drive's scale beside its friction.

    Args:
        recording: of the recording.
        whole: the arm's base parameters by all recordings that were told ``usual``.
        stated_mass: mass that the controller was told [kg].
        usual: that it was told most often [kg].
    """
    names, equations = whole.names, recording.equations
    frictions = [k for k, name in enumerate(names) if parameter_kind(name) in FRICTION]
    rest = np.array(whole.values)
    rest[frictions] = 0.0
    change = recording.base.effect_of(payload_columns(recording.robot))
    own = np.eye(len(names))[:, frictions]
    columns = [*(names[k] for k in frictions), *PAYLOAD]
    both = _measured(equations.substituted(columns, np.column_stack([own, change]), rest))
    numbers = {names[k]: both[names[k]] for k in frictions}
    mass, sigma = both["M_L"]
    numbers[MASS] = Measured(usual + mass - stated_mass, sigma)
    if abs(mass) > _CLEARLY * sigma:  # what hangs there is no drive's scale
        rest = rest + change @ np.array([both[name].value for name in PAYLOAD])
    for j in range(recording.robot.n):
        own_columns = [k for k in frictions if np.abs(equations.factors[j][:, k]).max(initial=0.0) > 0.0]
        M = np.column_stack([rest, np.eye(len(names))[:, own_columns]])
        alone = equations.of_joint(j).substituted(["scale", *(names[k] for k in own_columns)], M, rest)
        numbers[f"scale {j + 1}"] = _measured(alone)["scale"]
    temperature = float(recording.about.get("temperature", "nan"))
    return Night(recording.about["arm"], recording.about["day"], temperature, stated_mass, numbers)


def _measured(equations: Equations) -> dict[str, Measured]:
    """Each parameter with a standard deviation to compare it by."""
    estimate = weighted(equations)
    sigma = compared_sigma(estimate, robust_sigma(equations))
    return {
        name: Measured(float(value), float(own))
        for name, value, own in zip(estimate.names, estimate.values, sigma, strict=True)
    }


def robust_sigma(equations: Equations) -> Array | None:
    """Standard deviations by the jackknife; None where there are too few blocks."""
    blocks = len(equations.leave_one_out)
    if blocks < 2:
        return None
    estimate = weighted(equations, joint_weights(equations, weighted(equations).values))
    try:
        left = LinearProblem(equations, equations.columns).without_blocks(
            estimate.weights, [(b, -1) for b in range(blocks)]
        )
    except InputError:
        return None
    return jackknifed([left], estimate.values, equations.block_length).sigma
