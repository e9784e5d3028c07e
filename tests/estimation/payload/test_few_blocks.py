"""A few seconds with payload: too few blocks for a jackknife, and intervals that hold all the same."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dynident.apps.report.sections.estimates import method_notes
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import (
    FRICTION_CHANGE,
    Estimate,
    LongMotion,
    Settings,
    answer_payload,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.fit.blocks import FEWEST
from dynident.estimation.fit.covariance import student95
from dynident.estimation.payload.methods import METHODS, from_robot
from dynident.estimation.payload.weighing import known_robot_weighing
from dynident.model import Recording
from dynident.model.friction import PAPER
from dynident.tests.estimation.payload.recordings import cut
from dynident.tests.estimation.payload.test_friction import LOAD, NAME, SEEDS, recordings

ROBOT = invented.robot(NAME)


def begun(seed: int, change: float = 0.0) -> tuple[Recording, Recording]:
    """The whole recording without payload, 12 s of the one with it."""
    bare, loaded = recordings(seed, change)
    return bare, cut(loaded, loaded.t[0] + 15.0, loaded.t[0] + 27.0)


def problem_of(seed: int) -> LongMotion:
    bare, loaded = begun(seed)
    return payload_problem(ROBOT, [loaded], [bare])


def few(problem: LongMotion) -> LongMotion:
    """With blocks that are taken for too few."""
    return replace(problem, few=True)


def off(estimate: Estimate) -> tuple[float, float]:
    """Error of the mass, and half of its interval."""
    assert estimate.robust is not None
    half = student95(estimate.robust.degrees_of_freedom) * estimate.robust.sigma[9]
    return float(estimate["M_L"] - LOAD.mass), float(half)


def test_blocks_that_are_too_few_are_cut_shorter_and_the_memory_counts() -> None:
    """On both sides: 12 s of the loaded recording, and all of it."""
    whole = payload_problem(ROBOT, recordings(0, 0.0)[1:], recordings(0, 0.0)[:1])
    assert not whole.few
    assert len(whole.loaded.blocks) >= FEWEST
    short = few(problem_of(0))
    for method in (1, 3, 4) if short.difference is not None else (1, 4):
        posed = METHODS[method](short)
        estimate = payload_estimate(short, method).estimate
        assert estimate.robust is not None
        assert estimate.robust.by_memory
        memory = posed.sandwich(estimate.weights, short.inflation)
        assert (estimate.robust.sigma >= 0.999999 * np.sqrt(np.diag(memory))).all()
        alone = payload_estimate(replace(short, few=False), method).estimate.robust
        assert alone is not None
        if not alone.by_memory:
            assert estimate.robust.sigma == pytest.approx(
                np.maximum(alone.sigma, np.sqrt(np.diag(memory))), rel=1e-9
            )


@pytest.mark.long
def test_intervals_of_few_seconds_hold_and_say_so() -> None:
    for seed in range(3):
        problem = few(problem_of(seed))
        error, half = off(payload_estimate(problem, 4).estimate)
        assert abs(error) < half < 0.15 * LOAD.mass
    answer = answer_payload(problem, (4,))
    text = " ".join(method_notes(answer.result))
    assert "too few for a jackknife: intervals go by the memory of the errors" in text


@cache
def stored(seed: int) -> Estimate:
    return identify(ROBOT, recordings(seed, 0.0)[:1], Settings(friction=PAPER)).estimate


@pytest.mark.parametrize("short", [True, False])
def test_a_stored_robot_is_corrected_within_its_covariance_and_friction(short: bool) -> None:
    """12 s on another day: in the interval, which is shorter than with friction next to free, and within 7 %."""
    for seed in range(3):
        known, loaded, halves = stored(seed), begun(seed, 0.1)[1], []
        for share in (FRICTION_CHANGE, 0.9):
            problem = (
                known_robot_weighing(ROBOT, [loaded], known, settings=Settings(friction_change=share))
                if short
                else payload_problem(ROBOT, [loaded], known=known, settings=Settings(friction_change=share))
            )
            assert problem.corrected
            error, half = off(payload_estimate(problem, 1).estimate)
            assert abs(error) < half
            halves.append(half)
        assert halves[0] < min(halves[1], 0.07 * LOAD.mass)


def test_the_prior_of_a_stored_robot_has_full_rank() -> None:
    """A jackknife of a dozen blocks has not; standard deviations are its own, the correlations the formula's."""
    known = stored(0)
    assert known.robust is not None
    sizes, directions = np.linalg.eigh(known.robust.covariance)
    few = directions[:, -12:] * sizes[-12:] @ directions[:, -12:].T
    known = replace(known, robust=replace(known.robust, covariance=few))
    assert known.robust is not None
    assert np.linalg.matrix_rank(few) < len(known.names)
    loaded = begun(0)[1]
    problem = payload_problem(ROBOT, [loaded], known=known)
    posed = from_robot(problem)
    assert posed.prior is not None
    assert np.sqrt(np.diag(posed.prior.covariance)) == pytest.approx(known.robust.sigma)
    root: Array = posed.prior.root
    identity = root @ posed.prior.covariance @ root.T / posed.prior.inflation
    assert identity == pytest.approx(np.eye(len(root)), abs=1e-6)


def test_a_stored_robot_does_not_take_up_slow_errors() -> None:
    """Noise that forgets in 0.2 s, rows 0.1 s apart: its memory raises variances by (1 + r) / (1 - r) = 4.1.

    All parameters found anew in ten seconds explain most of it away.
    """
    expected = float((1.0 + np.exp(-0.5)) / (1.0 - np.exp(-0.5)))
    inflations, anew = list[float](), list[float]()
    for seed in range(SEEDS):
        loaded = begun(seed)[1]
        inflations += payload_problem(ROBOT, [loaded], known=stored(seed)).inflation
        anew += payload_problem(ROBOT, [loaded], recordings(seed, 0.0)[:1]).inflation
    assert np.median(inflations) == pytest.approx(expected, rel=0.3)
    assert np.median(anew) < 0.75 * expected
