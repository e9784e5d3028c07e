"""Friction: chosen by the data, changed under load, and the intervals of a few seconds with payload."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
from dynident.apps.logs.log_check import check_log
from dynident.benchmarks import invented
from dynident.benchmarks.shared import lasting
from dynident.common.arrays import Array
from dynident.common.schema import convert
from dynident.estimation import (
    FRICTION_CHANGE,
    Estimate,
    LongMotion,
    Settings,
    identify,
    identify_payload,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.equations.equations import PAYLOAD
from dynident.estimation.fit.covariance import FEWEST, student95
from dynident.estimation.fit.estimate import Fit, fit
from dynident.estimation.fit.linear_problem import LinearProblem, SoftPrior, weighted
from dynident.estimation.fit.own_equations import base_problem, payload_observer
from dynident.estimation.payload.long_motion import friction_changes
from dynident.estimation.payload.methods import METHODS, from_robot, global_fit, under_load
from dynident.estimation.payload.short_motion import known_robot_weighing
from dynident.estimation.results.payload import PayloadResult, Quantity
from dynident.estimation.results.robot import RobotResult
from dynident.model import Drives, InertialParameters, Recording, Robot, load_robot
from dynident.model.friction import PAPER, Friction, friction_terms
from dynident.model.stand_in import with_stand_in
from dynident.tests.conftest import IN_FULL
from dynident.tests.selection import cases
from dynident.trajectories import Simulator, random_via_points
from msgspec import UnsetType

LOADED = [name for name in IN_FULL if load_robot(name).drives.friction]
FEW = cases(LOADED, lambda name: name != "panda")
CARRIED = InertialParameters.from_com(4.0, (0.02, -0.03, 0.1), np.diag([0.02, 0.03, 0.025]))


def rubbing(name: str, **levels: float) -> Robot:
    """A robot with load friction of joints 2 and 3, or of others."""
    robot = with_stand_in(load_robot(name))
    levels = levels or {"FL2": 0.08, "FL3": 0.06}
    terms = (*robot.drives.friction, *friction_terms(list(levels)))
    return replace(robot.with_friction(terms), parameters={**robot.parameters, **levels})


def recorded(robot: Robot, seed: int, load: InertialParameters | None = None, noise: float = 0.02) -> Recording:
    """A motion of 16 points; noise as a fraction of each joint's torque."""
    processing = robot.processing
    rate = max(100.0, 20.0 * processing.decimate, 20.0 * (processing.equation_rate or 0.0))
    motion = random_via_points(robot, 16, seed=seed).motion(rate)
    simulator = Simulator(robot)
    size = np.sqrt(np.mean(simulator.measure(motion, load).torque ** 2, axis=0))
    return simulator.record(motion, load, noise * size, [seed, load is not None], f"motion {seed}")


@pytest.mark.parametrize("name", FEW)
def test_load_friction_is_found_where_it_is(name: str) -> None:
    """With its size, at its joints and no other; Coulomb friction is then what it is without load.

    The rotor of joint 2 is grouped with its link, so that its torque counts as load there: FL2 is a tenth off.
    """
    robot = rubbing(name)
    result = identify(load_robot(name), [recorded(robot, 1)])
    found = {name for name in result.estimate.names if name.startswith(("FL", "FR"))}
    assert found == {"FL2", "FL3"}
    assert result.estimate.robust is not None
    assert result.estimate["FL2"] == pytest.approx(robot.parameters["FL2"], rel=0.12)
    for parameter in ("FL3", "FS3"):
        k = result.estimate.names.index(parameter)
        half = student95(result.estimate.robust.degrees_of_freedom) * result.estimate.larger_sigma[k]
        assert abs(result.estimate.values[k] - robot.parameters[parameter]) < 1.5 * half
    assert {choice.name for choice in result.choices if not choice.why_not} == found


@pytest.mark.parametrize("name", FEW)
def test_none_is_found_where_there_is_none(name: str) -> None:
    robot = with_stand_in(load_robot(name))
    assert identify(load_robot(name), [recorded(robot, 2)]).robot.drives == load_robot(name).drives


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("ur10e", False),
        ("rx90", True),
        *(pytest.param(name, name == "ur10e", marks=pytest.mark.long) for name in LOADED),
        pytest.param("panda", True, marks=pytest.mark.long),
    ],
)
def test_the_payload_bears_its_own_friction(name: str, known: bool) -> None:
    """By every method; with the paper's friction alone the mass is further off than its interval."""
    robot = rubbing(name, FL1=0.1, FL2=0.1, FL3=0.1)
    bare, loaded = recorded(robot, 3, noise=0.002), recorded(robot, 3, CARRIED, noise=0.002)
    described, settings = load_robot(name), Settings(friction_change=0.0)
    if known:
        own = identify(described, [bare], settings)
        problem = payload_problem(described, [loaded], known=own.estimate, settings=settings)
    else:
        problem = payload_problem(described, [loaded], [bare], settings=settings)
    for method in (1,) if known else (1, 2, 3, 4):
        assert payload_estimate(problem, method).mass == pytest.approx(CARRIED.mass, rel=0.006)


