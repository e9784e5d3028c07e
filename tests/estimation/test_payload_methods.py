"""The four methods: exact data give the payload back; laws that all obey, in every frame and by one call."""

from collections.abc import Callable
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from dynident import estimation, identify, identify_payload, load_robot, model, weigh
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.fit.own_equations import payload_observer
from dynident.estimation.payload.long_motion import PairedMeasurement, Source, frame_change, long_motion
from dynident.estimation.payload.methods import usable_methods
from dynident.estimation.payload.short_motion import difference_weighing
from dynident.model.motion import Measurement
from dynident.model.regressors import payload_columns
from dynident.tests.estimation.conftest import near_pose
from dynident.trajectories import RX90_NOISE, Simulator

EXACT, LENGTH = model.Processing(), 0.45
METHODS, ROBOTS = (1, 2, 3, 4), ("rx90", "tx40", "ur10e")
Body = model.InertialParameters
Simulated = Callable[[str], Simulator]
Pairs = Callable[..., tuple[Measurement, ...]]
Wander = Callable[..., model.Motion]


def scale(payload: Body) -> Array:
    """M l^2, M l and M for the ten."""
    m = payload.mass
    return np.array([m * LENGTH**2] * 6 + [m * LENGTH] * 3 + [m])


def problem_of(
    robot: model.Robot, pairs: list[tuple[Measurement, ...]], noise: float = 0.0
) -> estimation.LongMotion:
    """A payload problem without any processing; optional torque noise [N·m]."""
    draw = np.random.default_rng(1)

    def noisy(data: Measurement) -> Measurement:
        return Measurement(data.motion, data.torque + noise * draw.standard_normal(data.torque.shape))

    pairs = [(noisy(a), noisy(b)) for a, b in pairs]
    bare, loaded = zip(*pairs, strict=True)
    together = [PairedMeasurement(a, b) for a, b in pairs]
    return long_motion(payload_observer(robot), loaded, bare, together, estimation.Settings(EXACT, robust=False))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ROBOTS)
def test_exact_data_give_the_payload(
    name: str, method: int, simulated: Simulated, exact_pair: Pairs, payload: Body
) -> None:
    simulator = simulated(name)
    problem = problem_of(simulator.robot, [exact_pair(simulator)])
    answer = estimation.payload_estimate(problem, method)
    assert (np.abs(answer.estimate.values - payload.vector) < 1e-6 * scale(payload)).all()
    assert answer.frame == simulator.robot.payload_frame


@pytest.mark.parametrize("method", METHODS)
def test_exact_data_with_a_spring(method: int, simulated: Simulated, exact_pair: Pairs, payload: Body) -> None:
    robot = simulated("rx90").robot
    spring = model.Spring(joint=2, stiffness=2e4, length=0.2, arms=(0.3, 0.1), zero=0.1)
    simulator = Simulator(replace(robot, drives=replace(robot.drives, spring=spring)))
    problem = problem_of(simulator.robot, [exact_pair(simulator)])
    values = estimation.payload_estimate(problem, method).estimate.values
    assert (np.abs(values - payload.vector) < 1e-6 * scale(payload)).all()
    blind = replace(problem_of(robot, [exact_pair(simulator)]), robot=robot)
    assert weighted(blind.unloaded).fit.relative > 0.01 if blind.unloaded else False


@pytest.mark.parametrize("method", METHODS)
def test_unit_of_torque_does_not_matter(method: int, simulated: Simulated, exact_pair: Pairs) -> None:
    """Torques a thousand times larger give a payload a thousand times heavier, sigma included."""
    simulator = simulated("rx90")
    pairs = [exact_pair(simulator, seed) for seed in (0, 1)]
    big = [tuple(Measurement(data.motion, 1000.0 * data.torque) for data in pair) for pair in pairs]
    a = estimation.payload_estimate(problem_of(simulator.robot, pairs, 1.0), method).estimate
    b = estimation.payload_estimate(problem_of(simulator.robot, big, 1000.0), method).estimate
    assert np.allclose(1000.0 * a.values, b.values, rtol=1e-7, atol=1e-6)
    assert np.allclose(1000.0 * a.sigma, b.sigma, rtol=1e-7)


