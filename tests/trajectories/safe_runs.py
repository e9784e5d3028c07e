"""Motions for every payload in bounds, about random poses of any arm, and how near bodies come to limits."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import InertialParameters, Motion, Robot, inverse_dynamics, payload_regressor
from dynident.model.kernel.kernel import Kernel
from dynident.trajectories import (
    Design,
    DesignProblem,
    Fourier,
    JointBounds,
    Loads,
    NearGoal,
    NearShape,
    PayloadSet,
    StaticShape,
    build_design,
    usual_scene,
)
from dynident.trajectories.design.limits import unit_point
from dynident.trajectories.design.score import REHEARSAL, check_held


def dense(function: Any, *states: Array) -> Array:
    """A regressor on N states, (N, n, c)."""
    kernel = Kernel(function)
    entries, (rows, columns) = kernel(*states), function.size_out(0)
    W = np.zeros((entries.shape[1], rows, columns))
    W[:, kernel.rows, kernel.columns] = entries.T
    return W


def drawn_points(payloads: PayloadSet, count: int, draw: np.random.Generator) -> Array:
    """Places in a region, some of them on its surface, (count, 3)."""
    s = draw.standard_normal((count, 3)) if payloads.region == "ball" else draw.uniform(-1.0, 1.0, (count, 3))
    size = np.linalg.norm(s, axis=1) if payloads.region == "ball" else np.abs(s).max(axis=1)
    s *= (np.where(draw.random(count) < 0.5, 1.0, draw.random(count) ** (1 / 3)) / size)[:, None]
    return np.asarray(payloads.centre + s @ payloads.axes.T)


def drawn_bodies(payloads: PayloadSet, count: int, draw: np.random.Generator) -> Array:
    """Ten parameters of bodies of up to six point masses each, some lighter than the heaviest, (count, 10)."""
    shares = (
        draw.dirichlet(np.full(6, 0.3), count)
        * np.where(draw.random(count) < 0.5, 1.0, draw.random(count))[:, None]
    )
    parts = np.stack(unit_point(*drawn_points(payloads, 6 * count, draw).T), axis=1).reshape(count, 6, 10)
    return np.asarray(payloads.mass * np.einsum("ks,ksp->kp", shares, parts))


def own_torque(robot: Robot, motion: Motion) -> Array:
    """Torque without payload by Newton and Euler, (N, n)."""
    chi, kernel = robot.chi(), Kernel(inverse_dynamics(robot))
    torque = np.zeros(motion.q.shape)
    torque[:, kernel.rows] = kernel(motion.q, motion.qd, motion.qdd, chi).T
    return torque


def worst_shares(robot: Robot, motion: Motion, payloads: PayloadSet, limits: Array) -> Array:
    """Share of its limit that each joint comes to with its worst bodies, each put into the regressor, (n,)."""
    own, rows = own_torque(robot, motion), dense(payload_regressor(robot), motion.q, motion.qd, motion.qdd)
    shares = np.zeros(robot.n)
    for j, limit in enumerate(limits):
        for extreme in payloads.extremes(rows[:, j]):
            torque = own[:, j] + np.einsum("kp,pk->k", rows[:, j], extreme[1:])
            shares[j] = max(shares[j], float(np.abs(torque).max()) / limit)
    return shares


def drawn_shares(robot: Robot, motion: Motion, bodies: Array, limits: Array) -> Array:
    """Share of its limit that each joint comes to with each body, (n, bodies)."""
    own, rows = own_torque(robot, motion), dense(payload_regressor(robot), motion.q, motion.qd, motion.qdd)
    return np.array(
        [np.abs(own[:, j, None] + rows[:, j] @ bodies.T).max(axis=0) / limit for j, limit in enumerate(limits)]
    )


BODIES, RATE, FINE = 10_000, 100.0, 1000.0  # Hz: where friction changes its sign, few samples come near the most
_RADIUS, _REACH = 0.15, 0.1  # m: of the ball, and of its centre before the flange
_OUTSIDE = 1.1  # times the mass and the half axes
_TRIES = 200  # poses
_RANGE = 25.0  # deg


class Case(NamedTuple):
    """A pose in which every payload can be held, and what is asked of a motion about it."""

    robot: Robot
    payloads: PayloadSet
    shape: NearShape
    goal: NearGoal
    bounds: JointBounds

    def problem(self, payloads: PayloadSet | None) -> DesignProblem:
        """Torque limits hold for each payload of a set, or for the arm alone."""
        loads = Loads(self.robot.parameters, payloads)
        return build_design(self.robot, self.shape, self.goal, bounds=self.bounds, loads=loads)

    def lowered(self, design: Design) -> "Case":
        """Torque limits of 85 % of what a motion needs with its worst bodies, yet 20 % above its rehearsal's."""
        plan = design.plan
        assert isinstance(plan, Fourier)
        fast, slow = (
            worst_shares(self.robot, motion, self.payloads, np.ones(self.robot.n))
            for motion in (plan.motion(RATE), plan.slowed(REHEARSAL).motion(REHEARSAL * RATE))
        )
        torque = np.minimum(self.bounds.torque, np.maximum(0.85 * fast, 1.2 * slow))
        return self._replace(bounds=replace(self.bounds, torque=torque))

    @property
    def wider(self) -> PayloadSet:
        """Bodies that are somewhat heavier and stand further out."""
        return PayloadSet(_OUTSIDE * self.payloads.mass, self.payloads.centre, _OUTSIDE * self.payloads.axes)


