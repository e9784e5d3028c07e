"""A weighing as JSON, readable by what reads the JSON of ``payload``."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..common.arrays import Array
from ..estimation import WeighAnswer
from ..estimation.payload import PayloadEstimate
from ..estimation.weigh import RIPPLE_CHANCE
from ..model import INERTIAL, Processing
from ..model.visibility import PayloadVisibility
from .by_joints import mass_by_joints_document
from .documents import constrained_estimate_document, free_estimate_document, processing_document

Document = dict[str, Any]


def weigh_document(answer: WeighAnswer, processing: Processing, drive_gains: Sequence[float] | None) -> Document:
    """What ``dynident weigh --json`` writes.

    The fields of ``payload --json`` keep their meaning; what was not determined is null. ``assumed`` holds what was
    not measured but asked for, and the ten with it. ``probability_by_noise`` of ripple is that of any wave in noise
    alone, for each joint and recording.
    """
    problem, found = answer.problem, answer.found
    pairs = problem.pairs
    raw, scaled = problem.problem.select([f"{kind}_L" for kind in INERTIAL]).condition_numbers()
    return {
        "robot": problem.robot.name,
        "frame": problem.robot.payload_frame,
        "joints": list(problem.joints),
        "processing": processing_document(problem.robot, processing, drive_gains),
        "relative_residual": {
            "all": found.estimate.fit.relative,
            "per_joint": found.unexplained(problem.torque_rms),
            "validation": None,
        },
        "data": {
            "equations": problem.problem.equations,
            "rate_hz": problem.rate,
            "cutoff_hz": processing.cutoff,
            "lag_s": pairs[0].lag if pairs else None,
            "lags_s": [pair.lag for pair in pairs],
            "max_position_mismatch_rad": max((pair.max_mismatch for pair in pairs), default=None),
            "condition_number": raw,
            "condition_number_scaled": scaled,
        },
        "visibility": visibility_document(problem.visibility),
        "constant_torques": {"joints": [j + 1 for j in problem.held.joints], "sigma": problem.held.sigma},
        "ripple": [
            {
                "source": run.source,
                "joint": one.joint,
                "waves_per_turn": one.waves,
                "amplitude": one.amplitude,
                "probability_by_noise": RIPPLE_CHANCE,
            }
            for run in problem.runs
            for one in run.ripple
        ],
        "quantities": quantities_document(answer),
        "estimates": _estimates(answer),
        "recommended": {"method": problem.method, "estimator": "constrained" if answer.constrained else "wls"},
        "mass_from_scale": found.from_scale,
        "agreement": [{"name": way.name, "mass": way.mass, "com": way.com} for way in answer.agreement],
        "mass_by_joints": mass_by_joints_document(answer.by_joints),
        "repeats": _repeats(answer),
        "assumed": _assumed(answer),
        "verdict": {"level": answer.verdict.level, "reasons": list(answer.verdict.reasons)},
    }


def visibility_document(found: PayloadVisibility) -> Document:
    """Which of the ten the torques of some joints show."""
    return {
        "joints": list(found.joints),
        "rank": found.rank,
        "parameters": found.parameters,
        "combinations": list(found.combinations),
    }


def quantities_document(answer: WeighAnswer) -> Document:
    """Mass, centre of mass and inertia with interval, and whether to use them."""
    intervals = answer.constrained.intervals if answer.constrained is not None else None
    body = answer.assumed or (answer.constrained.body if answer.constrained is not None else None)
    measured = answer.stand_in is None and intervals is not None
    values: dict[str, tuple[Any, Any, Any]] = {
        "mass": (answer.mass, list(answer.mass_interval), answer.spread.mass),
        "centre of mass": (answer.com, answer.com_interval, answer.spread.com),
        "inertia": (
            body.inertia_com if body is not None else None,
            intervals.inertia_com if measured and intervals is not None else None,
            answer.spread.inertia_com if measured else None,
        ),
    }
    return {
        name.replace(" ", "_"): {
            "use": answer.judged[name].use,
            "why": answer.judged[name].why or None,
            "value": value,
            "interval95": interval,
            "sigma": sigma,
        }
        for name, (value, interval, sigma) in values.items()
    }


def _estimates(answer: WeighAnswer) -> list[Document]:
    """As of ``payload``; parameters that are not determined are null."""
    problem, found = answer.problem, answer.found
    if answer.constrained is not None:
        free = PayloadEstimate(problem.method, found.estimate, problem.robot.payload_frame, found.without_robust)
        return [free_estimate_document(free), constrained_estimate_document(answer.constrained)]
    robust = found.estimate.sigma_robust
    return [
        {
            "method": problem.method,
            "estimator": "wls",
            "parameters": _named(answer.ten),
            "sigma": _named(_spread(found.places, found.estimate.sigma)),
            "sigma_robust": _named(_spread(found.places, robust)) if robust is not None else None,
            "interval95": None,
            "com": answer.com,
            "com_sigma": answer.spread.com,
            "inertia_com": None,
            "physically_consistent": None,
        }
    ]


def _spread(places: Sequence[int], values: Array) -> Array:
    ten = np.full(10, np.nan)
    ten[list(places)] = values
    return ten


def _named(values: Array) -> dict[str, float]:
    return dict(zip(INERTIAL, values.tolist(), strict=True))


def _repeats(answer: WeighAnswer) -> Document | None:
    repeats = answer.repeats
    if repeats is None:
        return None
    drift = repeats.drift
    return {
        **asdict(repeats),
        "spread": repeats.spread,
        "excess": repeats.excess,
        "drift_per_recording": drift[0] if drift else None,
        "drift_sigma": drift[1] if drift else None,
        "drifts": repeats.drifts,
    }


def _assumed(answer: WeighAnswer) -> Document | None:
    body = answer.assumed
    if answer.stand_in is None or body is None:
        return None
    return {"inertia": answer.stand_in.description, "parameters": body.named()}
