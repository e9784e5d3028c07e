"""What a researcher brings along and takes away: equations, estimates, constraints, friction, known parameters."""

import warnings
from collections.abc import Callable

import casadi as ca
import cvxpy
import dynident as di
import numpy as np
import pytest
from dynident import Estimate, InputError, Settings, estimation
from dynident.estimation.answers.gains import known_mass
from dynident.model import PAPER, Friction, robot_names
from dynident.trajectories import build_design

Logs = list[di.Recording]
ROBOT = di.load_robot("rx90")
BODY = di.InertialParameters.from_com(7.0, [0.0, 0.02, 0.14], [0.02, 0.02, 0.03])
BASE = di.base_parameters(ROBOT)


@pytest.fixture(scope="module")
def loaded() -> Logs:
    return recorded(BODY)


@pytest.fixture(scope="module")
def unloaded() -> Logs:
    return recorded(None)


def recorded(body: di.InertialParameters | None) -> Logs:
    motion = di.random_via_points(ROBOT, count=12, seed=1).motion(rate=200.0)
    return [di.Simulator(ROBOT).record(motion, body, di.RX90_NOISE, seed=3 if body else 4)]


@pytest.fixture(scope="module")
def identified(unloaded: Logs) -> estimation.Identification:
    return di.identify(ROBOT, unloaded, Settings(friction=PAPER))


@pytest.fixture(scope="module")
def mine(unloaded: Logs) -> Estimate:
    """An estimate from the di.equations as arrays."""
    W, Y, joint, t = di.equations(ROBOT, unloaded)
    assert W.shape == (len(Y), len(BASE.columns))
    assert set(joint) == set(range(1, 7))
    assert 0.0 < t.max() < unloaded[0].t[-1]
    own = estimation.weighted(di.Equations.from_arrays(W, Y, joint, BASE.columns))
    return Estimate.from_values(own.names, own.values, own.covariance)


