"""A motion near a pose as JSON."""

from typing import Any

from ..model.payload_spread import PayloadSpread
from ..trajectories import NearDesign
from .weigh_documents import visibility_document


def near_document(found: NearDesign, criterion: str = "a") -> dict[str, Any]:
    """What ``dynident design --near --json`` writes."""
    request, score = found.request, found.design.score
    return {
        "robot": request.robot.name,
        "criterion": criterion,
        "near": {
            "poses": request.poses,
            "joints": list(request.joints),
            "ranges": request.ranges,
            "period_s": found.motion.period,
            "repeats": found.motion.repeats,
            "transfer_s": found.motion.transfer,
        },
        "visibility": visibility_document(found.visibility),
        "predicted_sigma": spread_document(found.spread),
        "condition_number": score.learnt.condition_number,
        "condition_number_scaled": score.learnt.condition_number_scaled,
        "duration_s": found.motion.duration,
        "rehearsal_s": found.motion.slowed(0.1).duration,
        "cpu_s": found.design.cpu_s,
        "limits": {"max_violation": score.max_violation, "torque_checked": request.torque_limited},
        "seed": found.design.seed,
    }


def spread_document(spread: PayloadSpread) -> dict[str, Any]:
    """Standard deviations; null where not visible."""
    return {"mass": spread.mass, "com": spread.com, "inertia_com": spread.inertia_com}
