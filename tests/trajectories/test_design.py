"""Designs: limits kept between samples, what they teach, honest answers where there is no good one."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import INERTIAL, InertialParameters, Robot, inverse_dynamics
from dynident.model.kernel.kernel import Kernel
from dynident.tests.trajectories.design_problems import (
    BOUNDS,
    FEW,
    GOALS,
    NOISE,
    PAYLOAD,
    ROBOT,
    SCENE,
    STRONG,
    TORQUE,
    limited,
    problem,
)
from dynident.trajectories import (
    Design,
    DesignProblem,
    Earlier,
    FourierShape,
    Goal,
    JointBounds,
    Trapezoid,
    ViaPoints,
    ViaPointShape,
    build_design,
    random_via_points,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.descent import Lagrangian
from dynident.trajectories.design.floor import floor_under
from dynident.trajectories.simulation.simulator import parameter_vector


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
    return kernel(motion.q, motion.qd, motion.qdd, parameter_vector(robot, robot.parameters, payload)).T


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
def test_it_teaches_more_than_random_motions(guarded: Design) -> None:
    """Per second, against resting motions at the limits, which need not even keep the torques."""
    robot = limited(ROBOT, guarded.problem.bounds)
    random = [
        score_motion(guarded.problem, random_via_points(robot, 14, seed, speed=1.0).motion(100.0))
        for seed in range(20)
    ]
    assert guarded.score.value < min(score.value for score in random) - 0.3


@pytest.mark.long
def test_condition_number_of_a_design_and_its_floor() -> None:
    design = solve_design(build_design(ROBOT, ViaPointShape(14), Goal("cond")), seed=0, starts=1)
    assert design.feasible
    assert design.learnt.condition_number < 18.0
    assert design.score.value == pytest.approx(np.log(design.learnt.condition_number), abs=1e-6)
    floor = floor_under(design.problem, design.score.value, states=60, effort=1)
    assert 8.0 < np.exp(floor.value) < 11.0
    assert floor.gap == pytest.approx(design.score.value - floor.value)


def test_a_longest_duration_binds() -> None:
    task = build_design(ROBOT, ViaPointShape(4, samples=6, longest=4.0), GOALS["payload"])
    design = solve_design(task, seed=0, starts=1)
    assert isinstance(design.plan, ViaPoints)
    assert design.feasible
    assert design.plan.duration <= 4.0
    assert score_motion(task, design.motion(997.0)).feasible


@pytest.mark.long
def test_same_seed_same_motion() -> None:
    task = build_design(ROBOT, FourierShape(3, 5.0), Goal("cond-scaled", payload_only=True))
    first, two, reseeded = (solve_design(task, seed=seed, starts=1) for seed in (1, 1, 2))
    assert np.array_equal(first.motion(50.0).q, two.motion(50.0).q)
    assert not np.array_equal(first.motion(50.0).q, reseeded.motion(50.0).q)


@pytest.mark.long
def test_earlier_recordings_turn_the_design_to_what_is_uncertain() -> None:
    """What is known well already needs no more of the motion's time: from two of three starts at least."""
    names = tuple(f"{kind}6" for kind in INERTIAL)
    known = Earlier(names, np.diag([1e-3] * 6 + [1e3] * 4))  # the first moments and the mass
    plain = Goal("d", payload_only=True, data_length=10.0)
    shape = FourierShape(3, 5.0)
    gains = []
    for seed in range(3):
        first, second = (
            solve_design(build_design(ROBOT, shape, goal), seed=seed, starts=1)
            for goal in (plain, replace(plain, earlier=known))
        )
        assert all(second.learnt.sigma[name] <= 1.001e-3 for name in names[6:])
        gains.append(score_motion(second.problem, first.motion(200.0)).value - second.score.value)
    assert np.median(gains) > 1e-3


@pytest.mark.long
def test_limits_that_cannot_be_met_are_named() -> None:
    """The arm cannot be held up with 20 N·m on joint 2."""
    weak = JointBounds.of(ROBOT, torque=(300.0, 20.0, 120.0, 50.0, 40.0, 20.0))
    task = build_design(ROBOT, FourierShape(2, 4.0), Goal("d", columns=FEW), bounds=weak)
    design = solve_design(task, starts=1)
    assert not design.feasible
    assert design.score.max_violation > 0.01
    assert any("torque of joint 2" in line and "against" in line for line in design.score.violations)


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


def test_interrupted_within_an_evaluation(monkeypatch: pytest.MonkeyPatch) -> None:
    task = build_design(ROBOT, ViaPointShape(14), Goal("cond"))
    calls, true = [0], type(task).evaluate

    def evaluate(
        self: DesignProblem, x: Array, order: float, width: float, limits: Lagrangian | None = None
    ) -> tuple[float, Array]:
        calls[0] += 1
        if calls[0] > 50:
            raise KeyboardInterrupt
        return true(self, x, order, width, limits)

    monkeypatch.setattr(type(task), "evaluate", evaluate)
    design = solve_design(task)
    assert design.interrupted
    assert design.feasible
    assert calls[0] == 51
