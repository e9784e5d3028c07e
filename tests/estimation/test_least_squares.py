"""Least squares against the plain formulas: rows, priors, known columns, and backward elimination."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.linear import RANK_TOLERANCE
from dynident.estimation import PAYLOAD, Estimate, Settings, SigmaBound, SigmaRatio, identify
from dynident.estimation.answers.identification import impossible_payload
from dynident.estimation.equations.equations import Equations, checked, merged
from dynident.estimation.equations.observer import Observation, Observer, reduced, used
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.linear_problem import (
    Elimination,
    Known,
    LinearProblem,
    SoftPrior,
    eliminate,
    excitation,
    weighted,
)
from dynident.estimation.signals.filtering import measurement
from dynident.model import INERTIAL, InertialParameters, Processing, base_parameters, load_robot
from dynident.model.friction import PAPER
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from hypothesis import given, settings
from hypothesis import strategies as st

NAMES = ("a", "b", "c", "d")


def ordinary(problem: Equations) -> Estimate:
    """Ordinary least squares (16)."""
    return weighted(problem, np.ones(len(problem.rows)))


def observation(
    seed: int, rows: tuple[int, ...] = (300, 200), noise: float = 0.1, bandwidth: float = 1.0
) -> Observation:
    draw = np.random.default_rng(seed)
    W = tuple(draw.standard_normal((r, 4)) * [1.0, 10.0, 0.1, 1.0] for r in rows)
    truth = np.array([1.0, -2.0, 30.0, 0.0])
    Y = tuple(w @ truth + noise * (k + 1) * draw.standard_normal(len(w)) for k, w in enumerate(W))
    return Observation.of(NAMES, W, Y, tuple(np.arange(float(r)) for r in rows), bandwidth)


@given(st.integers(0, 1000), st.integers(5, 5000))
@settings(max_examples=30, deadline=None)
def test_reduction_keeps_norms_and_products(seed: int, rows: int) -> None:
    data = observation(seed, (rows, 7))
    problem = reduced(data)
    for factor, W, Y in zip(problem.factors, data.W, data.Y, strict=True):
        whole = np.column_stack([W, Y])
        assert factor.shape[0] <= 5 or rows == 7
        assert np.allclose(
            factor.T @ factor, whole.T @ whole, rtol=1e-10, atol=1e-9 * np.abs(whole).max() ** 2 * rows
        )


def test_order_of_rows_does_not_matter_and_merging_is_stacking() -> None:
    data = observation(0)
    order = np.random.default_rng(1).permutation(300)
    shuffled = Observation.of(NAMES, (data.W[0][order], data.W[1]), (data.Y[0][order], data.Y[1]), data.t, 1.0)
    halves = [
        Observation.of(
            NAMES, tuple(w[s] for w in data.W), tuple(y[s] for y in data.Y), tuple(t[s] for t in data.t), 1.0
        )
        for s in (slice(None, 90), slice(90, None))
    ]
    whole = weighted(reduced(data))
    for again in (weighted(reduced(shuffled)), weighted(merged(reduced(half) for half in halves))):
        assert np.allclose(whole.values, again.values, rtol=1e-10, atol=1e-12)
        assert np.allclose(whole.covariance, again.covariance, rtol=1e-8)
        assert whole.fit.rows == again.fit.rows


def test_ordinary_least_squares_and_its_statistics() -> None:
    """(16)-(21), written out on the full matrices."""
    data = observation(2)
    W, Y = np.vstack(data.W), np.concatenate(data.Y)
    estimate = ordinary(reduced(data))
    x = np.linalg.lstsq(W, Y, rcond=None)[0]
    variance = np.sum((Y - W @ x) ** 2) / (len(Y) - 4)
    C = variance * np.linalg.inv(W.T @ W)
    assert np.allclose(estimate.values, x)
    assert np.allclose(estimate.covariance, C)
    assert np.allclose(estimate.sigma, np.sqrt(np.diag(C)))
    assert np.allclose(estimate.relative_sigma_percent, 100 * np.sqrt(np.diag(C)) / np.abs(x))
    assert estimate.fit.relative == pytest.approx(np.linalg.norm(Y - W @ x) / np.linalg.norm(Y))


def test_weighted_least_squares() -> None:
    """Weights from the ordinary residual of each joint."""
    data = observation(3)
    problem = reduced(data)
    x = ordinary(problem).values
    weights = problem.joint_weights(x)
    spread = [np.linalg.norm(Y - W @ x) / np.sqrt(len(Y)) for W, Y in zip(data.W, data.Y, strict=True)]
    assert weights[0] / weights[1] == pytest.approx(spread[1] / spread[0])
    W = np.vstack([w * weight for w, weight in zip(data.W, weights, strict=True)])
    Y = np.concatenate([y * weight for y, weight in zip(data.Y, weights, strict=True)])
    assert np.allclose(weighted(problem).values, np.linalg.lstsq(W, Y, rcond=None)[0])


def test_units_of_parameters_do_not_matter() -> None:
    data = observation(5)
    factors = np.array([1.0, 1e-3, 1e4, 7.0])
    scaled = Observation.of(NAMES, tuple(w * factors for w in data.W), data.Y, data.t, 1.0)
    a, b = weighted(reduced(data)), weighted(reduced(scaled))
    assert np.allclose(a.values, b.values * factors, rtol=1e-9)
    assert np.allclose(a.sigma, b.sigma * factors, rtol=1e-9)
    assert reduced(data).condition_numbers()[1] == pytest.approx(reduced(scaled).condition_numbers()[1])


def test_condition_numbers() -> None:
    data = observation(6)
    W = np.vstack(data.W)
    raw, scaled = reduced(data).condition_numbers()
    assert raw == pytest.approx(np.linalg.cond(W))
    assert scaled == pytest.approx(np.linalg.cond(W / np.linalg.norm(W, axis=0)))


def deficient(change: Callable[[Array], Array]) -> Equations:
    data = observation(7)
    return reduced(Observation.of(NAMES, tuple(change(w) for w in data.W), data.Y, data.t, 1.0))


def test_rank_deficient_data_are_refused_with_the_directions_named() -> None:
    def copied(w: Array) -> Array:
        return np.column_stack([w[:, 0], w[:, 1], 2.0 * w[:, 1], w[:, 3]])

    def silent(w: Array) -> Array:
        return w * [1.0, 1.0, 1.0, 0.0]

    with pytest.raises(InputError, match=r"1 of 4 directions undetermined, in b, c:"):
        ordinary(deficient(copied))
    with pytest.raises(InputError, match=r"1 of 4 directions undetermined, in d:"):
        ordinary(deficient(silent))
    assert deficient(copied).condition_numbers() == (np.inf, np.inf)


def test_fewer_samples_than_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="3 equations for 4 parameters: fewer samples"):
        ordinary(reduced(observation(8, (2, 1))))
    with pytest.raises(InputError, match=r"too short .*: record 20 s or more"):
        ordinary(reduced(observation(8, (3, 1))))


@pytest.mark.parametrize("decades", range(1, 13))
def test_rank_is_a_matter_of_singular_values(decades: int) -> None:
    """Whatever shortcut is taken for triangles that are clearly well determined."""
    draw = np.random.default_rng(decades)
    U, V = (np.linalg.qr(draw.standard_normal((12, 12)))[0] for _ in range(2))
    R = np.linalg.qr(U * np.logspace(0.0, -decades, 12) @ V)[1]
    names, Y = tuple(f"x{k}" for k in range(12)), np.zeros((12, 1))
    singular = np.linalg.svd(R / np.linalg.norm(R, axis=0), compute_uv=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        with pytest.raises(InputError, match="undetermined"):
            checked(np.hstack([R, Y]), names, 100, 100.0)
    else:
        checked(np.hstack([R, Y]), names, 100, 100.0)
        checked(np.hstack([R[::-1], Y]), names, 100, 100.0)


COLUMNS = ("A", "B", "C", "D")
TRUTH = np.array([1.0, -2.0, 0.5, 3.0])
WEIGHTS = np.array([2.0, 0.5])


def rows(seed: int) -> Array:
    """[W Y] of one joint with noise."""
    draw = np.random.default_rng(seed)
    W = draw.standard_normal((40, 4))
    return np.column_stack([W, W @ TRUTH + 0.1 * draw.standard_normal(40)])


EQUATIONS = Equations(COLUMNS, (rows(0), rows(1)), (40, 40), (40.0, 40.0))
STACKED = np.vstack([w * rows(k) for k, w in enumerate(WEIGHTS)])


def by_hand(A: Array, y: Array) -> Array:
    return np.asarray(np.linalg.lstsq(A, y, rcond=None)[0])


def test_a_column_held_tightly_is_zero_and_held_loosely_is_free() -> None:
    """The equation of a held column is one row more, its sigma the row's unit."""
    for sigma, expected in (
        (1e-7, by_hand(STACKED[:, :3], STACKED[:, 4])),
        (1e7, by_hand(STACKED[:, :4], STACKED[:, 4])[:3]),
        (0.3, by_hand(np.vstack([STACKED[:, :4], [[0, 0, 0, 1 / 0.3]]]), np.append(STACKED[:, 4], 0.0))[:3]),
    ):
        problem = LinearProblem(EQUATIONS, COLUMNS[:3], soft={"D": SoftPrior(sigma)})
        assert problem.solved(WEIGHTS).values == pytest.approx(expected, abs=1e-9)
        assert problem.solved(WEIGHTS).values == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("inflation", [1.0, 4.0])
