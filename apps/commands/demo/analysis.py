"""What is identified from one simulated experiment, beside the truth."""

from __future__ import annotations

from dataclasses import dataclass

from .... import estimation, trajectories
from ....common.progress import Progress, silent

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
    measured = estimation.signals.measurement(last[1], robot.processing)
    loaded = estimation.payload.payload_equations(
        robot, problem.base, [measured], [], [], robot.processing, blocks=False
    ).loaded
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
