"""Criteria and designs: exact values and gradients, limits kept between samples, honest answers."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from dynident.benchmarks.promised import Ratios, promised_and_shown
from dynident.common.arrays import Array
from dynident.common.linear import condition_numbers
from dynident.model import (
    INERTIAL,
    InertialParameters,
    Motion,
    Robot,
    base_parameters,
    inverse_dynamics,
    load_robot,
    regressor,
    robot_names,
)
from dynident.model.base import random_states
from dynident.model.drives import SPRING, Drives
from dynident.model.kernel.kernel import Kernel
from dynident.tests.conftest import CROOKED, SCARA
from dynident.tests.selection import every
from dynident.trajectories import (
    Design,
    DesignProblem,
    Earlier,
    FourierShape,
    Goal,
    JointBounds,
    Loads,
    Scene,
    Trapezoid,
    ViaPoints,
    ViaPointShape,
    build_design,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.descent import Lagrangian
from dynident.trajectories.design.goal import CRITERIA, Kind, RegressorKernel, Shape, regressor_kernel
from dynident.trajectories.design.scene import Capsule, HalfSpace
from dynident.trajectories.design.score import over_time, score_of
from dynident.trajectories.design.search import floor_under
from dynident.trajectories.motions.family import Samples

ROBOT = load_robot("rx90")
TORQUE = (300.0, 300.0, 120.0, 50.0, 40.0, 20.0)
STRONG = [3.0 * joint.limits.speed for joint in ROBOT.joints]
BOUNDS = JointBounds.of(ROBOT, acceleration=STRONG, torque=TORQUE)
NOISE = tuple(0.1 * torque for torque in TORQUE)
PAYLOAD = InertialParameters.from_com(4.0, [0.0, 0.02, 0.1], 0.02 * np.eye(3))
SCENE = Scene(
    (
        Capsule("column", 0, 0.2, (0.0, 0.0, -0.42), (0.0, 0.0, 0.1)),
        Capsule("elbow", 3, 0.15),
        Capsule("wrist", 4, 0.1),
        Capsule("tool", 6, 0.12, (0.0, 0.0, 0.2)),
    ),
    (HalfSpace("floor", offset=-0.42),),
    (("tool", "column"), ("wrist", "column"), ("elbow", "column")),
)
FEW = ("ZZ1", "FV1", "FS1", "XX2", "ZZ2", "MX2", "FV2", "FS2", "IA3", "IA4", "FS5", "FSM6")
GOALS = {
    "d": Goal("d", noise=NOISE),
    "d of some": Goal("d", noise=NOISE, interest=("ZZ1", "IA5")),
    "a": Goal("a", columns=FEW, reference=dict.fromkeys(FEW, 2.0), noise=NOISE),
    "cond": Goal("cond"),
    "cond-scaled": Goal("cond-scaled"),
    "payload": Goal("cond-scaled", payload_only=True),
}
SHAPES: dict[str, Shape] = {
    "via": ViaPointShape(14),
    "rest": ViaPointShape(14, passing=False),
    "trapezoid": ViaPointShape(14, passing=False, segment=Trapezoid()),
    "fixed": ViaPointShape(14, fixed=1.5),
    "fourier": FourierShape(5, 10.0),
}


def problem(goal: str, shape: str, *, bounds: JointBounds = BOUNDS, **of_shape: Any) -> DesignProblem:
    """With torque limits for two loads, and obstacles."""
    loads = Loads(ROBOT.parameters, PAYLOAD)
    own = replace(SHAPES[shape], **of_shape)
    return build_design(ROBOT, own, GOALS[goal], bounds=bounds, loads=loads, scene=SCENE)


def derivative(function: object, x: Array, direction: Array, step: float = 2e-4) -> float:
    """Central differences of two steps, extrapolated (Richardson)."""
    assert callable(function)
    coarse, two = (
        (function(x + h * direction) - function(x - h * direction)) / (2.0 * h) for h in (step, 0.5 * step)
    )
    return float((4.0 * two - coarse) / 3.0)


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("shape", SHAPES)
def test_gradient_is_the_derivative(goal: str, shape: str) -> None:
    """With the terms of every limit that bites: joints, torques of two loads, duration and obstacles."""
    bounds = JointBounds.of(ROBOT) if goal == "payload" else BOUNDS
    task = problem(goal, shape, bounds=bounds, **({} if shape in ("fixed", "fourier") else {"longest": 12.0}))
    draw = np.random.default_rng(0)
    x = task.family.random(draw) + 0.02 * draw.standard_normal(task.family.size)
    limits = Lagrangian(task, x, 3.0, 0.4)
    assert limits.violation(task.state(x, 0.5)) > 0.0
    terms = partial(task.criterion_term, order=8.0), limits
    value, slope = task.evaluate(x, 0.5, terms)
    assert np.isfinite(value)
    direction = draw.standard_normal(len(x)) / np.sqrt(len(x))
    expected = derivative(lambda y: task.evaluate(y, 0.5, terms)[0], x, direction)
    assert slope @ direction == pytest.approx(expected, rel=1e-6, abs=1e-6 * float(np.linalg.norm(slope)) / len(x))


@pytest.mark.parametrize("goal", GOALS)
def test_rows_of_a_motion_hold_its_information(goal: str) -> None:
    task, draw = problem(goal, "fourier"), np.random.default_rng(0)
    state = task.state(task.family.random(draw), 0.0)
    weights = task.row_weights(state, True) * draw.uniform(0.5, 2.0, (task.robot.n, len(state.q)))
    rows, information = task.rows(state, weights), task.information(state.entries, weights)
    np.testing.assert_allclose(rows.T @ rows, information, atol=1e-9 * np.abs(information).max())


def test_what_was_recorded_counts_as_what_will_be() -> None:
    """A motion after a recording of itself teaches what it teaches when recorded twice as long."""
    task = problem("a", "fourier")
    x = task.family.random(np.random.default_rng(0))

    def of(seconds: float, earlier: Earlier | None = None) -> DesignProblem:
        return replace(task, goal=replace(task.goal, data_length=seconds, earlier=earlier))

    state = task.state(x, 0.5)
    once = of(10.0).information(state.entries, of(10.0).row_weights(state, True))
    again = of(10.0, Earlier(task.names, np.asarray(np.linalg.cholesky(once).T)))
    values = [each.evaluate(x, 0.5, [partial(each.criterion_term, order=8.0)])[0] for each in (again, of(20.0))]
    assert values[0] == pytest.approx(values[1])


def test_a_spring_is_part_of_the_torque() -> None:
    """Torques in the limits are those of inverse dynamics, the known spring taken off."""
    draw = np.random.default_rng(0)
    names = [*(f"{kind}{j}" for j in range(1, 6) for kind in (*INERTIAL, "IA", "FS", "FV", "OFF")), "FVM5", "FSM5"]
    joints = tuple(
        replace(joint, limits=replace(joint.limits, position=(-1.0, 1.0), speed=2.0, acceleration=9.0, torque=50.0))
        for joint in CROOKED.joints
    )
    robot = replace(CROOKED, joints=joints, parameters={name: draw.uniform(0.1, 1.0) for name in names})
    task = build_design(robot, FourierShape(4, 6.0), Goal("d"))
    x = task.family.random(draw)
    samples = task.family.sample(x)
    state = task.state(x, 0.0)
    limit = next(limit for limit in task.limits if limit.name == "torque")
    kernel = Kernel(inverse_dynamics(robot))
    expected = kernel(samples.q, samples.qd, samples.qdd, robot.chi()).T
    assert np.allclose(limit.values(state) * 50.0, expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("fixed", [pytest.param(None, marks=pytest.mark.long), 1.25])
def test_trapezoids_within_every_limit(fixed: float | None) -> None:
    """Peaks of speed and acceleration as the trapezoid's law has them, not as samples show them."""
    shape = ViaPointShape(8, passing=False, fixed=fixed, segment=Trapezoid(0.2))
    design = solve_design(build_design(ROBOT, shape, Goal("d", noise=NOISE), bounds=BOUNDS, scene=SCENE), starts=1)
    plan = design.plan
    assert isinstance(plan, ViaPoints)
    assert design.feasible
    assert score_motion(design.problem, design.motion(997.0)).feasible
    speed = np.abs(np.diff(plan.points, axis=0)) / plan.durations[:, None] / 0.8
    acceleration = speed / (0.2 * plan.durations[:, None])
    assert (speed <= BOUNDS.speed * (1.0 + 1e-9)).all()
    assert (acceleration <= BOUNDS.acceleration * (1.0 + 1e-9)).all()
    assert max((speed / BOUNDS.speed).max(), (acceleration / BOUNDS.acceleration).max()) > 0.9
    if fixed is not None:
        assert np.array_equal(plan.durations, np.full(7, fixed))