def test_what_a_held_column_lasts_is_its_influence(inflation: float) -> None:
    """The values move by as much as the level they are held at; no block of time shows that level.

    Data that are worth four times less leave the prior four times the weight; it errs no more than it did.
    """
    sigma, row = 0.3, np.sqrt(inflation) / 0.3
    A = np.vstack([STACKED[:, :4], [[0, 0, 0, row]]])
    problem = LinearProblem(EQUATIONS, COLUMNS[:3], soft={"D": SoftPrior(sigma, inflation)})
    assert problem.solved(WEIGHTS).values == pytest.approx(by_hand(A, np.append(STACKED[:, 4], 0.0))[:3], abs=1e-9)
    moved = by_hand(A, np.append(0.0 * STACKED[:, 4], row))[:3]
    assert problem.lasting(WEIGHTS) == pytest.approx(sigma**2 * np.outer(moved, moved), rel=1e-9)


def test_errors_that_remember_by_hand() -> None:
    """The sandwich: each joint's errors by their own size, as much larger in variance as their memory says."""
    x = by_hand(STACKED[:, :4], STACKED[:, 4])
    inverse, middle = np.linalg.inv(STACKED[:, :4].T @ STACKED[:, :4]), np.zeros((4, 4))
    memory = (3.0, 7.0)
    for k, weight in enumerate(WEIGHTS):
        W, Y = rows(k)[:, :4], rows(k)[:, 4]
        size = float(np.sum((Y - W @ x) ** 2)) / (40 * (1.0 - 4 / 80))
        middle += memory[k] * weight**4 * size * W.T @ W
    covariance = LinearProblem(EQUATIONS, COLUMNS).sandwich(WEIGHTS, memory)
    assert covariance == pytest.approx(inverse @ middle @ inverse, rel=1e-9)


