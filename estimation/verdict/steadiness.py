"""Whether the payload stayed what and where it was during the recording."""

import numpy as np

from .reasons import Evidence, Reason, against_all

CHANGE = 0.10
"""Change of the mass, or of a first moment in units of the payload's M l, above which it is not one payload."""
SIGMAS = 6.0
"""Standard deviations that the change must exceed as well."""


def steadiness_reasons(evidence: Evidence) -> list[Reason]:
    """A payload that changed, slipped, or torques that drifted while it was weighed."""
    stretches, free, body = evidence.stretches, evidence.recommended.free, evidence.recommended.body
    if len(stretches) < 2:
        return []
    ratio = np.maximum(free.larger_sigma / np.where(free.estimate.sigma > 0.0, free.estimate.sigma, 1.0), 1.0)
    values = np.array([one.values[6:] for one in stretches])
    sigma = np.array([np.sqrt(np.diag(one.covariance)) * ratio for one in stretches])[:, 6:]
    length = float(np.sqrt(max(np.trace(body.inertia), 0.0) / 2.0 / body.mass))
    size = np.array([body.mass * length] * 3 + [body.mass])
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    change = np.ptp(values, axis=0)
    k = np.arange(4)
    noise = np.hypot(sigma[low, k], sigma[high, k])
    moved = change > np.maximum(CHANGE * size, SIGMAS * noise)
    if moved[3]:
        masses = ", ".join(f"{value:.3g}" for value in values[:, 3])
        return [
            against_all(
                f"the mass changes during the loaded recording ({masses} kg, in the order of time): was the payload "
                "taken up or put down, or does a torque drift?"
            )
        ]
    if moved[:3].any():
        axis = int(np.argmax(change[:3] / size[:3]))
        places = ", ".join(f"{1e3 * value:.0f}" for value in values[:, axis] / values[:, 3])
        return [
            against_all(
                f"the centre of mass moves during the loaded recording ({'xyz'[axis]} at {places} mm, in the order of "
                "time): did the payload slip, or does a torque drift?"
            )
        ]
    return []