def torques(robot: Robot, design: Design, payload: InertialParameters | None) -> Array:
    """By the recursive Newton-Euler algorithm, not by the regressor."""
    motion = design.motion(1000.0)
    kernel = Kernel(inverse_dynamics(robot))
    return kernel(motion.q, motion.qd, motion.qdd, robot.chi(payload=payload)).T


@pytest.fixture(scope="module")
def guarded() -> Design:
    """A motion with every kind of limit."""
    start = (0.2, -1.2, 0.8, 0.3, 0.5, -0.4)
    return solve_design(problem("d", "via", longest=15.0, start=start), seed=1, starts=1)


@pytest.mark.long
def test_every_limit_is_kept_at_a_millisecond(guarded: Design) -> None:
    """On another grid than the solver's, with torques and heights found in other ways."""
    motion = guarded.motion(1000.0)
    assert guarded.feasible
    assert guarded.score.max_violation <= 1e-9
    assert motion.t[-1] <= 15.0
    assert np.allclose(motion.q[0], [0.2, -1.2, 0.8, 0.3, 0.5, -0.4])
    for j, joint in enumerate(ROBOT.joints):
        assert joint.limits.position[0] <= motion.q[:, j].min()
        assert motion.q[:, j].max() <= joint.limits.position[1]
        assert np.abs(motion.qd[:, j]).max() <= joint.limits.speed
        assert np.abs(motion.qdd[:, j]).max() <= STRONG[j]
    for payload in (None, PAYLOAD):
        assert (np.abs(torques(ROBOT, guarded, payload)).max(axis=0) <= TORQUE).all()
    again = score_motion(guarded.problem, motion)
    assert again.feasible
    assert again.learnt.condition_number == pytest.approx(guarded.learnt.condition_number, rel=0.01)
    assert again.value == pytest.approx(guarded.score.value, abs=0.01)


