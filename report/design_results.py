"""A designed or replayed motion as a JSON document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .. import __version__
from ..trajectories import BlendedPoints, Design, DesignProblem, Floor, Fourier, Score, Trapezoid, ViaPoints
from ..trajectories.samples import Plan


def design_document(
    problem: DesignProblem,
    score: Score,
    reference: Mapping[str, float],
    *,
    design: Design | None = None,
    floor: Floor | None = None,
    evaluated: str | None = None,
    replay: Score | None = None,
) -> dict[str, Any]:
    """What ``dynident design --json`` writes.

    Args:
        problem: what was asked.
        score: of the motion.
        reference: values that standard deviations are relative to.
        design: the motion, if one was designed.
        floor: if it was asked for.
        evaluated: the log whose motion was judged instead.
        replay: what a controller's own profiles would make of it.
    """
    learnt, relative = score.learnt, score.relative_sigma(dict(reference))
    document: dict[str, Any] = {
        "robot": problem.robot.name,
        "robot_fingerprint": problem.robot.fingerprint,
        "criterion": problem.criterion.kind,
        "criterion_value": score.value,
        "condition_number": learnt.condition_number,
        "condition_number_scaled": learnt.condition_number_scaled,
        "log_det": learnt.log_det,
        "predicted_sigma": learnt.sigma,
        "predicted_sigma_percent": {
            name: 100.0 * relative[name] if name in relative else None for name in learnt.sigma
        },
        "torque_noise": problem.noise,
        "independent_rate_hz": problem.goal.rate,
        "data_length_s": problem.goal.data_length,
        "duration_s": score.duration,
        "limits": {
            "max_violation": score.max_violation,
            "met": score.feasible,
            "nearest": [limit._asdict() for limit in score.limits],
        },
        "floor": _floor(floor),
        "evaluated": evaluated,
        "val3_replay": _replay(replay),
        "version": __version__,
    }
    if design is not None:
        document |= {
            "seed": design.seed,
            "starts": design.starts,
            "solver": design.solver,
            "evaluations": design.evaluations,
            "cpu_s": design.cpu_s,
            "interrupted": design.interrupted,
            "motion": _motion(design.plan),
        }
    return document


def _motion(plan: Plan) -> dict[str, Any]:
    if isinstance(plan, ViaPoints):
        return {
            "kind": "via points",
            "points": plan.points,
            "durations": plan.durations,
            "speeds": plan.speeds,
            "accelerations": plan.accelerations,
            "segments": plan.segment.name,
            "ramp": plan.segment.ramp if isinstance(plan.segment, Trapezoid) else None,
            "blends": None,
        }
    if isinstance(plan, BlendedPoints):
        return {
            "kind": "via points",
            "points": plan.points,
            "durations": plan.durations,
            "speeds": None,
            "accelerations": None,
            "segments": "blend",
            "ramp": None,
            "blends": plan.blends,
        }
    assert isinstance(plan, Fourier)
    return {"kind": "fourier", "offset": plan.offset, "a": plan.a, "b": plan.b, "period": plan.period}


def _floor(floor: Floor | None) -> dict[str, Any] | None:
    if floor is None:
        return None
    return {"criterion_value": floor.value, "gap": floor.gap, "states": floor.states}


def _replay(replay: Score | None) -> dict[str, Any] | None:
    if replay is None:
        return None
    return {
        "criterion_value": replay.value,
        "condition_number": replay.learnt.condition_number,
        "condition_number_scaled": replay.learnt.condition_number_scaled,
        "duration_s": replay.duration,
        "limits_met": replay.feasible,
        "violations": list(replay.violations),
    }
