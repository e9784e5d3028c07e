"""Backward elimination against refits, its two stop rules, and what remains impossible."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.estimation import (
    PAYLOAD,
    Estimate,
    Identification,
    PayloadAnswer,
    Settings,
    SigmaBound,
    SigmaRatio,
    answer_payload,
    identify,
    payload_problem,
)
from dynident.estimation.answers.identification import impossible_payload, impossible_robot
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.essential import Elimination, EliminationPath, eliminate
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.least_squares import weighted
from dynident.model import INERTIAL, InertialParameters, Robot, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

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
    return identify(robot, records, Settings(robust=False))


@pytest.fixture(scope="module")
def tx40(recordings: Path) -> Identification:
    robot = load_robot("tx40")
    return identify(robot, [read_recording(recordings / "tx40" / "tx40.csv.gz", robot)], Settings(robust=False))


def test_the_path_is_that_of_refits(simulated_rx90: Identification) -> None:
    check_against_refits(simulated_rx90)


def test_both_rules_on_tx40(tx40: Identification) -> None:
    """The paper's ratio keeps parameters that its 5 to 10 % would not."""
    by_ratio = tx40.elimination
    assert len(by_ratio.essential) in (26, 27, 28)
    assert by_ratio.sigma_ratio < 1.02
    assert by_ratio.largest_relative_sigma == pytest.approx(0.2, abs=0.03)
    by_sigma = eliminate(tx40.problem, tx40.estimate, SigmaBound(0.1))
    assert len(by_sigma.essential) in (23, 24, 25)
    assert by_sigma.sigma_ratio > 1.02
    assert by_sigma.largest_relative_sigma <= 0.1


def test_elimination_ends_where_the_rule_says() -> None:
    path = EliminationPath(
        tuple("abcd"), np.array([1.0, 1.01, 1.03, 1.01, 9.0]), np.array([5.0, 0.5, 0.2, 0.05, 0.0])
    )
    assert [SigmaRatio(limit).eliminated(path) for limit in (1.005, 1.02, 1.03, 1.04, 10.0)] == [0, 1, 1, 3, 4]
    assert [SigmaBound(limit).eliminated(path) for limit in (9.0, 0.5, 0.3, 0.1, 0.01)] == [0, 1, 2, 3, 4]


def test_data_without_noise(rx90: Robot) -> None:
    """No division by zero, and nothing that the torques show is eliminated."""
    from dynident.estimation.equations.observer import Observer
    from dynident.estimation.equations.reduction import reduced_measurement
    from dynident.model import Processing, base_parameters

    base = base_parameters(rx90)
    data = Simulator(rx90).measure(random_via_points(rx90, 14, seed=0).motion(100.0))
    problem = reduced_measurement(Observer(rx90, base.columns), data, Processing())
    elimination = eliminate(problem, weighted(problem))
    truth = dict(zip(base.columns, base.value(rx90.parameters), strict=True))
    assert {name for name, value in truth.items() if abs(value) > 1e-6} <= set(elimination.essential)


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


def test_the_papers_robot_cannot_exist(rx90: Robot) -> None:
    """Table 2 eliminates ZZ6 while YZ6 is essential: link 6 would have no inertia about z."""
    from dynident.examples.paper.printed import paper_tables
    from dynident.model import base_parameters

    printed = paper_tables().table2_robot
    base = base_parameters(rx90)
    left = tuple(name for name in base.columns if name in printed)
    gone = tuple(name for name in base.columns if name not in printed)
    assert (len(left), "YZ6" in left, "ZZ6" in gone) == (len(printed), True, True)
    values = np.array([printed[name].value for name in left])
    sigma = np.array([printed[name].two_sigma / 2.0 for name in left])
    estimate = Estimate(left, values, np.diag(sigma**2), np.inf, NOTHING, np.ones(1))
    path = EliminationPath((*gone, *left), np.ones(55), np.zeros(55))
    spread = np.full(54, 1e-2)
    full = Estimate(base.columns, np.zeros(54), np.diag(spread**2), np.inf, NOTHING, np.ones(1))
    (line,) = impossible_robot(rx90, base, full, Elimination(path, SigmaRatio(), estimate))
    assert "no rx90 that can exist" in line
    assert "link 6 can exist" in line


@pytest.fixture(scope="module")
def both() -> PayloadAnswer:
    """Robot and the paper's payload together, as in Table 2."""
    from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD

    robot = load_robot("rx90")
    simulator, body = Simulator(robot), PAPER_PAYLOAD
    motions = [random_via_points(robot, 14, seed=k).motion(250.0) for k in range(4)]
    runs = [
        [simulator.record(m, load, RX90_NOISE, [0, k, j], f"{k}{j}") for k, m in enumerate(motions)]
        for j, load in enumerate((None, body))
    ]
    return answer_payload(
        payload_problem(robot, runs[1], runs[0], settings=Settings(robust=False, essential=SigmaBound(0.1))), (4,)
    )


@pytest.mark.long
def test_robot_and_payload_together(both: PayloadAnswer) -> None:
    """XX, YY, MZ and M of the payload are among the essential parameters, as in the paper."""
    elimination = both.elimination
    assert elimination is not None
    assert {"XX_L", "YY_L", "MZ_L", "M_L"} <= set(elimination.essential)
    assert set(elimination.path.order) == {*both.problem.base.columns, *PAYLOAD}
    assert elimination.largest_relative_sigma <= 0.1
    assert all(isinstance(line, str) for line in both.warnings)
    bare = answer_payload(both.problem, (1,))
    assert bare.elimination is None
    assert bare.warnings == ()