@pytest.mark.long
def test_condition_number_of_a_design_and_its_floor() -> None:
    design = solve_design(build_design(ROBOT, ViaPointShape(14), Goal("cond")), seed=0, starts=1)
    assert design.feasible
    assert design.learnt.condition_number < 18.0
    assert design.score.value == pytest.approx(np.log(design.learnt.condition_number), abs=1e-6)
    floor = floor_under(design.problem, design.score.value, states=60, effort=1)
    assert 8.0 < np.exp(floor.value) < 11.0
    assert floor.gap == pytest.approx(design.score.value - floor.value)


def test_a_pose_shows_its_room_and_teaches_nothing() -> None:
    room, taught = over_time(problem("d", "fourier"), Motion(np.zeros(1), *np.zeros((3, 1, 6))))
    assert (room.shape, taught.tolist()) == ((1, 6), [0.0])


@pytest.mark.parametrize("kind", ["d", "a"])
def test_no_motion_and_no_floor_is_below_the_dual(kind: Kind) -> None:
    goal = Goal(kind, payload_only=True, reference=dict.fromkeys((f"{name}6" for name in INERTIAL), 1.0))
    problem = build_design(ROBOT, ViaPointShape(4), goal)
    draw = np.random.default_rng(0)
    values = [score_of(problem, problem.family.random(draw)).value for _ in range(20)]
    floor = floor_under(problem, min(values), states=20, effort=1)
    assert floor.dual is not None
    assert floor.dual <= floor.value < min(values)
    assert floor.gap == pytest.approx(min(values) - floor.dual)
    assert floor.value - floor.dual < 0.8