def test_method_2_reduces_to_the_paper_on_the_rx90(simulated: Simulated, exact_pair: Pairs) -> None:
    """(24)-(28): each base parameter's change as the paper states it."""
    simulator = simulated("rx90")
    problem = problem_of(simulator.robot, [exact_pair(simulator)])
    D3 = RL4 = 0.45
    stated = {
        "ZZ1": {"M": D3**2}, "XX2": {"M": -(D3**2)}, "ZZ2": {"M": D3**2}, "MX2": {"M": D3},
        "XX3": {"M": RL4**2}, "ZZ3": {"M": RL4**2}, "MY3": {"M": -RL4},
        "XX5": {"YY": 1.0}, "ZZ5": {"YY": 1.0}, "MY5": {"MZ": -1.0}, "XX6": {"XX": 1.0, "YY": -1.0},
        "XY6": {"XY": 1.0}, "XZ6": {"XZ": 1.0}, "YZ6": {"YZ": 1.0}, "ZZ6": {"ZZ": 1.0},
        "MX6": {"MX": 1.0}, "MY6": {"MY": 1.0},
    }  # fmt: skip
    expected = np.zeros((54, 10))
    for row, terms in stated.items():
        for kind, factor in terms.items():
            expected[problem.base.columns.index(row), estimation.PAYLOAD.index(f"{kind}_L")] = factor
    G = problem.base.effect_of(payload_columns(problem.robot))
    assert np.abs(G - expected).max() < 1e-9
    assert np.linalg.matrix_rank(G) == 10


def test_stored_robot_parameters_replace_the_unloaded_recording(simulated: Simulated, exact_pair: Pairs) -> None:
    simulator = simulated("ur10e")
    problem = problem_of(simulator.robot, [exact_pair(simulator)], noise=0.5)
    assert problem.unloaded is not None
    known = replace(problem, unloaded=None, difference=None, known=weighted(problem.unloaded))
    assert usable_methods(known) == (1,)
    a, b = (estimation.payload_estimate(p, 1).estimate for p in (problem, known))
    assert np.allclose(a.values, b.values)
    assert np.allclose(a.covariance, b.covariance)


def test_friction_under_load_can_be_freed(simulated: Simulated, wander: Wander, payload: Body) -> None:
    """Friction 30 % larger under load spoils method 1 unless it is estimated anew."""
    simulator = simulated("rx90")
    changed = {k: (1.3 * v if k[:2] in ("FS", "FV") else v) for k, v in simulator.robot.parameters.items()}
    under_load = Simulator(replace(simulator.robot, parameters=changed))
    motion = wander(6, 5)
    problem = problem_of(simulator.robot, [(simulator.measure(motion), under_load.measure(motion, payload))])
    fixed, free = (
        estimation.payload_estimate(
            replace(problem, settings=estimation.Settings(free_friction=free)), 1
        ).estimate.values
        for free in (False, True)
    )
    assert (np.abs(free - payload.vector) < 1e-6 * scale(payload)).all()
    assert np.abs(fixed - payload.vector).max() > 1e-3


def test_methods_that_lack_data_say_what_they_need(simulated: Simulated, exact_pair: Pairs) -> None:
    simulator = simulated("rx90")
    problem = replace(
        problem_of(simulator.robot, [exact_pair(simulator)]), unloaded=None, difference=None,
        source=Source((), (), EXACT, why_no_pair="only one recording"),
    )  # fmt: skip
    assert usable_methods(problem) == ()
    needed = ((1, "robot's parameters"), (2, "without payload"), (3, "only one"), (4, "without payload"))
    for method, words in needed:
        with pytest.raises(InputError, match=words):
            estimation.payload_estimate(problem, method)


