"""Whether the data determine the inertia."""

import numpy as np

from ....common.arrays import Array
from ....model import INERTIAL
from ...payload.constrained import ConstrainedPayload
from ..evidence import Evidence
from ..finding import Finding, warning
from ..quantities import vague_moments

OWN_SIZE = 0.3
"""Standard deviation, in units of the payload's own M l^2, above which the motion does not show a parameter."""
CONDITION = 500.0
"""Condition number with columns scaled above which small errors spoil the answer; good motions have 10."""


def inertia(evidence: Evidence) -> list[Finding]:
    """Against the inertia, judged on the payload that is to be used."""
    payload = evidence.recommended
    if payload is None:
        return []
    vague = vague_moments(*_moments(payload))
    if not vague:
        return []
    shares = ", ".join(f"{name} by {_percent(share)}" for name, share in vague)
    text = f"the inertia at the centre of mass is not determined (method {payload.method}, 1 sigma: {shares})"
    hidden = _unseen(payload)
    if hidden:
        text += f"; in units of the payload's own size the motion hardly shows {', '.join(hidden)}"
    return [warning(f"{text}: use mass and centre of mass, or move the wrist faster")]


def _moments(payload: ConstrainedPayload) -> tuple[Array, Array]:
    """The possible payload's moments at its centre of mass, and the free estimate's deviations [kg m^2], each (3,).

    The robust deviations if there are any; the free moments may be negative.
    """
    moments, robust = np.diag(payload.body.inertia_com), payload.free.sigma_inertia_com_robust
    sigma = np.diag(robust if robust is not None else payload.free.sigma_inertia_com)
    return np.maximum(moments, 1e-12 * max(float(moments.max()), 1e-300)), sigma


def _unseen(payload: ConstrainedPayload) -> list[str]:
    """Inertia parameters whose deviation is large against M l^2, l the payload's own radius of gyration."""
    size = max(float(np.trace(payload.body.inertia_com)) / 2.0, 1e-300)
    sigmas = payload.free.larger_sigma[:6]
    return [kind for kind, sigma in zip(INERTIAL, sigmas, strict=False) if sigma > OWN_SIZE * size]


def condition(evidence: Evidence) -> list[Finding]:
    """Nearly dependent equations."""
    if evidence.condition is None or evidence.condition <= CONDITION:
        return []
    text = (
        f"the equations are nearly dependent (condition number {evidence.condition:.0f} with columns scaled): move "
        "more joints at once, over a wider range"
    )
    return [warning(text)]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10.0 else "more than its size tenfold"
