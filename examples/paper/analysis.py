"""Parameters identified from one simulated experiment, beside the truth."""

from __future__ import annotations

import numpy as np
from dynident import estimation, trajectories
from dynident.estimation.fit.linear_problem import eliminate

ESSENTIAL_BOUND = 0.10
"""Largest relative standard deviation of an essential parameter: the paper says 5 to 10 %."""


def robust_joint(problem: estimation.LongMotion) -> estimation.Estimate:
    """Robot and payload by method 4, all base parameters."""
    every = problem.loaded.columns
    return estimation.with_robust(problem, estimation.selected(problem, every))[0]


def essential_joint(problem: estimation.LongMotion) -> estimation.Estimate:
    """Essential parameters of robot and payload, as in Table 2.

    By the bound on the relative standard deviations, the other of the paper's two rules: here the rule of 1.02
    also cancels moments of the payload that are known to 3 %, and others take their place.
    """
    names = eliminate(
        problem.both, estimation.weighted(problem.both), estimation.SigmaBound(ESSENTIAL_BOUND)
    ).essential
    return estimation.with_robust(problem, estimation.selected(problem, names))[0]


def true_values(experiment: trajectories.Experiment, problem: estimation.LongMotion) -> dict[str, float]:
    """Base parameters and payload of the simulated robot, by name."""
    runs = experiment.runs[:-2]
    weights = [len(run.exact.motion.t) for run in runs]
    friction = {
        name: np.average([run.friction[name] for run in runs], weights=weights) for name in runs[0].friction
    }
    base = problem.base.value(dict(experiment.robot.parameters) | friction)
    payload = experiment.runs[1].task.payload
    assert payload is not None
    return dict(zip(problem.base.columns, base.tolist(), strict=True)) | dict(
        zip(estimation.PAYLOAD, payload.vector.tolist(), strict=True)
    )
