"""Whether a body or robot can exist whose eliminated parameters are zero, the essential ones as estimated.

Elimination takes a small parameter as zero. That is harmless for torques, but a zero may be one that no body has:
XX = 0 says that all mass lies on the x axis, and ZZ6 = 0 while YZ6 is not that link 6 cannot exist.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...model import BaseParameters, Robot
from ..equations.equations import PAYLOAD
from ..fit.essential import Elimination
from ..fit.estimate import Estimate, error_model
from ..payload.methods import selected, with_robust
from ..payload.problem import PayloadProblem
from ..possible.cone import SolverError
from ..possible.payload import solve_constrained
from ..possible.result import rise_p_value
from ..possible.robot import solve_constrained_base

_UNLIKELY = 0.01
"""A smaller p-value says that the data contradict everything possible with these zeros."""
_ZERO = 1e-2
"""An eliminated base parameter is held at zero within this fraction of its own standard deviation."""
_OFF_AXIS = {
    "XX": ("XY_L", "XZ_L", "YZ_L", "MY_L", "MZ_L"),
    "YY": ("XY_L", "XZ_L", "YZ_L", "MX_L", "MZ_L"),
    "ZZ": ("XY_L", "XZ_L", "YZ_L", "MX_L", "MY_L"),
}
"""What is zero if all mass lies on that axis."""


def impossible_payload(elimination: Elimination) -> tuple[str, ...]:
    """What speaks against a payload with the eliminated parameters zero, one line each; empty if nothing does.

    Without XX, YY, ZZ or M no body of any thickness is left, whatever the data say. Else the nearest possible
    payload with these zeros must lie within the accuracy of the data.

    Args:
        elimination: of parameters among which are some or all of ``PAYLOAD``.
    """
    gone = tuple(name for name in elimination.eliminated if name in PAYLOAD)
    left = tuple(name for name in elimination.essential if name in PAYLOAD)
    if not gone:
        return ()
    if not left:
        return ("no payload parameter is essential: the torques do not show the payload",)
    if "M_L" in gone:
        return (f"M_L is eliminated, {', '.join(left)} remain: a body without mass has none of them",)
    on_axis = [_on_axis(kind, left) for kind in ("XX", "YY", "ZZ") if f"{kind}_L" in gone]
    return tuple(on_axis) or _payload_too_far(elimination.estimate, gone, left)


def elimination_warnings(problem: PayloadProblem, elimination: Elimination) -> tuple[str, ...]:
    """What speaks against the essential parameters of robot and payload together, by method 4."""
    full, _ = with_robust(problem, lambda part: selected(part, part.loaded.columns))
    part, _ = with_robust(problem, lambda part: selected(part, elimination.essential), elimination.estimate)
    elimination = replace(elimination, estimate=part)
    return impossible_payload(elimination) + impossible_robot(problem.robot, problem.base, full, elimination)


def _on_axis(kind: str, left: Sequence[str]) -> str:
    """What it means that a moment of inertia was eliminated."""
    beside = [name for name in left if name in _OFF_AXIS[kind]]
    line = f"{kind}_L is eliminated, which only a payload on its frame's {kind[0].lower()} axis has zero"
    return f"{line}: {', '.join(beside)} must then be zero too, and remain" if beside else line


def _payload_too_far(estimate: Estimate, gone: Sequence[str], left: tuple[str, ...]) -> tuple[str, ...]:
    estimate = error_model(estimate)
    values, covariance = estimate.select(left)
    part = Estimate(left, values, covariance, estimate.degrees_of_freedom, estimate.fit, estimate.weights)
    try:
        result = solve_constrained(part)
    except SolverError as error:
        return (f"whether a payload without {', '.join(gone)} can exist is not known ({error.words})",)
    return _too_far("payload", gone, result.chi2_rise, result.p_value)


def impossible_robot(
    robot: Robot, base: BaseParameters, estimate: Estimate, elimination: Elimination
) -> tuple[str, ...]:
    """What speaks against a robot with the eliminated base parameters zero; empty if nothing does.

    The nearest robot that can exist, its eliminated base parameters zero within 1 % of their standard deviations,
    must lie within the accuracy of the data: by robust standard deviations where the estimates have them.

    Args:
        estimate: of all parameters, before elimination.
        elimination: of them; parameters of a payload are left aside.
    """
    gone = tuple(name for name in elimination.eliminated if name in base.columns)
    left = tuple(name for name in elimination.essential if name in base.columns)
    if not gone or not left:
        return ()
    zeroed = _held_at_zero(base, error_model(estimate), error_model(elimination.estimate), left)
    try:
        result = solve_constrained_base(robot, base, zeroed)
    except SolverError as error:
        return (f"whether a robot with these zeros can exist is not known ({error.words})",)
    p_value = rise_p_value(result.chi2_rise, len(left), zeroed.degrees_of_freedom)
    lines = _too_far(robot.name, gone, result.chi2_rise, p_value)
    at_fault = [holding.description for holding in result.active[:3]]
    return tuple(f"{line}; in conflict: {', '.join(at_fault)}" for line in lines)


def _held_at_zero(base: BaseParameters, full: Estimate, essential: Estimate, left: tuple[str, ...]) -> Estimate:
    """All base parameters: the essential ones as estimated, the others zero and next to certain."""
    places = [base.columns.index(name) for name in left]
    values = np.zeros(len(base.columns))
    covariance = np.diag((_ZERO * np.sqrt(np.diag(full.select(base.columns)[1]))) ** 2)
    values[places], part = essential.select(left)
    covariance[np.ix_(places, places)] = part
    return Estimate(base.columns, values, covariance, essential.degrees_of_freedom, full.fit, full.weights)


def _too_far(body: str, gone: Sequence[str], chi2: float, p_value: float) -> tuple[str, ...]:
    if p_value >= _UNLIKELY:
        return ()
    zeros = ", ".join(gone) if len(gone) <= 6 else f"the {len(gone)} eliminated parameters"
    return (
        f"no {body} that can exist has {zeros} zero and the others as estimated: the nearest is "
        f"{np.sqrt(chi2):.1f} standard deviations away ({_p(p_value)})",
    )


def _p(p_value: float) -> str:
    return f"p {p_value:.1g}" if p_value >= 1e-12 else "p below 1e-12"
