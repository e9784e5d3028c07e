"""Design problems of the RX90 with torque limits for two loads and obstacles, by goal and shape."""

from dataclasses import replace
from typing import Any

import numpy as np
from dynident.common.arrays import Array
from dynident.model import InertialParameters, Limits, Robot, load_robot
from dynident.trajectories import (
    DesignProblem,
    FourierShape,
    Goal,
    JointBounds,
    Loads,
    Scene,
    Trapezoid,
    ViaPointShape,
    build_design,
)
from dynident.trajectories.design.goal import Shape
from dynident.trajectories.design.limits import Limit, State
from dynident.trajectories.design.scene import Capsule, HalfSpace

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


def problem(
    goal: str,
    shape: str,
    *,
    bounds: JointBounds = BOUNDS,
    **of_shape: Any,
) -> DesignProblem:
    """With torque limits for two loads, and obstacles."""
    loads = Loads(ROBOT.parameters, PAYLOAD)
    own = replace(SHAPES[shape], **of_shape)
    return build_design(ROBOT, own, GOALS[goal], bounds=bounds, loads=loads, scene=SCENE)


def constraint_values(task: DesignProblem, x: Array, width: float) -> Array:
    """g(x) <= 0 of all limits that bound anything, one below the other."""
    state, parts = task.state(x, width), []
    for limit in task.limits:
        y = limit.values(state)
        parts += [(sign * y - bound)[np.isfinite(bound + 0 * y)] for sign, bound in sides(limit, y)]
    return np.concatenate(parts)


def constraint_jacobian(task: DesignProblem, x: Array, width: float) -> Array:
    """Derivatives of ``constraint_values`` from the limits' own slopes, one row after the other."""
    state, rows = task.state(x, width), []
    for limit in task.limits:
        y = limit.values(state)
        for sign, bound in sides(limit, y):
            for place in np.argwhere(np.isfinite(bound)):
                unit = np.zeros(y.shape)
                unit[tuple(place)] = sign

                def penalty(state: State, into: State, limit: Limit = limit, unit: Array = unit) -> float:
                    limit.pullback(state, unit, into)
                    return 0.0

                rows.append(task.trespass(x, width, penalty)[1])
    return np.array(rows)


def sides(limit: Limit, y: Array) -> list[tuple[float, Array]]:
    return [
        (1.0, np.broadcast_to(limit.high, y.shape)),
        (-1.0, np.broadcast_to(-limit.low, y.shape)),
    ]


def limited(robot: Robot, bounds: JointBounds) -> Robot:
    """The robot with these limits in its description."""
    joints = tuple(
        replace(joint, limits=Limits((float(low), float(high)), float(v), float(a), float(tau)))
        for joint, low, high, v, a, tau in zip(
            robot.joints, bounds.low, bounds.high, bounds.speed, bounds.acceleration, bounds.torque, strict=True
        )
    )
    return replace(robot, joints=joints)