def test_an_arm_that_cannot_show_a_payload_says_so(wander: Wander) -> None:
    """A planar arm never turns the payload about x or y."""
    planar = model.Robot("planar", (model.Joint(), model.Joint(d=0.4), model.Joint(d=0.3)))
    motion = wander(3, 0)
    recording = model.Recording(motion.t, motion.q, np.array(motion.q))
    with pytest.raises(InputError, match=r"no motion of planar shows \d of a payload's ten directions \(.*MZ"):
        estimation.payload_problem(planar, [recording], [recording], settings=estimation.Settings(robust=False))


NOISE = 0.3 * np.array(RX90_NOISE)
TOOL = model.Pose.from_rpy((0.03, -0.01, 0.12), (radians(180), 0.4, -0.2))


def simulator_of(robot: model.Robot) -> Simulator:
    known = {name: robot.parameters.get(name, 0.5) for name in model.standard_columns(robot)}
    return Simulator(replace(robot, parameters=known))


@pytest.mark.parametrize("method", [1, 2, 3, 4])
def test_moving_the_flange_moves_the_answer(method: int, rx90: model.Robot, payload: Body, wander: Wander) -> None:
    """Values, both covariances, and the torques that are drawn from them."""
    simulator = simulator_of(rx90)
    motion = wander(6, 4)
    bare, loaded = simulator.record(motion, None, [0.1] * 6, 1), simulator.record(motion, payload, [0.1] * 6, 2)
    robots = simulator.robot, model.with_tool(simulator.robot, TOOL, "tool 1")
    settings = estimation.Settings(methods=(method,))
    problems = [estimation.payload_problem(robot, [loaded], [bare], settings=settings) for robot in robots]
    same_but_for_the_frame(*map(estimation.answer_payload, problems))


@pytest.mark.long
@pytest.mark.parametrize("joints", [(2, 3, 5, 6), (4, 5, 6), (6,)])
def test_moving_the_flange_moves_a_weighing(rx90: model.Robot, payload: Body, joints: tuple[int, ...]) -> None:
    """Also where a scale gives the mass, and where one joint shows four of the ten."""
    simulator = simulator_of(rx90)
    motion = near_pose(joints).motion(250.0)
    bare, loaded = simulator.record(motion, None, NOISE, 1), simulator.record(motion, payload, NOISE, 2)
    tool = TOOL if len(joints) > 1 else model.Pose.from_rpy((0.0, 0.0, 0.12), (0.0, 0.0, 0.7))
    scale = (estimation.KnownMass(7.025, 0.02),) if 2 not in joints else ()
    plain, moved = (
        estimation.answer_payload(
            difference_weighing(robot, [loaded], [bare]), constraints=(estimation.PossibleBody(), *scale)
        )
        for robot in (simulator.robot, model.with_tool(simulator.robot, tool, "tool 1"))
    )
    assert moved.free.frame == "tool 1"
    assert moved.mass == pytest.approx(plain.mass, abs=0.01 * plain.spread.mass)
    if len(joints) > 1:
        same_but_for_the_frame(plain, moved)
        return
    columns = [6, 7]  # MX and MY turn into each other
    turn = frame_change(tool.inverse())[np.ix_(columns, columns)]
    np.testing.assert_allclose(moved.ten[columns], turn @ plain.ten[columns], atol=1e-9)
    assert np.isfinite(moved.ten).tolist() == np.isfinite(plain.ten).tolist()


