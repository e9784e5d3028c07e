"""What is identified from one simulated experiment, beside the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ... import estimation, trajectories
from ...common.arrays import Array
from ...common.progress import Progress, silent
from .repetition import Answer, Outcome, answer_of

ESSENTIAL_BOUND = 0.10
"""Largest relative standard deviation of an essential parameter: the paper says 5 to 10 %."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Everything identified from one experiment.

    Attributes:
        experiment: the experiment; its last trajectory is held out.
        robot: from the runs without payload alone.
        answer: the payload by all methods.
        joint: robot and payload by method 4, with robust covariance.
        essential: the same after elimination.
        truth: of ``joint``'s parameters by name; dry friction averaged over the motion.
        held_out: fit of ``joint`` on the held-out trajectory with payload.
    """

    experiment: trajectories.Experiment
    robot: estimation.Identification
    answer: estimation.PayloadAnswer
    joint: estimation.Estimate
    essential: estimation.Estimate
    truth: dict[str, float]
    held_out: estimation.fit.Fit


def analyse(experiment: trajectories.Experiment, progress: Progress = silent) -> Analysis:
    """Identify robot and payload as the paper does."""
    robot = experiment.robot
    problem = reduced_experiment(experiment, progress)
    last = [run.recording for run in experiment.runs[-2:]]
    unloaded = [run.recording for run in experiment.runs[:-2:2]]
    progress("the robot alone")
    alone = estimation.identify(robot, unloaded, validation=last[:1], progress=progress, robust=True)
    progress("the payload")
    answer = estimation.answer_payload(problem, held_out=last[:1])
    progress("robot and payload together")
    joint, essential = robust_joint(problem), essential_joint(problem)
    loaded = estimation.payload.loaded_problem(
        robot, problem.base, [estimation.signals.measurement(last[1], robot.processing)], robot.processing
    )
    truth = true_values(experiment, problem)
    return Analysis(experiment, alone, answer, joint, essential, truth, estimation.fit.fit(loaded, joint.values))


def reduced_experiment(
    experiment: trajectories.Experiment, progress: Progress = silent
) -> estimation.PayloadProblem:
    """The equations of all runs but those of the held-out trajectory."""
    used = [run.recording for run in experiment.runs[:-2]]
    return estimation.payload_problem(
        experiment.robot, used[1::2], used[::2], progress=progress, robust=True, friction_change=0.0
    )


def robust_joint(problem: estimation.PayloadProblem) -> estimation.Estimate:
    """Robot and payload by method 4, all base parameters."""
    every = problem.loaded.columns
    return estimation.payload.with_robust(problem, lambda part: estimation.payload.selected(part, every))[0]


def essential_joint(problem: estimation.PayloadProblem) -> estimation.Estimate:
    """Essential parameters of robot and payload, as in Table 2.

    By the bound on the relative standard deviations, the other of the paper's two rules: here the rule of 1.02
    also cancels moments of the payload that are known to 3 %, and others take their place.
    """
    names = estimation.payload.essential_combined(problem, estimation.SigmaBound(ESSENTIAL_BOUND)).essential
    return estimation.payload.with_robust(problem, lambda part: estimation.payload.selected(part, names))[0]


def true_values(experiment: trajectories.Experiment, problem: estimation.PayloadProblem) -> dict[str, float]:
    """Base parameters and payload of the simulated robot, by name."""
    friction = trajectories.simulation.mean_friction(experiment.runs[:-2])
    base = problem.base.value(dict(experiment.robot.parameters) | friction)
    payload = experiment.runs[1].task.payload
    assert payload is not None
    return dict(zip(problem.base.columns, base.tolist(), strict=True)) | dict(
        zip(estimation.PAYLOAD, payload.vector.tolist(), strict=True)
    )


def outcome(experiment: trajectories.Experiment, robot: bool = True) -> Outcome:
    """Each estimator's answer beside the truth, and what kind of data it is; ``robot``: its parameters too."""
    problem = reduced_experiment(experiment)
    assert problem.unloaded is not None
    truth = true_values(experiment, problem)
    answer = estimation.answer_payload(problem)
    found: dict[str, Answer] = {}
    if robot:
        joint = robust_joint(problem)
        found["robot"] = answer_of(joint, _of(truth, joint.names))
    for estimate in answer.estimates:
        found[f"method {estimate.method}"] = answer_of(estimate.estimate, _of(truth, estimation.PAYLOAD))
    for payload in answer.constrained:
        low, high = payload.intervals.parameters.T
        body = Answer(
            estimation.PAYLOAD, _of(truth, estimation.PAYLOAD), payload.body.vector, low, high, payload.sigma
        )
        found[f"method {payload.method}, constrained"] = body
    alone = estimation.fit.weighted(problem.unloaded).fit
    return Outcome(
        found,
        alone.relative,
        tuple(alone.relative_per_joint.tolist()),
        problem.unloaded.equations,
        problem.unloaded.condition_numbers()[0],
    )


def _of(truth: dict[str, float], names: Sequence[str]) -> Array:
    return np.array([truth[name] for name in names])
