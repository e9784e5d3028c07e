"""Motions, designs, scenes and simulations that cannot be: refused in words that say why."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from dynident.model import InertialParameters, Joint, Limits, Robot, load_robot
from dynident.trajectories import (
    Controller,
    Earlier,
    Fourier,
    FourierShape,
    Goal,
    JointBounds,
    Loads,
    NearGoal,
    NearShape,
    PointToPoint,
    SampledTrajectory,
    Scene,
    Task,
    Trapezoid,
    ViaPoints,
    ViaPointShape,
    build_design,
    plan_point_to_point,
    random_via_points,
    run_experiment,
)
from dynident.trajectories.design.scene import Capsule, HalfSpace, clearance
from dynident.trajectories.motions.via_points import quickest, random_points
from dynident.trajectories.simulation import RX90_DISTURBANCES, no_disturbances

RX90, UR10E = load_robot("rx90"), load_robot("ur10e")
FREE = Robot("free", (Joint(limits=Limits(speed=1.0)),))
BOUNDS = JointBounds.of(RX90, torque=(300.0, 300.0, 120.0, 50.0, 40.0, 20.0))
HIGH = Scene((Capsule("tool", 6, 0.12),), (HalfSpace("floor", offset=2.0),))
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], np.diag([0.01, 0.01, 0.005]))
STOPS = plan_point_to_point(RX90, random_points(RX90, 4, 0), speed=1.0, acceleration=0.9)
SAMPLES = STOPS.motion(250.0)


def near(joints: tuple[int, ...] = (2, 3, 5, 6), goal: Any = None, shape: Any = None, **changes: Any) -> object:
    """A motion near a pose of the UR10e, without torque limits."""
    own = replace(NearShape(POSE[None], joints, np.full(len(joints), np.radians(30.0)), 30.0), **changes)
    goal = goal or NearGoal(np.ones(6), 10.0, BODY)
    return build_design(UR10E, shape or own, goal, bounds=JointBounds.of(UR10E, torque=[np.inf] * 6))


def simulated(arm: Robot = RX90, controller: Controller | None = None) -> object:
    return run_experiment(arm, [Task("", STOPS)], no_disturbances(arm.n), controller=controller)


REFUSED: dict[str, Callable[[], object]] = {
    # Motions.
    "two points and positive ramps": lambda: PointToPoint(np.zeros((1, 2)), np.zeros(0), np.ones((0, 2))),
    "shorter than its ramps": lambda: PointToPoint(np.zeros((2, 2)), np.ones(1), np.full((1, 2), 3.0)),
    "blend must be": lambda: PointToPoint(np.zeros((2, 2)), np.ones(1), np.ones((1, 2)), blend=1.5),
    "two points are the same": lambda: plan_point_to_point(RX90, np.zeros((2, 6))),
    "bounds a move": lambda: plan_point_to_point(FREE, np.array([[0.0], [1.0]])),
    "without position limits": lambda: random_via_points(FREE, 5, 0),
    "two points": lambda: ViaPoints(np.zeros((1, 2)), np.zeros(0)),
    "positive durations": lambda: ViaPoints(np.zeros((2, 2)), np.zeros(1)),
    "a trapezoid rests in every point": lambda: ViaPoints(
        np.eye(3), np.ones(2), np.ones((3, 3)), segment=Trapezoid()
    ),
    "positive period": lambda: Fourier(np.zeros((1, 1)), np.zeros((1, 1, 2)), np.zeros((1, 1, 2)), 0.0),
    "no speed or acceleration limit": lambda: quickest(np.zeros((1, 6)), np.ones(6), np.ones(6)),
    "more than 10000000 samples": lambda: random_via_points(RX90, 3, seed=0).motion(1e12),
    "10000000 samples": lambda: run_experiment(
        RX90, [Task("slow", ViaPoints(random_points(RX90, 3, 0), np.full(2, 1e9)))], no_disturbances(6)
    ),
    r"here\.csv: joint \d moves at the start": lambda: SampledTrajectory(
        SAMPLES.t[90:], SAMPLES.q[90:], source="here.csv"
    ),
    r"joint \d moves at the end": lambda: SampledTrajectory(SAMPLES.t[:90], SAMPLES.q[:90]),
    "3 samples": lambda: SampledTrajectory(SAMPLES.t[:3], SAMPLES.q[:3]),
    r"q\.csv: joint \d goes beyond its (speed|acceleration) limit at": lambda: SampledTrajectory(
        0.5 * SAMPLES.t, SAMPLES.q, 2.0 * SAMPLES.qd, 4.0 * SAMPLES.qdd, "q.csv"
    ).check_limits(RX90),
    "beyond its position limit": lambda: SampledTrajectory(10.0 * SAMPLES.t, 3.0 * SAMPLES.q).check_limits(RX90),
    # Designs.
    "data length to come": lambda: Goal("d", earlier=Earlier(("FV1",), np.eye(1))),
    "6 positions within the limits": lambda: build_design(RX90, ViaPointShape(start=(9.0,) * 6)),
    "another start pose: clearance of .* against 0, violated": lambda: build_design(
        RX90, ViaPointShape(start=(0.0,) * 6), scene=HIGH
    ),
    "reference value other than zero": lambda: build_design(RX90, goal=Goal("a", reference={"FV1": 1.0})),
    "torque limits need the parameters": lambda: build_design(RX90, bounds=BOUNDS, loads=Loads({"FV1": 1.0})),
    "durations of the moves are fixed": lambda: build_design(
        RX90, ViaPointShape(5, fixed=1.0, longest=10.0), Goal("cond", payload_only=True)
    ),
    "a trapezoid rests in every via point": lambda: ViaPointShape(4, segment=Trapezoid()).family(RX90, BOUNDS),
    "'free' has no position limit for joint 1, 2": lambda: JointBounds.of(Robot("free", (Joint(), Joint()))),
    "give a NearShape": lambda: near(shape=FourierShape()),
    "mass not visible near this pose": lambda: near((5, 6)),
    "mass not visible": lambda: near((6,)),
    "positive one": lambda: near(duration=0.0),
    "the range must be": lambda: near(ranges=np.array([0.1])),
    "within the limits": lambda: near(poses=POSE[None] + 10.0),
    "6 positions": lambda: near(poses=POSE[None, :3]),
    "longer --duration": lambda: near(poses=np.array([POSE, 0.5 * POSE]), duration=2.0),
    # Scenes.
    "'c': link 1 and radius -0.1": lambda: Capsule("c", 1, -0.1),
    "does not have: it has 6": lambda: clearance(RX90, Scene((Capsule("c", 9, 0.1),))),
    "nothing in the scene can collide": lambda: clearance(RX90, Scene((Capsule("c", 3, 0.1),))),
    # Simulations.
    "'ur10e': its description lacks XX1": lambda: simulated(replace(UR10E, mass=None)),
    "not positive definite": lambda: simulated(replace(RX90, parameters=dict.fromkeys(RX90.parameters, 0.0))),
    "loses joint 2 at -0.40 s": lambda: simulated(controller=Controller(0.1, 0.1, 0.0, feed_forward=0.0)),
    "gains must be positive": lambda: Controller(position=0.0),
    "'motion' or 'gravity'": lambda: replace(Controller(), compensates="nothing"),  # type: ignore[arg-type]
    "does not sag": lambda: Controller().sagging(RX90, BODY, [STOPS], 1e-3),
    "must not be negative": lambda: replace(RX90_DISTURBANCES, friction=-0.1),
    "must be positive": lambda: replace(RX90_DISTURBANCES, slow_memory=0.0),
}
"""Words of the refusal, and what is refused."""


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_is_refused(words: str) -> None:
    with pytest.raises(ValueError, match=words):
        REFUSED[words]()
