"""Whether the payload stayed what and where it was during the recording."""

import numpy as np

from .reasons import Evidence, Reason, against_all

CHANGE = 0.10
"""Change of the mass, or of a first moment in units of the payload's M l, above which it is not one payload."""
SIGMAS = 20.0
"""Standard deviations by the formula that the change must exceed as well: on real data they are up to 4 times too
small, and the jackknife's hold the change itself."""


def steadiness_reasons(evidence: Evidence) -> list[Reason]:
    """A payload that changed, slipped, or torques that drifted while it was weighed."""
    stretches, free = evidence.stretches, evidence.best
    if len(stretches) < 2:
        return []
    values = np.array([one.values for one in stretches])[:, 6:]
    sigma = np.array([np.sqrt(np.diag(one.covariance)) for one in stretches])[:, 6:]
    mass = float(np.median(values[:, 3]))
    length = float(np.sqrt(np.abs(free.estimate.values[[0, 3, 5]]).sum() / 2.0 / max(abs(mass), 1e-300)))
    size = abs(mass) * np.array([length, length, length, 1.0])
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    change = np.ptp(values, axis=0)
    k = np.arange(4)
    noise = np.hypot(sigma[low, k], sigma[high, k])
    moved = change > np.maximum(CHANGE * size, SIGMAS * noise)
    if moved[3]:
        masses = ", ".join(f"{value:.3g}" for value in values[:, 3])
        return [
            against_all(
                f"the mass changes during the loaded recording ({masses} kg, in the order of time): was the "
                "payload taken up or put down, or does a torque drift?"
            )
        ]
    if moved[:3].any():
        axis = int(np.argmax(change[:3] / size[:3]))
        places = ", ".join(f"{1e3 * value:.0f}" for value in values[:, axis] / values[:, 3])
        return [
            against_all(
                f"the centre of mass moves during the loaded recording ({'xyz'[axis]} at {places} mm, in the order "
                "of time): did the payload slip, or does a torque drift?"
            )
        ]
    return []