def test_known_columns_bring_their_covariance_and_their_gains() -> None:
    C = np.diag([0.04, 0.09])
    own = np.array([[0.1, 0.2], [0.3, 0.4]])
    known = Known(COLUMNS[2:], TRUTH[2:], C, 0.5 * C, gain_sensitivity=own)
    problem = LinearProblem(EQUATIONS, COLUMNS[:2], (known,))
    estimate = problem.estimate(WEIGHTS)
    left = STACKED[:, 4] - STACKED[:, 2:4] @ TRUTH[2:]
    assert estimate.values == pytest.approx(by_hand(STACKED[:, :2], left))
    P = np.linalg.lstsq(STACKED[:, :2], STACKED[:, 2:4], rcond=None)[0]
    exact = LinearProblem(EQUATIONS, COLUMNS[:2], (known._replace(covariance=0.0 * C),)).estimate(WEIGHTS)
    assert estimate.covariance - exact.covariance == pytest.approx(P @ C @ P.T)
    assert problem.lasting(WEIGHTS) == pytest.approx(0.5 * P @ C @ P.T)
    assert estimate.gain_sensitivity is not None
    for joint in range(2):
        louder = [factor.copy() for factor in EQUATIONS.factors]
        louder[joint][:, -1] *= 2.0
        moved_known = known._replace(values=known.values + own[:, joint])
        changed = LinearProblem(replace(EQUATIONS, factors=tuple(louder)), COLUMNS[:2], (moved_known,))
        step = changed.solved(WEIGHTS).values - estimate.values
        assert estimate.gain_sensitivity[:, joint] == pytest.approx(step, abs=1e-9)
    blind = LinearProblem(EQUATIONS, COLUMNS[:2], (known._replace(gain_sensitivity=None),))
    assert blind.estimate(WEIGHTS).gain_sensitivity is None