def test_equations_as_arrays_give_the_same_estimate(mine: Estimate, identified: estimation.Identification) -> None:
    assert mine.names == identified.estimate.names
    assert mine.values == pytest.approx(identified.estimate.values, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("gains", [None, estimation.Gains(per_joint=[0.02])])
def test_an_own_estimate_weighs_a_payload(gains: estimation.Gains | None, mine: Estimate, loaded: Logs) -> None:
    settings = Settings(gains=gains)
    for result in (f(ROBOT, loaded, known=mine, settings=settings) for f in (di.identify_payload, di.weigh)):
        assert result.mass.low < BODY.mass < result.mass.high
        assert result.verdict.level != "do_not_use", result.verdict.reasons


def test_an_own_payload_is_constrained_with_intervals(loaded: Logs, unloaded: Logs) -> None:
    free = estimation.payload_estimate(
        di.payload_problem(ROBOT, loaded, unloaded, settings=Settings(methods=["global"])), 4
    ).estimate
    mine = Estimate.from_values(estimation.PAYLOAD, free.values, free.covariance, free.degrees_of_freedom)
    own, theirs = map(estimation.solve_constrained, (mine, free))
    assert own.values == pytest.approx(theirs.values)
    ends, expected = (estimation.profile_intervals(one).parameters for one in (own, theirs))
    assert ends == pytest.approx(expected)


def test_own_constraints_on_links(mine: Estimate) -> None:
    problem, parameter, inertias = estimation.build_constrained_base(ROBOT, BASE, mine)
    plain = estimation.solve_constrained_base(ROBOT, BASE, mine)
    assert problem.solve(solver=cvxpy.CLARABEL) ** 2 == pytest.approx(plain.chi2_rise, rel=1e-3)
    heavy = [parameter["M3"] == 3.0, parameter["MX2"] >= 0.5]
    bound = cvxpy.Problem(problem.objective, [*problem.constraints, *heavy])
    assert bound.solve(solver=cvxpy.CLARABEL) ** 2 >= plain.chi2_rise - 1e-6
    assert parameter["M3"].value == pytest.approx(3.0, abs=1e-5)
    assert min(np.linalg.eigvalsh(inertia.value)[0] for inertia in inertias) > -1e-6


def test_parameters_known_before(unloaded: Logs, identified: estimation.Identification) -> None:
    """A fixed one stays, a prior of the data's own accuracy halves the variance; both by either name."""
    free, value = identified["MX2"], identified["MX2R"].value + 0.1
    prior = Estimate.from_values(["FV1", "MX2R"], [25.0, value], [0.0, identified.estimate.sigma[8] ** 2])
    held = di.identify(ROBOT, unloaded, Settings(friction=PAPER, prior=prior))
    assert held["FV1"].value == pytest.approx(25.0, rel=1e-5)
    assert held["FV1"].sigma < 1e-3
    assert free.value < held["MX2"].value < value
    assert held.estimate.sigma[8] == pytest.approx(identified.estimate.sigma[8] / np.sqrt(2.0), rel=0.2)
    assert held.result["MX2R"] == held["MX2"] == held.result.parameters["MX2R"]
    with pytest.raises(InputError, match="M3 is no base parameter: give some of ZZ1"):
        di.identify(ROBOT, unloaded, Settings(prior=Estimate.from_values(["M3"], [1.0], [1.0])))


def test_names_and_sigmas_are_those_of_the_table(identified: estimation.Identification) -> None:
    result, sigma = identified.result, identified.estimate.total_sigma
    assert [row.name for row in result.base_parameters] == list(result.parameters)
    assert [parameter.sigma for parameter in result.parameters.values()] == pytest.approx(sigma)
    with pytest.raises(InputError, match="no parameter 'XX9': there are ZZ1R"):
        result["XX9"]


def test_a_friction_of_ones_own(unloaded: Logs) -> None:
    v, q, load = (ca.SX.sym(name) for name in "vql")
    own = Friction.of("FD", "N·m", ca.Function("law", [v, q, load], [v * ca.fabs(v)]))
    result = di.identify(ROBOT, unloaded, Settings(friction=(*PAPER, own), robust=False)).result
    assert {name for name in result.parameters if name.startswith("FD")} == {f"FD{j}" for j in range(1, 7)}


@pytest.mark.parametrize("name", robot_names())
def test_a_described_arm_is_simulated_and_a_motion_designed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    robot = di.load_robot(name)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert np.isfinite(di.Simulator(robot).robot.chi()).all()
        assert build_design(robot).family.size
    lines = [str(one.message) for one in told]
    assert all(line.startswith(f"robot {name!r}: assumed, as its description lacks them: ") for line in lines)
    assert len(lines) == (0 if name == "rx90" else 2)


ONE = di.Recording(np.arange(50.0), np.zeros((50, 7)), np.zeros((50, 7)), source="seven.csv")
ENTRIES: dict[str, Callable[..., object]] = {
    "identify": di.identify,
    "identify_payload": lambda robot, given: di.identify_payload(robot, given),
    "weigh": lambda robot, given: di.weigh(robot, given),
    "weigh_at_rest": lambda robot, given: di.weigh_at_rest(robot, given, given),
    "identify_gains": lambda robot, given: di.identify_gains(robot, given, given, known_mass(7.0)),
    "payload_problem": lambda robot, given: di.payload_problem(robot, given),
    "equations": di.equations,
}


@pytest.mark.parametrize("entry", ENTRIES)
def test_what_is_no_robot_or_no_list_of_recordings(entry: str) -> None:
    wrong = {
        "a robot is needed, not 'rx90': give load_robot": ("rx90", [ONE]),
        "give a list of recordings": (ROBOT, ONE),
        "give a list of them, not 'log.csv'": (ROBOT, "log.csv"),
        "'log.csv' is no recording: give read_recording": (ROBOT, ["log.csv"]),
        "seven.csv is of 7 joints, robot 'rx90' has 6": (ROBOT, [ONE]),
    }
    for message, given in wrong.items():
        with pytest.raises(InputError, match=message.replace("(", r"\(")):
            ENTRIES[entry](*given)


def test_other_wrong_values(loaded: Logs, unloaded: Logs) -> None:
    with pytest.raises(InputError, match="a robot is needed"):
        di.base_parameters("rx90")
    with pytest.raises(InputError, match="give a list of 1, 2, 3, 4, 'known-robot'"):
        Settings(methods=["globl"])
    with pytest.raises(InputError, match="do not fit"):
        di.Equations.from_arrays(np.ones((3, 2)), np.ones(3), np.ones(2), ["A", "B"])
    with pytest.raises(InputError, match="do not fit each other"):
        Estimate.from_values(["A"], [1.0, 2.0], [1.0])
    swapped = di.answer_payload(di.payload_problem(ROBOT, unloaded, loaded)).verdict
    assert any("are not swapped" in reason for reason in swapped.reasons)