def same_but_for_the_frame(plain: estimation.PayloadAnswer, moved: estimation.PayloadAnswer) -> None:
    T = frame_change(TOOL.inverse())
    plain_estimate, moved_estimate = plain.free.estimate, moved.free.estimate
    for a, b in ((plain_estimate, moved_estimate), (plain_estimate.robust, moved_estimate.robust)):
        assert a is not None
        assert b is not None
        C = T @ a.covariance @ T.T
        np.testing.assert_allclose(b.covariance, C, atol=1e-8 * np.abs(C).max())
    np.testing.assert_allclose(
        moved_estimate.values, T @ plain_estimate.values, atol=1e-6 * moved_estimate.sigma.min()
    )
    # The possible payload goes by the formula's correlations and the jackknife's deviations of each axis' own.
    assert moved.mass == pytest.approx(plain.mass, abs=0.01 * plain.spread.mass)
    for drawn, again in zip(plain.predictions, moved.predictions, strict=True):
        for before, after in zip(*(next(iter(each.curves.values())) for each in (drawn, again)), strict=True):
            np.testing.assert_allclose(after, before, atol=1e-3 * np.abs(before).max())


SETTINGS = estimation.Settings(model.Processing(cutoff=10.0, rate=100.0, decimate=2))
Pair = tuple[list[model.Recording], list[model.Recording]]


@pytest.fixture(scope="module")
def pair(simulated: Simulated, wander: Wander, payload: Body) -> Callable[[str], Pair]:
    """Recordings of an arm with a payload, and without."""

    def recordings(name: str) -> Pair:
        simulator = simulated(name)
        n = simulator.robot.n
        motion = wander(n, 4, points=20)
        return [simulator.record(motion, payload, [0.3] * n, 2)], [simulator.record(motion, None, [0.3] * n, 1)]

    return recordings


@pytest.mark.parametrize("name", ["rx90", "ur10e", "irb120"])
def test_a_payload_is_that_of_the_steps(name: str, pair: Callable[[str], Pair]) -> None:
    robot, (loaded, unloaded) = load_robot(name), pair(name)
    known, gains = [estimation.InEllipsoid((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))], estimation.Gains((0.01,))
    settings = estimation.Settings(SETTINGS.processing, methods=(3, 4), gains=gains)
    result = identify_payload(robot, loaded, unloaded, constraints=known, settings=settings)
    steps = estimation.answer_payload(
        estimation.payload_problem(robot, loaded, unloaded, settings=settings), constraints=known
    )
    assert result.to_dict() == steps.result.to_dict()
    assert {estimate.method for estimate in result.estimates} == {3, 4}
    assert result.working.problem.robot == robot


def test_a_prediction_goes_by_the_motion_alone(simulated: Simulated, wander: Wander) -> None:
    simulator, motion = simulated("rx90"), wander(6, 4)
    recordings = [simulator.record(motion, None, [3.0] * 6, seed) for seed in (1, 2)]
    first, second = identify(simulator.robot, recordings, SETTINGS).predictions
    for before, after in zip(first.curves["predicted"], second.curves["predicted"], strict=True):
        np.testing.assert_allclose(after, before, atol=1e-9 * np.abs(before).max())


def test_a_payload_needs_no_recording_beside_a_robot_that_is_known(pair: Callable[[str], Pair]) -> None:
    robot, (loaded, unloaded) = load_robot("rx90"), pair("rx90")
    stored = identify(robot, unloaded, SETTINGS)
    asks: tuple[Callable[..., estimation.PayloadResult], ...] = (identify_payload, weigh)
    for ask in asks:
        plain, whole = (
            ask(robot, loaded, known=known, settings=SETTINGS) for known in (stored.estimate, stored.result)
        )
        assert plain.mass.low > 0.0
        assert plain.to_dict() == whole.to_dict()
        with pytest.raises(InputError, match="of robot 'rx90', not 'ur10e'"):
            ask(load_robot("ur10e"), loaded, known=stored.result, settings=SETTINGS)
        with pytest.raises(InputError, match="not Identification"):
            ask(robot, loaded, known=stored)
        with pytest.raises(InputError, match="list of recordings"):
            ask(robot, loaded[0], unloaded)