def test_signal_and_own_part_of_each_column() -> None:
    """The part of a column that others cannot imitate, by an explicit regression on the dense equations."""
    robot = load_robot("rx90")
    base = base_parameters(robot)
    recording = Simulator(robot).record(random_via_points(robot, 8, seed=3).motion(100.0), None, RX90_NOISE, [3])
    processing = Processing()
    observation = Observer(robot, base.columns).observe(*used(measurement(recording, processing), processing))
    factors = tuple(
        np.asarray(np.linalg.qr(np.column_stack(pair), "r"))
        for pair in zip(observation.W, observation.Y, strict=True)
    )
    rows = tuple(len(Y) for Y in observation.Y)
    problem = Equations(base.columns, factors, rows, tuple(map(float, rows)))
    estimate = weighted(problem)
    signals = excitation(problem, estimate)
    assert signals.names == base.columns
    assert np.allclose(signals.independent, np.abs(estimate.values) / estimate.sigma, rtol=1e-6)
    W = np.vstack([w * part for w, part in zip(estimate.weights, observation.W, strict=True)])
    for k in (0, 7, 20, 53):
        scaled = np.delete(W, k, axis=1) / np.linalg.norm(np.delete(W, k, axis=1), axis=0)
        rest = W[:, k] - scaled @ by_hand(scaled, W[:, k])
        assert signals.share[k] == pytest.approx(np.linalg.norm(rest) / np.linalg.norm(W[:, k]), rel=1e-6)
    assert (signals.share <= 1.0 + 1e-9).all()


NOTHING = Fit(np.ones(1), np.ones(1), (1,))


def refitted(problem: Equations, weights: Array) -> tuple[list[str], list[float], list[float]]:
    """Order, error's standard deviation and largest relative sigma, every set solved by ``numpy.linalg.lstsq``."""
    columns = list(problem.columns)
    order: list[str] = []
    errors: list[float] = []
    largest: list[float] = []
    effective = sum(problem.effective_rows)
    while True:
        rows = np.vstack([w * f for w, f in zip(weights, problem.select(columns).factors, strict=True)])
        x = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
        variance = float(np.sum((rows[:, -1] - rows[:, :-1] @ x) ** 2)) / (effective - len(columns))
        errors.append(np.sqrt(variance))
        if not columns:
            return order, errors, largest
        inverse = np.linalg.pinv(rows[:, :-1])
        relative = np.sqrt(variance * np.sum(inverse**2, axis=1)) / np.abs(x)
        largest.append(float(relative.max()))
        order.append(columns.pop(int(relative.argmax())))