@pytest.mark.filterwarnings("ignore:.*stand-in:UserWarning")
@pytest.mark.parametrize("name", every(6, robot_names()))
def test_the_gap_where_the_best_value_is_known(name: str) -> None:
    """Any motion shows a constant torque alike; a viscous friction is seen best at the limit of speed, always."""
    robot = replace(load_robot(name), drives=Drives(offsets=True))
    for column, speed in (("OFF2", 1.0), ("FV2", robot.joints[1].limits.speed)):
        goal = Goal("d", columns=(column,), noise=(2.0,) * robot.n)
        design = solve_design(build_design(robot, ViaPointShape(4), goal), starts=1)
        best = -np.log(goal.single_rate * (speed / 2.0) ** 2)
        assert design.gap == pytest.approx(design.score.value - best, abs=1e-9)
        assert design.gap == pytest.approx(0.0, abs=1e-9) if column == "OFF2" else 0.0 < design.gap < 1.5


def test_interrupted_it_keeps_the_best_so_far() -> None:
    task = build_design(ROBOT, ViaPointShape(14), Goal("cond"))
    steps: list[float | None] = []

    def stop(text: str, best: float | None, evaluations: int) -> None:
        steps.append(best)
        if len(steps) == 3:
            raise KeyboardInterrupt

    design = solve_design(task, progress=stop)
    assert design.interrupted
    assert design.feasible
    assert steps[-1] == pytest.approx(design.score.value)
    assert isinstance(design.plan, ViaPoints)


DRAW = np.random.default_rng(0)
W = DRAW.standard_normal((60, 6)) * np.array([1.0, 3.0, 0.2, 5.0, 0.7, 1.5])
REFERENCE = np.array([1.0, -2.0, 3.0, 0.5, 1.0, 4.0])
A = CRITERIA["a"]._replace(reference=REFERENCE)


def scaled(W: Array) -> Array:
    return np.asarray(W / np.linalg.norm(W, axis=0))


@pytest.mark.parametrize(("kind", "matrix"), [("cond", W), ("cond-scaled", scaled(W))])
def test_the_surrogate_is_an_upper_bound_that_closes(kind: Kind, matrix: Array) -> None:
    exact = np.log(np.linalg.cond(matrix))
    values = [CRITERIA[kind](W.T @ W, p)[0] for p in (1.0, 8.0, 24.0, 400.0)]
    assert all(np.diff(values) <= 0.0)
    assert values[-1] == pytest.approx(exact, abs=0.01)
    assert min(values) >= exact - 1e-12


def test_d_and_a_are_what_they_say() -> None:
    G = W.T @ W
    covariance = np.linalg.inv(G)
    assert CRITERIA["d"](G)[0] == pytest.approx(-np.linalg.slogdet(G)[1] / 6)
    own = covariance[np.ix_([1, 4], [1, 4])]
    assert CRITERIA["d"]._replace(interest=[1, 4])(G)[0] == pytest.approx(np.linalg.slogdet(own)[1] / 2)
    relative = np.sqrt(np.diag(covariance)) / REFERENCE
    assert A(G)[0] == pytest.approx(0.5 * np.log((relative**2).mean()))
    assert A._replace(interest=[2, 3])(G)[0] == pytest.approx(0.5 * np.log((relative[2:4] ** 2).mean()))


EVERY = {
    **CRITERIA,
    "a": A,
    "d of two": CRITERIA["d"]._replace(interest=[0, 3]),
    "a of three": A._replace(interest=[1, 2, 5]),
}


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("order", [1.0, 8.0, 24.0])
def test_slopes_are_derivatives(name: str, order: float) -> None:
    G, step = W.T @ W, 1e-5
    direction = DRAW.standard_normal((6, 6))
    direction = direction + direction.T
    M = EVERY[name](G, order)[1]
    ahead, behind = (EVERY[name](G + s * direction, order)[0] for s in (step, -step))
    assert np.allclose(M, M.T, atol=1e-12 * np.abs(M).max())
    assert np.sum(M * direction) == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def test_a_singular_matrix_has_no_condition_number() -> None:
    twice = np.column_stack([W, W[:, 0] + W[:, 1]])
    assert condition_numbers(twice) == (np.inf, np.inf)
    assert condition_numbers(np.column_stack([W, np.zeros(60)])) == (np.inf, np.inf)
    assert condition_numbers(W[:4]) == (np.inf, np.inf)
    G = np.column_stack([W, np.zeros(60)])
    assert CRITERIA["d"](G.T @ G)[0] == np.inf
    assert CRITERIA["cond-scaled"](G.T @ G)[0] == np.inf


