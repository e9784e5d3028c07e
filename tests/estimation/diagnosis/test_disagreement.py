"""By how much joints that disagree widen every interval: nothing for chance, all of it where it is none."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.diagnosis.joints import CHANCE, disagreement
from dynident.estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import f

K, FREEDOM = 6, 20
EXACT = np.zeros((K, K))


def seen(offs: Array, sigmas: Array, freedom: float = FREEDOM) -> ByJoints:
    """Shares that differ from 1, and the degrees of freedom of their standard deviations."""
    masses = (JointsMass((1,), 1.0, 0.1, freedom),)
    rows = enumerate(zip(offs, sigmas, strict=True), 1)
    return ByJoints(masses, tuple(JointShare(joint, 1.0 + float(x), float(s)) for joint, (x, s) in rows))


def even(square: float) -> ByJoints:
    """All joints off alike, their mean square in units of their variances."""
    return seen(np.full(K, 0.02 * np.sqrt(square)), np.full(K, 0.02))


def test_what_chance_brings_about_widens_one_of_ten() -> None:
    draw, widened = np.random.default_rng(0), 0
    for _ in range(1000):
        sigmas = 0.02 * np.sqrt(draw.chisquare(FREEDOM) / FREEDOM) * np.ones(K)
        widened += disagreement(seen(0.02 * draw.standard_normal(K), sigmas), EXACT) > 1.0
    assert 0.07 < widened / 1000 < 0.13


def test_where_it_begins_and_where_it_is_whole() -> None:
    first, last = (float(f.isf(chance, K, FREEDOM)) for chance in CHANCE)
    assert disagreement(even(0.999 * first), EXACT) == 1.0
    assert 1.0 < disagreement(even(1.01 * first), EXACT) < 1.05
    for square in (1.001 * last, 30.0):
        assert disagreement(even(square), EXACT) == pytest.approx(np.sqrt(K * square / (K - 1)))


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0))
def test_more_disagreement_never_widens_less(a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert disagreement(even(low), EXACT) <= disagreement(even(high), EXACT) + 1e-12


def test_a_gain_that_is_off_widens_unless_gains_are_told_unsure() -> None:
    offs = np.array([0.0, -0.08, 0.05, 0.0, 0.0, 0.0])
    view = seen(offs, np.full(K, 0.01))
    assert disagreement(view, EXACT) > 3.0
    assert disagreement(view, 0.05**2 * np.eye(K)) == 1.0


def test_standard_deviations_from_few_blocks_prove_less() -> None:
    """Where they come from three blocks, the same shares are chance."""
    offs, sigmas = np.full(K, 0.05), np.full(K, 0.02)
    assert disagreement(seen(offs, sigmas, 1e9), EXACT) > 2.0
    for few in (True, False):
        assert disagreement(seen(offs, sigmas, 2.0), EXACT, few) == 1.0


def test_one_joint_alone_cannot_disagree() -> None:
    alone = ByJoints((JointsMass((1,), 1.0, 0.1, FREEDOM),), (JointShare(2, 1.5, 0.01), JointShare(3, None)))
    assert disagreement(alone, EXACT) == 1.0