def test_the_path_is_that_of_refits() -> None:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    motions = [random_via_points(robot, 14, seed=k).motion(250.0) for k in range(2)]
    records = [simulator.record(m, None, RX90_NOISE, [0, k, 0], f"{k}") for k, m in enumerate(motions)]
    result = identify(robot, records, Settings(robust=False, friction=PAPER))
    order, errors, largest = refitted(result.problem, result.estimate.weights)
    assert list(result.elimination.order) == order
    ratio, sigma = result.elimination.path.T
    assert ratio == pytest.approx(np.array(errors) / errors[0], rel=1e-10)
    assert sigma == pytest.approx([*largest, 0.0], rel=1e-10)
    for rule in (SigmaRatio(), SigmaBound(0.1)):
        elimination = eliminate(result.problem, result.estimate, rule)
        again = weighted(result.problem.select(elimination.essential), result.estimate.weights)
        assert np.abs((elimination.estimate.values - again.values) / again.sigma).max() < 1e-10
        assert elimination.estimate.covariance == pytest.approx(
            again.covariance, rel=1e-9, abs=1e-12 * again.sigma.max()
        )
        assert elimination.estimate.fit.relative == pytest.approx(again.fit.relative, rel=1e-12)


def test_elimination_ends_where_the_rule_says() -> None:
    path = np.array([1.0, 1.01, 1.03, 1.01, 9.0]), np.array([5.0, 0.5, 0.2, 0.05, 0.0])
    assert [SigmaRatio(limit).eliminated(*path) for limit in (1.005, 1.02, 1.03, 1.04, 10.0)] == [0, 1, 1, 3, 4]
    assert [SigmaBound(limit).eliminated(*path) for limit in (9.0, 0.5, 0.3, 0.1, 0.01)] == [0, 1, 2, 3, 4]


def payload_elimination(values: Array, left: tuple[str, ...], relative: float = 0.01) -> Elimination:
    """Elimination down to some of the payload's parameters, estimated within ``relative``."""
    gone = tuple(name for name in PAYLOAD if name not in left)
    places = [PAYLOAD.index(name) for name in left]
    x = values[places]
    estimate = Estimate(left, x, np.diag((relative * x) ** 2), np.inf, NOTHING, np.ones(1))
    return Elimination((*gone, *left), np.tile([1.0, 0.0], (11, 1)), SigmaRatio(), estimate)


LEFT = ("XX_L", "YY_L", "ZZ_L", "MZ_L", "M_L")


def test_zeros_that_a_payload_may_have(payload: InertialParameters) -> None:
    """The paper's Table 2 leaves XX, YY, ZZ, MZ and M of a disc on the flange's axis."""
    body = InertialParameters.from_com(7.0, [0.0, 0.0, 0.14], np.diag([0.02, 0.019, 0.035]))
    elimination = payload_elimination(body.vector, LEFT)
    assert elimination.eliminated == ("XY_L", "XZ_L", "YZ_L", "MX_L", "MY_L")
    assert impossible_payload(elimination) == ()


@pytest.mark.parametrize("kind", ["XX", "YY", "ZZ"])
def test_a_moment_of_inertia_is_not_zero(payload: InertialParameters, kind: str) -> None:
    left = tuple(name for name in PAYLOAD if name != f"{kind}_L")
    (line,) = impossible_payload(payload_elimination(payload.vector, left))
    assert f"{kind}_L is eliminated" in line
    assert f"{kind[0].lower()} axis" in line
    off = {"XX": "MY_L, MZ_L", "YY": "MX_L, MZ_L", "ZZ": "MX_L, MY_L"}[kind]
    assert f"{off} must then be zero too" in line
    # On the axis itself nothing contradicts but the thickness.
    alone = payload_elimination(payload.vector, tuple(f"{k}_L" for k in INERTIAL if k in ("M", f"M{kind[0]}")))
    assert not any("must then" in line for line in impossible_payload(alone) if line.startswith(f"{kind}_L"))


def test_estimates_that_contradict_the_zeros(payload: InertialParameters) -> None:
    """m z^2 alone exceeds XX: the body would need a negative inertia at its centre of mass."""
    values = payload.vector.copy()
    values[0] *= 0.5
    (line,) = impossible_payload(payload_elimination(values, LEFT))
    assert "no payload that can exist" in line
    assert impossible_payload(payload_elimination(values, LEFT, relative=1.0)) == ()
