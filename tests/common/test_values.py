"""Public values: pickled, copied, compared and shown; the examples of the public names; and what is no input."""

import copy
import dataclasses
import doctest
import pickle
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import dynident
import numpy as np
import pytest
from dynident import (
    RX90_NOISE,
    InertialParameters,
    InputError,
    Robot,
    Simulator,
    answer_payload,
    estimation,
    identify,
    load_robot,
    model,
    payload_problem,
    random_via_points,
    trajectories,
)
from dynident.apps.recordings import write_recording
from dynident.benchmarks import static
from dynident.common.schema import convert
from dynident.estimation.answers.gains import known_mass
from dynident.model import Recording
from dynident.tests.common.test_wrong_files import filled
from dynident.tests.selection import cases
from dynident.trajectories.design.scene import Capsule, HalfSpace
from msgspec import inspect

PUBLIC = {
    getattr(room, name): name for room in (dynident, model, estimation, trajectories) for name in room.__all__
    if isinstance(getattr(room, name), type)
}  # fmt: skip
"""Public types and their names."""
NAMES = [name for name in dir(dynident) if not name.startswith("__") and callable(getattr(dynident, name))]
"""Top-level names that can have an example."""
BODY = InertialParameters.from_com(7.0, [0.0, 0.02, 0.14], [0.02, 0.02, 0.03])
ONE, ONES, ZERO = np.ones(6), np.ones((6, 2)), (0.0,) * 6
FLOOR = (HalfSpace("floor"),)


@cache
def recorded() -> tuple[Robot, list[Recording], list[Recording]]:
    """A short pair of recordings of the RX90, loaded and unloaded."""
    robot = load_robot("rx90")
    arm, motion = Simulator(robot), random_via_points(robot, count=10, seed=0).motion(rate=200.0)
    loaded, unloaded = (arm.record(motion, load, RX90_NOISE, seed=k) for k, load in enumerate((BODY, None)))
    return robot, [loaded], [unloaded]


def roots() -> Iterator[Any]:
    """Values that hold most of the others, then what they do not hold."""
    robot, loaded, unloaded = recorded()
    known = [estimation.CentreOfMassInBox([-1, -1, -1], [1, 1, 1]), estimation.MassBounds(1, 20)]
    known += [estimation.KnownMass(7.0, 0.1), estimation.InEllipsoid([0, 0, 0], [1, 1, 1])]
    answer = answer_payload(payload_problem(robot, loaded, unloaded), constraints=known)
    identified = identify(robot, unloaded)
    yield from (robot, Simulator(robot), answer, answer.result, identified, identified.result, identified.possible)
    yield estimation.difference_weighing(robot, loaded, unloaded)
    yield from (
        convert(filled(inspect.type_info(estimation.GainsResult)), estimation.GainsResult),
        estimation.SigmaBound(),
        estimation.SolverError("no body", []),
        InputError("no"),
    )
    yield identified["MX2"]
    shape = trajectories.ViaPointShape(6, segment=trajectories.Trapezoid(), passing=False)
    loads = trajectories.Loads(robot.parameters, trajectories.PayloadSet.within(1.0, 0.1))
    bounds = trajectories.JointBounds.of(robot, torque=[1e5] * 6)
    scene = trajectories.Scene((Capsule("arm", 3, 0.1),), FLOOR)
    problem = trajectories.build_design(robot, shape, bounds=bounds, loads=loads, scene=scene).with_slow_torques(
        0.5
    )
    plan = problem.family.plan(problem.family.random(np.random.default_rng(0)))
    yield trajectories.Design(problem, plan, trajectories.score_motion(problem, plan.motion(50.0)), 0, 1, 1, 0.0)
    yield from (loads, plan.motion(20.0), model.Coupling((5, 6)), model.Spring(2, 1.0, 1.0, (1.0, 1.0)))
    yield from (trajectories.FourierShape(duration=10.0), trajectories.NearShape(ONE[None], (2,), ONE[:1], 9.0))
    yield trajectories.StaticShape(ONE, (2,), -ONE[:1], ONE[:1], ONE[:1])
    yield trajectories.Fourier(ONE[None], ONES[None], ONES[None], 10.0)
    yield trajectories.PointToPoint(np.array([ONE, 2.0 * ONE]), ONE[:1], ONE[None, :2] / 4.0)
    yield trajectories.NearGoal(ONE, 10.0, InertialParameters(np.ones(10)))
    yield from (trajectories.Earlier(("FS1",), np.ones((1, 1))), model.JointAxis("revolute", (0, 0, 1), (0, 0, 0)))
    still = trajectories.SampledTrajectory(np.arange(6.0) / 10.0, np.zeros((6, 6)))
    disturbances = trajectories.Disturbances(ZERO, ZERO, ZERO)
    yield trajectories.run_experiment(robot, [trajectories.Task("a", still)], disturbances)
    yield from (disturbances, trajectories.Controller(), still, shape, estimation.Gains(per_joint=[0.02]))


def within(value: Any, found: dict[type, Any]) -> None:
    """Collect one value of each public type."""
    names = getattr(value, "__struct_fields__", ()) or getattr(value, "_fields", ())
    names = [field.name for field in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else names
    if type(value) in PUBLIC:
        found.setdefault(type(value), value)
    if not isinstance(value, type):
        for part in [getattr(value, name) for name in names] or (
            value.values() if isinstance(value, Mapping) else value if isinstance(value, tuple | list) else ()
        ):
            within(part, found)


@cache
def values() -> dict[type, Any]:
    found: dict[type, Any] = {}
    for root in roots():
        within(root, found)
    return found


@pytest.fixture(autouse=True)
def _uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")


@pytest.mark.parametrize("kind", PUBLIC, ids=PUBLIC.values())
def test_a_public_value_is_pickled_copied_compared_and_shown(kind: type) -> None:
    value = values()[kind]
    for other in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
        assert type(other) is kind
        assert other == value or isinstance(value, Exception)
        assert str(other)[:200] == str(value)[:200]
    assert value != object()
    assert len(repr(value)) <= 800
    assert "\n" not in repr(value)
    if dataclasses.is_dataclass(value):
        assert hash(value) == hash(copy.deepcopy(value))


@cache
def typed() -> dict[str, Any]:
    """Names that the examples may use: everything public, a body and recordings of an RX90 with it and without."""
    names = {name: getattr(room, name) for room in (estimation, model, dynident) for name in room.__all__}
    robot, loaded, unloaded = recorded()
    at_rest = static.arm("rx90", 1).recordings("AB", 0)
    currents = (replace(one, torque=one.torque / 10.0) for one in (*loaded, *unloaded))
    names |= {
        "robot": robot,
        "body": BODY,
        "np": np,
        "known_mass": known_mass,
        "loaded": loaded,
        "unloaded": unloaded,
    }
    names |= dict(zip(("loaded_at_rest", "unloaded_at_rest"), at_rest, strict=True))
    return names | {name: [one] for name, one in zip(("currents_loaded", "currents"), currents, strict=True)}


@pytest.mark.parametrize("name", cases(NAMES, lambda name: name != "identify_gains"))
def test_the_example_of_a_public_name(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    if name == "read_recording":
        write_recording(tmp_path / "log.csv", recorded()[1][0])
    test = doctest.DocTestParser().get_doctest(getattr(dynident, name).__doc__, dict(typed()), name, None, None)
    assert test.examples
    told: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=told.append)
    assert not told, "".join(told)
