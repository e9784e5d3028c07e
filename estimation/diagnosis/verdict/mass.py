"""Sign, uncertainty and agreement of the mass, and of the centre of mass."""

from itertools import combinations

import numpy as np

from .reasons import Evidence, Reason, against_all, by

MASS_SIGMA = 0.05
"""Relative standard deviation of the mass above which nothing should be used."""
MASS_SPREAD = 0.05
"""Relative spread of the mass over the methods above which nothing should be used."""
APART = 0.02
"""Relative difference of two methods' masses that matters, if it also exceeds their intervals."""
SIGMAS = 4.0
"""Standard deviations beyond which a difference is none by chance."""
COM_SIGMA = 0.3
"""Standard deviation of the centre of mass, of the payload's own size, above which it should not be used."""
COM_FLOOR = 0.02
"""m: a centre of mass known to this is good whatever the payload's size."""


def mass_reasons(evidence: Evidence) -> list[Reason]:
    """Against the mass."""
    return [*_sign(evidence), *_spread(evidence), *_vague(evidence)]


def _sign(evidence: Evidence) -> list[Reason]:
    """A mass that is negative, or none at all."""
    negative = [e for e in evidence.estimates if e.mass < -SIGMAS * e.larger_sigma[9]]
    if negative:
        masses = ", ".join(f"{e.mass:.3g}" for e in negative)
        return [
            against_all(
                f"{by(negative)} gives a negative mass ({masses} kg): the recordings with and without payload look "
                "swapped, or the signs of torques or of gravity are wrong"
            )
        ]
    nothing = [e for e in evidence.estimates if e.mass <= SIGMAS * e.larger_sigma[9]]
    if not nothing:
        return []
    texts = ", ".join(f"{e.mass:.3g} ± {e.larger_sigma[9]:.2g}" for e in nothing)
    return [
        against_all(
            f"{by(nothing)} gives a mass that does not differ from zero ({texts} kg): is the same load on the "
            "robot in both recordings?"
        )
    ]


def _spread(evidence: Evidence) -> list[Reason]:
    masses = np.array([e.mass for e in evidence.estimates])
    if np.ptp(masses) > MASS_SPREAD * abs(masses.mean()):
        return [against_all(f"the methods' masses spread from {masses.min():.3g} to {masses.max():.3g} kg")]
    for a, b in combinations(evidence.estimates, 2):
        apart, sigma = abs(a.mass - b.mass), float(np.hypot(a.larger_sigma[9], b.larger_sigma[9]))
        if apart > max(APART * abs(masses.mean()), SIGMAS * sigma):
            return [
                against_all(
                    f"methods {a.method} and {b.method} disagree beyond their intervals: {a.mass:.4g} and "
                    f"{b.mass:.4g} kg"
                )
            ]
    return []


def _vague(evidence: Evidence) -> list[Reason]:
    """Judged on the payload that is to be used."""
    free = evidence.best
    sigma = float(free.larger_sigma[9] / max(abs(free.mass), 1e-300))
    if not sigma <= MASS_SIGMA:
        return [
            against_all(
                f"method {free.method} leaves the mass uncertain by {100 * sigma:.0f} % (1 sigma): move the arm's "
                "joints faster, farther or longer"
            )
        ]
    if evidence.recommended is None:
        return []
    body = evidence.recommended.body
    size = float(np.sqrt(max(np.trace(body.inertia), 0.0) / 2.0 / body.mass))
    com = float(free.larger_sigma_com.max())
    if com > max(COM_FLOOR, COM_SIGMA * size):
        axis = "xyz"[int(np.argmax(free.larger_sigma_com))]
        return [
            against_all(
                f"method {free.method} leaves the centre of mass uncertain by {1e3 * com:.0f} mm along {axis} (1 "
                f"sigma), the payload being {1e3 * size:.0f} mm large: turn the wrist farther"
            )
        ]
    return []