ROBOTS = {robot.name: robot for robot in (load_robot("rx90"), CROOKED, SCARA)}


def columns(robot: Robot) -> tuple[str, ...]:
    own = base_parameters(robot).columns
    return (*own, SPRING) if robot.spring else own


@pytest.fixture(scope="module", params=ROBOTS)
def kernel(request: pytest.FixtureRequest) -> tuple[Robot, RegressorKernel]:
    robot = ROBOTS[request.param]
    return robot, regressor_kernel(robot, columns(robot))


def samples(robot: Robot, count: int = 11) -> Samples:
    return Samples(np.linspace(0.5, 1.5, count), *random_states(robot, count, 0))


def test_the_matrix_is_the_regressor(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data = samples(robot)
    names = [name for name in own.columns if name != SPRING]
    phi = regressor(robot, names)
    W = own.matrix(own.state(data))
    for k in range(len(data.q)):
        expected = np.asarray(phi(data.q[k], data.qd[k], data.qdd[k]))
        assert np.allclose(W[:, k, [own.columns.index(name) for name in names]], expected, atol=1e-12)
        if robot.spring:
            j = robot.spring.joint - 1
            assert W[j, k, -1] == pytest.approx(robot.spring.torque(data.q[k, j : j + 1])[0])


def test_gram_and_torque_are_products_of_the_matrix(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data, draw = samples(robot), np.random.default_rng(1)
    state = own.state(data)
    entries, W = state.entries, own.matrix(state).reshape(-1, len(own.columns))
    weights = draw.uniform(0.5, 2.0, (robot.n, len(data.q)))
    assert np.allclose(own.gram(entries, weights), (W * weights.reshape(-1, 1)).T @ W, rtol=1e-10)
    chi = draw.standard_normal(len(own.columns))
    assert np.allclose(own.torque(entries, chi), (W @ chi).reshape(robot.n, -1).T)


def test_the_adjoint_is_the_derivative(kernel: tuple[Robot, RegressorKernel]) -> None:
    robot, own = kernel
    data, draw, step = samples(robot), np.random.default_rng(2), 1e-6
    seed = draw.standard_normal(own.state(data, 0.3).entries.shape)
    slopes = own.state_slope(data._replace(width=np.array([0.3])), seed)
    for k, slope in enumerate(slopes, start=1):
        direction = draw.standard_normal(data.q.shape)
        ahead, behind = (
            own.state(data._replace(**{data._fields[k]: data[k] + s * direction}), 0.3).entries
            for s in (step, -step)
        )
        expected = np.sum(seed * (ahead - behind)) / (2 * step)
        assert np.sum(slope * direction) == pytest.approx(expected, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(
    "name", ["kr6_r900", *(pytest.param(arm, marks=pytest.mark.long) for arm in ("iiwa14", "rx90", "ur10e"))]
)
def test_what_a_motion_promises_its_simulated_recordings_show(name: str) -> None:
    """Within a factor of 1.5 for robot and payload, by the same noise; so does ``--like`` find that noise again.

    On the mean of three motions: a jackknife over a dozen blocks scatters by a quarter of itself.
    """
    found = np.array([promised_and_shown(name, seed) for seed in range(3)])
    shown = Ratios(*np.exp(np.log(found).mean(axis=0)))
    assert shown.condition == pytest.approx(1.0, rel=3e-4)  # positions are recorded to 1e-5 rad
    assert np.all(np.abs(np.log([shown.robot, shown.payload, shown.noise])) < np.log(1.5))
