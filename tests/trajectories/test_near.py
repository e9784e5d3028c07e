"""Motions near a pose: limits, held joints, prediction against simulation, gradients."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.model import InertialParameters, Robot, load_robot, payload_regressor
from dynident.model.inertia import PayloadSpread
from dynident.model.kernel.kernel import Kernel
from dynident.trajectories import (
    Design,
    DesignProblem,
    Fourier,
    JointBounds,
    NearGoal,
    NearShape,
    build_design,
    second_pose,
    solve_design,
)

BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], np.diag([0.01, 0.01, 0.005]))
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
OTHER = POSE + np.radians([0, 0, 0, 0, 90, 0])
NOISE = np.array([1.73, 3.01, 1.10, 0.37, 0.38, 0.31])


class Asked(NamedTuple):
    robot: Robot
    shape: NearShape
    goal: NearGoal

    @property
    def bounds(self) -> JointBounds:
        """Without torque limits: the description holds no parameters."""
        return JointBounds.of(self.robot, torque=[np.inf] * self.robot.n)

    def problem(self) -> DesignProblem:
        return build_design(self.robot, self.shape, self.goal, bounds=self.bounds)

    def solved(self, seed: int = 0) -> "Solved":
        design = solve_design(self.problem(), seed=seed, starts=1)
        assert isinstance(design.plan, Fourier)
        spread = self.goal.predicted(self.robot, design.plan, self.shape.joints)
        return Solved(design, design.plan, spread)


class Solved(NamedTuple):
    design: Design
    motion: Fourier
    spread: PayloadSpread


def asked(joints: tuple[int, ...] = (2, 3, 5, 6), mass_sigma: float | None = None, **changes: Any) -> Asked:
    shape = NearShape(POSE[None], joints, np.full(len(joints), np.radians(30.0)), 30.0)
    return Asked(load_robot("ur10e"), replace(shape, **changes), NearGoal(NOISE, 10.0, BODY, mass_sigma))


@pytest.fixture(scope="module")
def design() -> Solved:
    return asked().solved()


def test_designed_motions_reach_the_figures(design: Solved) -> None:
    """At least as good as the best of 60 random motions: 0.045 kg and 4.1 mm."""
    assert design.spread.mass <= 0.045
    assert design.spread.com.max() <= 4.1e-3
    assert design.design.evaluations < 2000  # about a millisecond each


def test_every_limit_is_kept_and_the_others_are_held(design: Solved) -> None:
    motion, bounds = design.motion.motion(500.0), JointBounds.of(load_robot("ur10e"))
    assert np.abs(motion.q[:, [0, 3]] - POSE[[0, 3]]).max() == 0.0
    assert np.abs(motion.q - POSE).max() <= np.radians(30.0) * (1.0 + 1e-9)
    assert (np.abs(motion.qd) <= bounds.speed * (1.0 + 1e-9)).all()
    assert (np.abs(motion.qdd) <= bounds.acceleration * (1.0 + 1e-9)).all()
    for end in (0, -1):
        assert motion.q[end] == pytest.approx(POSE, abs=1e-9)
        assert np.abs(motion.qd[end]).max() < 1e-9
    assert motion.t[-1] == pytest.approx(30.0)


def test_the_prediction_is_the_scatter_of_least_squares(design: Solved) -> None:
    """200 noisy runs solved by plain least squares with a constant and a sign column for each moving joint."""
    robot, rate = load_robot("ur10e"), 10.0
    motion, moving = design.motion.motion(rate), [1, 2, 4, 5]
    phi = Kernel(payload_regressor(robot))
    W = np.zeros((len(motion.t), 6, 10))
    W[:, phi.rows, phi.columns] = phi(motion.q, motion.qd, motion.qdd).T
    rows, clean = [], []
    for k, j in enumerate(moving):
        used = np.abs(motion.qd[:, j]) >= 0.03
        own = np.zeros((used.sum(), 10 + 2 * len(moving)))
        own[:, :10], own[:, 10 + 2 * k], own[:, 11 + 2 * k] = W[used, j], 1.0, np.sign(motion.qd[used, j])
        rows.append(own / NOISE[j])
        clean.append(W[used, j] @ BODY.vector / NOISE[j])
    A, y = np.vstack(rows), np.concatenate(clean)
    draw = np.random.default_rng(0).standard_normal((len(y), 200))
    solutions = np.linalg.lstsq(A, y[:, None] + np.sqrt(2.0) * draw, rcond=None)[0]
    mass, com = solutions[9].std(), (solutions[6:9] / solutions[9]).std(axis=1)
    spread = NearGoal(NOISE, rate, BODY).predicted(robot, design.motion, (2, 3, 5, 6), sample_rate=rate)
    assert spread.mass == pytest.approx(mass, rel=0.15)
    assert spread.com == pytest.approx(com, rel=0.15)


def test_without_a_joint_of_the_wrist_there_is_no_second_pose() -> None:
    assert second_pose(*asked((2, 3))) is None


@pytest.mark.parametrize("mass_sigma", [None, 0.5])
def test_the_prediction_goes_by_independent_samples_not_by_those_of_the_motion(
    design: Solved, mass_sigma: float | None
) -> None:
    """A motion sampled ten times as often tells no more; a fourth of the independent samples tells half."""
    robot, joints = load_robot("ur10e"), (2, 3, 5, 6)

    def mass(sampled: float, rate: float) -> float:
        goal = NearGoal(NOISE, rate, BODY, mass_sigma)
        return goal.predicted(robot, design.motion, joints, sample_rate=sampled).mass

    assert mass(100.0, 10.0) == pytest.approx(mass(10.0, 10.0), rel=0.03)
    if mass_sigma is None:
        assert mass(100.0, 2.5) == pytest.approx(2.0 * mass(100.0, 10.0), rel=1e-9)
    assert mass(40.0, 40.0) == pytest.approx(0.5 * mass(10.0, 10.0), rel=0.05)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_gradient_is_that_of_differences(seed: int) -> None:
    """Differences of fourth order: the value's own rounding, 1e-9 of it, forbids small steps."""
    problem = asked((2, 5), duration=9.0, poses=np.array([POSE, OTHER])).problem()
    x, terms = problem.family.random(np.random.default_rng(seed)), [partial(problem.criterion_term, order=1.0)]
    value, slope = problem.evaluate(x, 0.5, terms)
    assert np.isfinite(value)
    direction = np.random.default_rng(2).standard_normal(len(x))
    step = 3e-4
    before2, before, after, after2 = (
        problem.evaluate(x + k * step * direction, 0.5, terms)[0] for k in (-2, -1, 1, 2)
    )
    difference = (8.0 * (after - before) - (after2 - before2)) / (12.0 * step)
    assert slope @ direction == pytest.approx(difference, rel=1e-5)
