"""A second wrist pose at which a motion near a pose is done again, where that tells clearly more."""

from dataclasses import replace

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..model.payload_spread import PayloadSpread
from .near import SHARES, NearRequest, near_family, spread_of

_APART = 0.5 * np.pi  # rad: between two wrist poses
_LOOKS = 6  # random motions by which second poses are compared
_HELPS = 0.75  # of the uncertainty with one pose: above it a second pose is not worth leaving the range


def second_pose(request: NearRequest, seed: int = 0) -> Array | None:
    """A second pose that would tell clearly more, the moving wrist joints turned by 90 degrees; None without one.

    Judged on a few random motions each, before any design.
    """
    limits, n = request.limits, request.robot.n
    wrist = [j for j in range(max(n - 3, 0), n) if j + 1 in request.joints and request.robot.joints[j].revolute]
    candidates = []
    for pattern in np.ndindex(*(3,) * len(wrist)):
        pose = request.pose.copy()
        pose[wrist] += _APART * (np.array(pattern) - 1.0)
        if any(step != 1 for step in pattern) and ((pose > limits.low) & (pose < limits.high)).all():
            candidates.append(pose)
    one = _looked(replace(request, second=None), seed)
    found = [(_looked(replace(request, second=pose), seed), k) for k, pose in enumerate(candidates)]
    best, k = min(found, default=(np.inf, 0))
    return candidates[k] if best < _HELPS * one else None


def uncertainty(spread: PayloadSpread) -> float:
    """Of mass in units of 10 g and of the centre of mass in mm, whichever is larger; infinite ones left out."""
    numbers = [spread.mass / SHARES["M"], *(spread.com / SHARES["MX"])]
    return max((x for x in numbers if np.isfinite(x)), default=np.inf)


def _looked(request: NearRequest, seed: int) -> float:
    try:
        family = near_family(request)
    except InputError:
        return np.inf
    draw = np.random.default_rng(seed)
    return min(uncertainty(spread_of(request, family.plan(family.random(draw)))) for _ in range(_LOOKS))