def test_the_load_settles() -> None:
    """Equations reduced again with the load of the estimate give it again to a thousandth of its sigma."""
    robot = rubbing("rx90")
    result = identify(load_robot("rx90"), [recorded(robot, 4)], Settings(robust=False))
    fitted = result.estimate.values
    again = base_problem(payload_observer(result.robot), [recorded(robot, 4)], Settings(robust=False), chi=fitted)
    moved = identify(
        result.robot, [recorded(robot, 4)], Settings(robust=False, friction=result.robot.drives.friction)
    )
    assert np.abs((moved.estimate.values - result.estimate.values) / result.estimate.sigma).max() < 1e-9
    error = fit(again, result.estimate.values).relative / result.estimate.fit.relative
    assert error == pytest.approx(1.0, abs=1e-5)


def test_a_term_of_ones_own() -> None:
    """Friction that differs over a turn is found in a recording that has it."""
    speed, position, load = (ca.SX.sym(name) for name in ("speed", "position", "load"))
    law = ca.Function("law", [speed, position, load], [ca.sin(position) * ca.sign(speed)])
    term = Friction.of("FX", "N·m", law, joint=2)
    plain = with_stand_in(load_robot("ur10e"))
    robot = replace(plain.with_friction((*PAPER, term)), parameters={**plain.parameters, "FX2": 6.0})
    result = identify(load_robot("ur10e"), [recorded(robot, 5)], Settings(friction=(*PAPER, term)))
    k = result.estimate.names.index("FX2")
    assert result.estimate.values[k] == pytest.approx(6.0, abs=4.0 * result.estimate.larger_sigma[k])
    assert result.estimate.larger_sigma[k] < 0.5


def test_a_stored_robot_carries_its_friction() -> None:
    """Its result read back gives the same robot, and a payload by it the same answer."""
    robot, described = rubbing("ur10e"), load_robot("ur10e")
    own = identify(described, [recorded(robot, 6)])
    loaded = recorded(robot, 7, CARRIED)
    stored = convert(own.result.to_dict(), RobotResult)
    assert stored.applied_to(described) == own.robot
    by_result, by_estimate = (
        identify_payload(described, [loaded], known=known) for known in (stored, own.estimate)
    )
    assert quantity(by_result).value == pytest.approx(quantity(by_estimate).value, rel=1e-9)


def test_a_short_recording_says_why_no_term_was_tried() -> None:
    robot = with_stand_in(load_robot("tx40"))
    short = Simulator(robot).record(random_via_points(robot, 8, seed=1).motion(200.0), None, [0.1] * 6, 1)
    result = identify(load_robot("tx40"), [short], Settings(replace(robot.processing, equation_rate=2.0)))
    assert result.robot.drives == robot.drives
    assert [choice.why_not for choice in result.choices if "record longer" not in f"{choice.why_not}"] == []
    assert len(result.choices) == 2


def test_link_side_sensors_see_none() -> None:
    robot = with_stand_in(load_robot("panda"))
    robot = replace(robot, drives=Drives.on_link_side())
    assert identify(robot, [recorded(robot, 8)]).choices == ()


def test_a_check_sees_the_friction_that_is_identified() -> None:
    log = recorded(rubbing("ur10e"), 1)
    own = identify(load_robot("ur10e"), [log]).estimate
    checked = check_log(load_robot("ur10e"), log)
    assert checked.relative_residual == pytest.approx(own.fit.relative, rel=1e-6)
    assert "FL2" in [row.name for row in checked.excitation]


def quantity(result: PayloadResult) -> Quantity:
    assert not isinstance(result.quantities, UnsetType)
    return result.quantities["mass"]


LOAD = InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))
NAME = "ur10e"


