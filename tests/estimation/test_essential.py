"""Backward elimination against refits, its two stop rules, and what remains impossible."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import PAYLOAD, Estimate, Identification, Settings, SigmaBound, SigmaRatio, identify
from dynident.estimation.answers.identification import impossible_payload
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.essential import Elimination, EliminationPath, eliminate
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.least_squares import weighted
from dynident.model import INERTIAL, InertialParameters, load_robot
from dynident.model.friction import PAPER
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

NOTHING = Fit(np.ones(1), np.ones(1), (1,))

FIXED = Settings(robust=False, friction=PAPER)


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


def check_against_refits(result: Identification) -> None:
    order, errors, largest = refitted(result.problem, result.estimate.weights)
    path = result.elimination.path
    assert list(path.order) == order
    assert path.sigma_ratio == pytest.approx(np.array(errors) / errors[0], rel=1e-10)
    assert path.largest_relative_sigma == pytest.approx([*largest, 0.0], rel=1e-10)
    for rule in (SigmaRatio(), SigmaBound(0.1)):
        elimination = eliminate(result.problem, result.estimate, rule)
        again = weighted(result.problem.select(elimination.essential), result.estimate.weights)
        assert np.abs((elimination.estimate.values - again.values) / again.sigma).max() < 1e-10
        assert elimination.estimate.covariance == pytest.approx(
            again.covariance, rel=1e-9, abs=1e-12 * again.sigma.max()
        )
        assert elimination.estimate.fit.relative == pytest.approx(again.fit.relative, rel=1e-12)


@pytest.fixture(scope="module")
def simulated_rx90() -> Identification:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    motions = [random_via_points(robot, 14, seed=k).motion(250.0) for k in range(2)]
    records = [simulator.record(m, None, RX90_NOISE, [0, k, 0], f"{k}") for k, m in enumerate(motions)]
    return identify(robot, records, FIXED)


def test_the_path_is_that_of_refits(simulated_rx90: Identification) -> None:
    check_against_refits(simulated_rx90)


def test_elimination_ends_where_the_rule_says() -> None:
    path = EliminationPath(
        tuple("abcd"), np.array([1.0, 1.01, 1.03, 1.01, 9.0]), np.array([5.0, 0.5, 0.2, 0.05, 0.0])
    )
    assert [SigmaRatio(limit).eliminated(path) for limit in (1.005, 1.02, 1.03, 1.04, 10.0)] == [0, 1, 1, 3, 4]
    assert [SigmaBound(limit).eliminated(path) for limit in (9.0, 0.5, 0.3, 0.1, 0.01)] == [0, 1, 2, 3, 4]


def payload_elimination(values: Array, left: tuple[str, ...], relative: float = 0.01) -> Elimination:
    """Elimination down to some of the payload's parameters, estimated within ``relative``."""
    gone = tuple(name for name in PAYLOAD if name not in left)
    places = [PAYLOAD.index(name) for name in left]
    x = values[places]
    estimate = Estimate(left, x, np.diag((relative * x) ** 2), np.inf, NOTHING, np.ones(1))
    path = EliminationPath((*gone, *left), np.ones(11), np.zeros(11))
    return Elimination(path, SigmaRatio(), estimate)


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