class Seen(NamedTuple):
    """Bodies that break a limit, and the share of one that the worst of a set, and of a wider set, comes to."""

    violations: int
    reached: float
    outside: float


def held_case(robot: Robot, share: float, duration: float, draw: np.random.Generator) -> Case:
    """The first random pose that shows the mass and holds every payload up to a share of the rated one at rest."""
    rated = robot.rated_payload if np.isfinite(robot.rated_payload) else 5.0
    payloads = PayloadSet.within(share * rated, _RADIUS, (0.0, 0.0, _REACH)).seen_from(robot.flange)
    bounds, mass = JointBounds.of(robot), payloads.mass
    expected = InertialParameters.from_com(mass, [0.0, 0.0, _REACH], 0.003 * mass * np.eye(3))
    goal, joints = NearGoal(0.007 * bounds.torque, 10.0, expected), tuple(range(2, robot.n + 1))
    for _ in range(_TRIES):
        pose = bounds.middle + 0.6 * bounds.half * draw.uniform(-1.0, 1.0, robot.n)
        shape = NearShape(pose[None], joints, np.full(len(joints), np.radians(_RANGE)), duration)
        if not shape.visibility(robot).mass_visible:
            continue
        case = Case(robot, payloads, shape, goal, bounds)
        try:
            check_held(case.problem(payloads), shape.poses)
        except InputError:
            continue
        return case
    raise InputError(f"{robot.name}: no pose in {_TRIES} holds every payload")


def seen_of(case: Case, design: Design, draw: np.random.Generator) -> Seen:
    """Put bodies into the arm's own regressor along a motion, on another grid than the design's."""
    limits, bodies = case.bounds.torque, drawn_bodies(case.payloads, BODIES, draw)
    drawn = drawn_shares(case.robot, design.motion(RATE), bodies, limits)
    reached, outside = (
        float(worst_shares(case.robot, design.motion(FINE), payloads, limits).max())
        for payloads in (case.payloads, case.wider)
    )
    return Seen(int((drawn > 1.0).any(axis=0).sum()) + int(reached > 1.0), reached, outside)


class RestCase(NamedTuple):
    """Poses at rest of all joints over the whole range, with half of the rated payload."""

    robot: Robot
    shape: StaticShape
    goal: NearGoal
    bounds: JointBounds
    problem: DesignProblem

    def sigma(self, poses: Array, constants: bool = True) -> Array:
        """Standard deviations of first moments and mass by the dense formula, (4,): both approaches to each pose in
        two recordings, constant torques of each joint unknown, or none.
        """
        still, n = np.zeros_like(poses), self.robot.n
        W = dense(payload_regressor(self.robot), poses, still, still)[:, :, 6:]
        W = np.dstack([W, np.tile(np.eye(n), (len(poses), 1, 1))])
        A = (np.concatenate([W, W]) / (np.sqrt(2.0) * self.goal.noise[:, None])).reshape(-1, 4 + n)
        # Constant torques of the arm change by 3.3 % of a friction that scatters by 5 %; the wrist's are free.
        known = np.diag(0.05 / 0.033 / self.goal.noise)[: n - 3]
        A = np.vstack([A, np.hstack([np.zeros((n - 3, 4)), known])])
        columns = slice(None) if constants else slice(4)
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(A[:, columns].T @ A[:, columns])))[:4])


def rest_case(robot: Robot, count: int = 8) -> RestCase:
    """Start in the middle of the range, or in the first random pose that is clear of everything."""
    bounds, draw = JointBounds.of(robot), np.random.default_rng(0)
    mass = 0.5 * (robot.rated_payload if np.isfinite(robot.rated_payload) else 5.0)
    body = InertialParameters.from_com(mass, [0.0, 0.0, _REACH], 0.003 * mass * np.eye(3))
    body = body.moved(robot.flange.R, robot.flange.p)
    goal = NearGoal(0.005 * bounds.torque, 1.0 / 1.5, body)
    approach = np.array([np.radians(3.0) if joint.revolute else 0.02 for joint in robot.joints])
    start = bounds.middle
    for _ in range(_TRIES):
        shape = StaticShape(start, tuple(range(1, robot.n + 1)), bounds.low, bounds.high, approach, count)
        scene = usual_scene(robot, start[None], True)
        try:
            problem = build_design(
                robot, shape, goal, bounds=bounds, loads=Loads(robot.parameters, body), scene=scene
            )
        except InputError:
            start = bounds.middle + 0.6 * bounds.half * draw.uniform(-1.0, 1.0, robot.n)
            continue
        return RestCase(robot, shape, goal, bounds, problem)
    raise InputError(f"{robot.name}: no pose in {_TRIES} is clear")