@cache
def recordings(seed: int, change: float) -> tuple[Recording, Recording]:
    """A motion without and with payload; each joint's friction changes by that share (1 sigma) in between."""
    robot, draw = invented.robot(NAME), np.random.default_rng([seed, 5])
    motion = random_via_points(robot, 7, seed).motion(100.0)
    moved: dict[str, float] = {
        name: value * (1.0 + change * draw.standard_normal())
        for name, value in robot.parameters.items()
        if name.startswith(("FS", "FV"))
    }
    pair = []
    for k, (arm, load) in enumerate(
        ((robot, None), (replace(robot, parameters={**robot.parameters, **moved}), LOAD))
    ):
        recording = Simulator(arm).record(motion, load, None, source=str(k))
        size = 0.02 * np.sqrt(np.mean(recording.torque**2, axis=0))
        noise = size * lasting(draw.standard_normal(recording.torque.shape), 20.0, warm=False)
        pair.append(replace(recording, torque=recording.torque + noise))
    return pair[0], pair[1]


def problem_of(seed: int, change: float, share: float) -> LongMotion:
    bare, loaded = recordings(seed, change)
    return payload_problem(invented.robot(NAME), [loaded], [bare], settings=Settings(friction_change=share))


def test_without_a_change_it_is_the_papers_method() -> None:
    problem = problem_of(0, 0.1, 0.0)
    assert not problem.friction
    estimate = METHODS[4](problem).solved()
    assert estimate["M_L"] == pytest.approx(weighted(problem.both)["M_L"])
    # As narrow as can be told, the change is none.
    tight = global_fit(problem_of(0, 0.1, FRICTION_CHANGE))
    tight = replace(tight, soft=dict.fromkeys(tight.soft, SoftPrior(1e-9)))
    assert tight.solved(estimate.weights).values == pytest.approx(estimate.values, rel=1e-5)


def test_how_far_each_friction_may_change() -> None:
    names = ("ZZ1", "FS1", "FV1", "OFF1", "FS2", "FV2", "OFF2", "FSM2")
    values = np.array([1.0, -10.0, 5.0, 0.3, 0.0, 4.0, 0.0, 2.0])
    fit = Fit(0.5 * np.ones(6), 10.0 * np.ones(6), (100,) * 6)
    robot = Estimate(names, values, np.eye(8), 100.0, fit, np.ones(6))
    changes = friction_changes(robot, (4.0, 9.0), 0.2)
    assert {name: change.sigma for name, change in changes.items()} == pytest.approx(
        {"FS1": 2.0, "FV1": 1.0, "FV2": 0.8, "FSM2": 0.4, "OFF1": 0.12, "OFF2": 0.12}
    )
    assert {change.inflation for name, change in changes.items() if name.endswith("2")} == {9.0}
    assert friction_changes(robot, (4.0, 9.0), 0.0) == {}


ROBOT = invented.robot(NAME)


def begun(seed: int, change: float = 0.0) -> tuple[Recording, Recording]:
    """The whole recording without payload, 12 s of the one with it."""
    bare, loaded = recordings(seed, change)
    inside = (loaded.t >= loaded.t[0] + 15.0) & (loaded.t <= loaded.t[0] + 27.0)
    return bare, replace(loaded, t=loaded.t[inside], q=loaded.q[inside], torque=loaded.torque[inside])


def test_a_scale_under_load_is_of_the_robot_and_of_the_true_payload() -> None:
    """Exact torques, all but friction 10 % larger: the scale's column is what they grow by, over the scale."""
    problem, scale = problem_of(0, 0.0, FRICTION_CHANGE), 0.1
    loaded, robot = problem.loaded.whole, problem.robot_known
    truth = dict(zip(robot.names, robot.values.tolist(), strict=True))
    truth |= dict(zip(PAYLOAD, LOAD.vector.tolist(), strict=True))
    values = np.array([truth[name] for name in loaded.columns])
    rigid = np.where([name.startswith(("F", "OFF")) for name in loaded.columns], 0.0, values)
    factors = [np.column_stack([own[:, :-1], own[:, :-1] @ (values + scale * rigid)]) for own in loaded.factors]
    free = replace(problem.settings, scale_sigma=1e6)
    scaled, _ = under_load(replace(problem, loaded=replace(loaded, factors=tuple(factors)), settings=free), {})
    for ours, own in zip(scaled.factors, factors, strict=True):
        growth = own[:, :-1] @ rigid
        assert ours[:, -2] == pytest.approx(growth, abs=1e-6 * np.abs(growth).max())


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
    bare, loaded = begun(0)
    short = replace(payload_problem(ROBOT, [loaded], [bare]), few=True)  # blocks are taken for too few
    for method in (1, 3, 4) if short.difference is not None else (1, 4):
        posed, estimate = METHODS[method](short), payload_estimate(short, method).estimate
        assert isinstance(posed, LinearProblem)
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


@cache
def stored(seed: int) -> Estimate:
    return identify(ROBOT, recordings(seed, 0.0)[:1]).estimate


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
