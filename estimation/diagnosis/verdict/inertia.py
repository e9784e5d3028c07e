"""Whether the data determine the inertia."""

import numpy as np

from ....common.arrays import Array
from ....model import INERTIAL
from ...payload.constrained import ConstrainedPayload
from .reasons import Evidence, Reason, against_inertia

INERTIA_SIGMA = 0.30
"""Relative standard deviation of a moment of inertia at the centre of mass above which it should not be used."""
OWN_SIZE = 0.3
"""Standard deviation, in units of the payload's own M l^2, above which the motion does not show a parameter."""
CONDITION = 500.0
"""Condition number with columns scaled above which small errors spoil the answer; good motions have 10."""


def inertia_reasons(evidence: Evidence) -> list[Reason]:
    """Against the inertia, judged on the payload that is to be used."""
    payload = evidence.recommended
    if payload is None:
        return []
    relative = inertia_sigma(payload)
    vague = [k for k in range(3) if not relative[k] <= INERTIA_SIGMA]
    if not vague:
        return []
    named = ", ".join(f"{'XYZ'[k]}{'XYZ'[k]} by {_percent(relative[k])}" for k in vague)
    text = f"the inertia at the centre of mass is not determined (method {payload.method}, 1 sigma: {named})"
    hidden = unseen(payload)
    if hidden:
        text += f"; in units of the payload's own size the motion hardly shows {', '.join(hidden)}"
    return [against_inertia(f"{text}: use mass and centre of mass, or move the wrist faster")]


def inertia_sigma(payload: ConstrainedPayload) -> Array:
    """Relative standard deviations of the three moments of inertia at the centre of mass, shape (3,).

    The free estimate's deviation, the robust one if there is one, over the moments of the possible payload: the
    free moments may be negative.
    """
    moments, robust = np.diag(payload.body.inertia_com), payload.free.sigma_inertia_com_robust
    sigma = np.diag(robust if robust is not None else payload.free.sigma_inertia_com)
    return np.asarray(sigma / np.maximum(moments, 1e-12 * max(float(moments.max()), 1e-300)))


def unseen(payload: ConstrainedPayload) -> list[str]:
    """Inertia parameters whose deviation is large against M l^2, l the payload's own radius of gyration."""
    body = payload.body
    own = max(float(np.trace(body.inertia_com)) / 2.0, 1e-300)
    sigma = payload.free.larger_sigma[:6]
    return [kind for kind, one in zip(INERTIAL, sigma, strict=False) if one > OWN_SIZE * own]


def condition_reasons(evidence: Evidence) -> list[Reason]:
    """Nearly dependent equations."""
    bare = evidence.problem.unloaded
    if bare is None:
        return []
    scaled = bare.condition_numbers()[1]
    if scaled <= CONDITION:
        return []
    return [
        against_inertia(
            f"the equations are nearly dependent (condition number {scaled:.0f} with columns scaled): move more "
            "joints at once, over a wider range"
        )
    ]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10.0 else "more than its size tenfold"
