"""Bias, spread and coverage of an estimator, from an experiment repeated with other seeds."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from dynident import estimation, trajectories
from dynident.apps.commands.simulate import TRAJECTORIES, levels, paper_robot, reduced_experiment, simulate_paper
from dynident.common.arrays import Array
from dynident.estimation import Estimate
from dynident.examples.paper.analysis import robust_joint, true_values
from numpy.typing import NDArray


class Answer(NamedTuple):
    """One estimator's answer in one experiment, beside the truth.

    ``names``: of the parameters, c; ``truth``, ``values``, ``low``, ``high``, ``sigma``: shape (c,): the 95 %
    interval (nan where there is none) and the formula's standard deviation (17)-(19).
    """

    names: tuple[str, ...]
    truth: Array
    values: Array
    low: Array
    high: Array
    sigma: Array


class Outcome(NamedTuple):
    """One experiment: ``answers`` by estimator, and what kind of data it was.

    ``relative_residual`` of the robot's model without payload, over all joints and ``per_joint``; ``equations`` and
    ``condition_number`` (SI units, unweighted) of the runs without payload.
    """

    answers: dict[str, Answer]
    relative_residual: float
    per_joint: tuple[float, ...]
    equations: int
    condition_number: float


def answer_of(estimate: Estimate, truth: Array) -> Answer:
    """An estimate with its robust 95 % interval, by the formula where there is no robust one."""
    interval = estimate.interval95 if estimate.robust_interval95 is None else estimate.robust_interval95
    return Answer(estimate.names, truth, estimate.values, interval[:, 0], interval[:, 1], estimate.sigma)


@dataclass(frozen=True, eq=False)
class Repetition:
    """The answers of one estimator over S experiments.

    Attributes:
        names: of the parameters, c.
        truth, values, low, high, sigma: S x c.
    """

    names: tuple[str, ...]
    truth: Array
    values: Array
    low: Array
    high: Array
    sigma: Array

    @staticmethod
    def of(answers: Sequence[Answer]) -> "Repetition":
        """Put the answers below each other.

        Raises:
            ValueError: if their parameters differ.
        """
        if len({answer.names for answer in answers}) != 1:
            raise ValueError("answers of different parameters cannot be compared")
        stacked = (np.array([answer[k] for answer in answers]) for k in range(1, 6))
        return Repetition(answers[0].names, *stacked)

    @cached_property
    def error(self) -> Array:
        """Estimate less truth, S x c."""
        return self.values - self.truth

    @property
    def bias(self) -> Array:
        """Mean error, shape (c,)."""
        return np.asarray(self.error.mean(axis=0))

    @property
    def spread(self) -> Array:
        """Standard deviation of the error about its mean, shape (c,); nan for one experiment."""
        if len(self.error) < 2:
            return np.full(len(self.names), np.nan)
        return np.asarray(self.error.std(axis=0, ddof=1))

    @property
    def rms(self) -> Array:
        """Root mean square error, shape (c,)."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))

    @cached_property
    def covered(self) -> NDArray[np.bool_]:
        """True where the interval holds the truth, S x c."""
        return np.asarray((self.low <= self.truth) & (self.truth <= self.high))

    @property
    def coverage(self) -> Array:
        """Share of the experiments in which it does, shape (c,)."""
        return np.asarray(self.covered.mean(axis=0))

    def column(self, name: str) -> int:
        """Place of a parameter."""
        return self.names.index(name)

    def within(self, name: str, share: float) -> float:
        """Share of the experiments in which a parameter's error is within a share of the truth."""
        k = self.column(name)
        return float(np.mean(np.abs(self.error[:, k]) <= share * np.abs(self.truth[:, k])))


def outcome_of(experiment: trajectories.Experiment, robot: bool = True) -> Outcome:
    """Each estimator's answer beside the truth, and what kind of data it is; ``robot``: its parameters too."""
    problem = reduced_experiment(experiment)
    assert problem.unloaded is not None
    truth = true_values(experiment, problem)
    answer = estimation.answer_payload(problem)
    answers: dict[str, Answer] = {}
    if robot:
        joint = robust_joint(problem)
        answers["robot"] = answer_of(joint, _of(truth, joint.names))
    for estimate in answer.estimates:
        answers[f"method {estimate.method}"] = answer_of(estimate.estimate, _of(truth, estimation.PAYLOAD))
    for payload in answer.constrained:
        low, high = payload.intervals.parameters.T
        body = Answer(
            estimation.PAYLOAD,
            _of(truth, estimation.PAYLOAD),
            payload.body.vector,
            low,
            high,
            payload.result.free.sigma,
        )
        answers[f"method {payload.method}, constrained"] = body
    alone = estimation.weighted(problem.unloaded).fit
    return Outcome(
        answers,
        alone.relative,
        tuple(alone.relative_per_joint.tolist()),
        problem.unloaded.equations,
        problem.unloaded.condition_numbers()[0],
    )


def _of(truth: dict[str, float], names: Sequence[str]) -> Array:
    return np.array([truth[name] for name in names])


def one_experiment(seed: int, trajectories: int = TRAJECTORIES, gain_error: float = 0.02) -> dict[str, Outcome]:
    """One experiment in every scenario: the same runs, recorded with other errors of measurement."""
    robot = paper_robot()
    experiment = simulate_paper(robot, levels(robot, "paper"), seed, trajectories)
    recorded = {
        "paper": experiment,
        "slow": experiment.again(levels(robot, "slow")),
        "gains": experiment.again(levels(robot, "paper", gain_error)),
    }
    return {name: outcome_of(result, robot=name == "paper") for name, result in recorded.items()}
