"""Friction chosen by the data: found where it is, left out where it is not, and what it does to a payload."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from dynident.apps.logs.log_check import check_log
from dynident.common.schema import convert
from dynident.estimation import (
    Settings,
    identify,
    identify_payload,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.fit.estimate import fit
from dynident.estimation.fit.own_equations import base_problem
from dynident.estimation.results.payload import PayloadResult, Quantity
from dynident.estimation.results.robot import RobotResult
from dynident.model import Drives, InertialParameters, Recording, Robot, load_robot
from dynident.model.friction import PAPER, Friction, friction_terms
from dynident.model.stand_in import with_stand_in
from dynident.tests.conftest import IN_FULL
from dynident.trajectories import Simulator, random_via_points
from msgspec import UnsetType

LOADED = {name: name for name in IN_FULL if load_robot(name).drives.friction}
PAYLOAD = InertialParameters.from_com(4.0, (0.02, -0.03, 0.1), np.diag([0.02, 0.03, 0.025]))


def rubbing(name: str, **levels: float) -> Robot:
    """A robot with load friction of joints 2 and 3, or of others."""
    robot = with_stand_in(load_robot(name))
    levels = levels or {"FL2": 0.08, "FL3": 0.06}
    terms = (*robot.drives.friction, *friction_terms(list(levels)))
    return replace(robot.with_friction(terms), parameters={**robot.parameters, **levels})


def recorded(robot: Robot, seed: int, load: InertialParameters | None = None, noise: float = 0.02) -> Recording:
    """A motion of 16 points; noise as a fraction of each joint's torque."""
    motion = random_via_points(robot, 16, seed=seed).motion(max(100.0, 20.0 * robot.processing.decimate))
    simulator = Simulator(robot)
    size = np.sqrt(np.mean(simulator.measure(motion, load).torque ** 2, axis=0))
    return simulator.record(motion, load, noise * size, [seed, load is not None], f"motion {seed}")


@pytest.mark.parametrize("name", LOADED)
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
        half = result.estimate.robust.quantile95 * result.estimate.larger_sigma[k]
        assert abs(result.estimate.values[k] - robot.parameters[parameter]) < 1.5 * half
    assert {choice.name for choice in result.choices if not choice.why_not} == found


@pytest.mark.parametrize("name", LOADED)
def test_none_is_found_where_there_is_none(name: str) -> None:
    robot = with_stand_in(load_robot(name))
    assert identify(load_robot(name), [recorded(robot, 2)]).robot.drives == load_robot(name).drives


@pytest.mark.parametrize("name", LOADED)
@pytest.mark.parametrize("known", [False, True], ids=["pair", "stored robot"])
def test_the_payload_bears_its_own_friction(name: str, known: bool) -> None:
    """By every method; with the paper's friction alone the mass is further off than its interval."""
    robot = rubbing(name, FL1=0.1, FL2=0.1, FL3=0.1)
    bare, loaded = recorded(robot, 3, noise=0.002), recorded(robot, 3, PAYLOAD, noise=0.002)
    described, settings = load_robot(name), Settings(friction_change=0.0)
    if known:
        own = identify(described, [bare], settings)
        problem = payload_problem(described, [loaded], known=own.estimate, settings=settings)
    else:
        problem = payload_problem(described, [loaded], [bare], settings=settings)
    for method in (1,) if known else (1, 2, 3, 4):
        assert payload_estimate(problem, method).mass == pytest.approx(PAYLOAD.mass, rel=0.006)


def test_the_load_settles(tmp_path: Path) -> None:
    """Equations reduced again with the load of the estimate give it again to a thousandth of its sigma."""
    robot = rubbing("rx90")
    result = identify(load_robot("rx90"), [recorded(robot, 4)], Settings(robust=False))
    again = base_problem(
        result.robot, result.base, [recorded(robot, 4)], Settings(robust=False), fitted=result.estimate.values
    )
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
    term = Friction.of("FX", "N·m", law, joints=(2,))
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
    loaded = recorded(robot, 7, PAYLOAD)
    stored = convert(own.result.to_dict(), RobotResult)
    assert stored.applied_to(described) == own.robot
    by_result, by_estimate = (
        identify_payload(described, [loaded], known=known) for known in (stored, own.estimate)
    )
    assert quantity(by_result).value == pytest.approx(quantity(by_estimate).value, rel=1e-9)


def test_a_short_recording_says_why_no_term_was_tried() -> None:
    robot = with_stand_in(load_robot("tx40"))
    short = Simulator(robot).record(random_via_points(robot, 8, seed=1).motion(200.0), None, [0.1] * 6, 1)
    result = identify(load_robot("tx40"), [short])
    assert result.robot.drives == robot.drives
    assert [choice.why_not for choice in result.choices if "record longer" not in choice.why_not] == []
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
