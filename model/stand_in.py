"""Nominal parameters and limits: what a robot's description lacks is assumed, from its mass on, and called so."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from ..common import Array, InputError, listed
from .drives import joint_of, parameter_kind
from .dynamics import gravity, mass_matrix
from .frames import FrameChange
from .inertia import INERTIAL, InertialParameters, Pose
from .robot import ASSUMED, SOURCED, Robot, check_robot

SPEED = {"revolute": np.pi / 3.0, "prismatic": 0.1}
"""Speed limit where a description has none [rad/s or m/s]: slower than every shipped arm."""
ACCELERATION = 10.0  # acceleration limit over the speed limit [1/s], where a description has none


def with_assumed_limits(robot: Robot) -> Robot:
    """Complete the robot by limits of positions, speeds and accelerations where its description has none.

    Joints that turn are given half a turn to either side, joints the speed ``SPEED`` and ``ACCELERATION`` times
    their speed; sliding joints without a range stay without. What was assumed is in the robot's ``sources``.
    """
    rules = {
        "position": "half a turn to either side; compare with the arm before you run a motion on it",
        "speed": f"{np.degrees(SPEED['revolute']):.0f} deg/s or {SPEED['prismatic']:g} m/s",
        "acceleration": f"{ACCELERATION:g} times the speed per second",
    }
    joints, lacking = [], dict[str, list[str]]()
    for number, joint in enumerate(robot.joints, start=1):
        limits, assumed = joint.limits, dict[str, Any]()
        if joint.revolute and np.isinf(limits.position).all():
            assumed["position"] = (-np.pi, np.pi)
        if np.isinf(limits.speed):
            assumed["speed"] = SPEED[joint.kind]
        if np.isinf(limits.acceleration):
            assumed["acceleration"] = ACCELERATION * assumed.get("speed", limits.speed)
        joints.append(replace(joint, limits=replace(limits, **assumed)))
        for name in assumed:
            lacking.setdefault(name, []).append(str(number))
    told = {key: f"{ASSUMED}: joint {', '.join(lacking[key])}: {rules[key]}" for key in rules if key in lacking}
    return replace(robot, joints=tuple(joints), sources={**robot.sources, **told}) if told else robot


RADIUS = 0.08  # radius of the cylinders over the sum of the lengths between joints
MOVING = 0.5
"""Fraction of the maker's mass in the cylinders; the rest stands in the base and about axis 1.

(h2 + h3) / (mass x length), with h_j = hypot(MXjR, MYjR), then is .22 to .29. Five arms that were identified or
published have .19 to .31; cylinders of all the mass would have .45 to .58.
"""
SAFETY = 1.5  # torque limit over the largest torque of links and rated payload
FRICTION = 0.1  # friction over the torque limit at the largest speed, half of it dry, half viscous
ROTOR = 0.2  # rotor inertia over the largest inertia that the joint turns
LOAD = 0.2  # payload that drives are taken to be made for over the links' mass, where no rated payload is known
PAYLOAD_COM = (0.05, 0.0, 0.1)
"""Centre of mass of a rated payload in the flange's frame [m]: out of the flange and off its axis."""
PAYLOAD_INERTIA = 0.003  # moments of inertia of a rated payload over its mass [m^2]
POSES = 2000  # random poses over which what a joint carries is looked for


def cylinders(robot: Robot, total_mass: float) -> tuple[InertialParameters, ...]:
    """Model the links as cylinders of one density and radius, each from a joint to the next at q = 0.

    The radius is ``RADIUS`` times the sum of all lengths between joints; each cylinder goes on by one radius beyond
    both joints, so that links between axes that meet have an extent too. One of zero length stands along z.

    ``total_mass``: of all links [kg]; InputError if it is not positive.
    """
    if not 0.0 < total_mass < np.inf:
        raise InputError(f"total mass {total_mass:g} kg of the links must be positive")
    ends = [np.array(FrameChange.of(joint, 0.0, np).origin) for joint in robot.joints[1:]] + [np.zeros(3)]
    radius, bodies = cylinder_radius(robot), []
    distances = np.array([float(np.linalg.norm(end)) for end in ends])
    lengths = distances + 2.0 * radius
    masses = total_mass * lengths / lengths.sum()
    for mass, end, distance, length in zip(masses.tolist(), ends, distances, lengths, strict=True):
        axis = end / distance if distance > 0.0 else np.array([0.0, 0.0, 1.0])
        # Moments of a solid cylinder about its axis, and across it through its centre.
        along, across = mass * radius**2 / 2.0, mass * (3.0 * radius**2 + length**2) / 12.0
        inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
        bodies.append(InertialParameters.from_com(mass, end / 2.0, inertia))
    return tuple(bodies)


def cylinder_radius(robot: Robot) -> float:
    """Radius of ``cylinders`` [m]."""
    return RADIUS * (sum(math.hypot(joint.d, joint.r) for joint in robot.joints[1:]) or 1.0)


def with_stand_in(robot: Robot) -> Robot:
    """Complete the robot by parameters and limits, as far as its description lacks them and they can be assumed.

    Limits are ``with_assumed_limits``, links ``cylinders`` of the fraction ``MOVING`` of the maker's mass or,
    without it, as dense as the links whose bodies are known; torque limits ``SAFETY`` times what is needed,
    friction the fraction ``FRICTION`` of them, rotors ``rotor_inertias``; offsets are zero. What was assumed is in
    its ``sources``.

    Raises:
        InputError: if the description holds neither bodies nor the arm's mass, or a part of a body only.
    """
    if (nominal := nominal_bodies(robot)) is None:
        fault = f"robot {robot.name!r}: its description lacks {listed(missing_inertial(robot))}"
        mass = "the arm's mass for a stand-in (--arm-mass KG, or mass_kg in its TOML)"
        raise InputError(f"{fault}; give {mass}, or the bodies of all links ([parameters], <inertial>)")
    (bodies, assumed), robot = nominal, with_assumed_limits(robot)
    values = {**dict.fromkeys(robot.standard, 0.0), **bodies, **robot.parameters}
    assumptions = [assumed] if assumed else []
    unknown = values.keys() - robot.parameters.keys()
    if rotors := [name for name in unknown if parameter_kind(name) == "IA"]:
        inertias = rotor_inertias(robot, values)
        values |= {name: float(inertias[joint_of(name)]) for name in rotors}
        assumptions.append(f"rotors add {100 * ROTOR:g} % of the inertia that they turn")
    sources, friction, limits = dict(robot.sources), dict[str, float](), [joint.limits for joint in robot.joints]
    if not np.isfinite([limit.torque for limit in limits]).all():
        rest, inertia, load = _needed(robot, values)
        hastening = inertia * np.array([[limit.acceleration] for limit in limits])
        needed = SAFETY * (np.abs(rest) + hastening).max(axis=1)
        pairs = ((values.get(f"FS{j}", 0.0), values.get(f"FV{j}", 0.0)) for j in range(1, robot.n + 1))
        rubs = SAFETY * np.array([FS + FV * limit.speed for (FS, FV), limit in zip(pairs, limits, strict=True)])
        largest = zip(limits, np.maximum(needed, rubs).tolist(), strict=True)
        limits = [replace(limit, torque=min(limit.torque, most)) for limit, most in largest]
        rated = np.isfinite(robot.rated_payload)
        payload = "rated payload" if rated else f"a payload of {load:.2g} kg (itself assumed)"
        still = (
            f"{SAFETY:g} times the largest torque of links and {payload} at rest and at the largest acceleration"
        )
        more = ", or of friction where that is more" if (rubs > needed).any() else ""
        sources["torque"] = f"{ASSUMED}: {still}{more}"
    for number, limit in enumerate(limits, start=1):
        most, fastest = limit.torque, limit.speed
        if np.isfinite([most, fastest]).all():  # of coupled drives one rotor turns with both joints, and rubs too
            levels = {"FS": 1.0, "FV": 1.0 / fastest, "FSM": 0.5, "FVM": 0.5 / fastest}
            friction |= {f"{kind}{number}": 0.5 * FRICTION * most * part for kind, part in levels.items()}
    if friction := {name: value for name, value in friction.items() if name in unknown}:
        values |= friction
        assumptions.append(f"friction is {100 * FRICTION:g} % of the torque limits at full speed")
    if assumptions:
        sources["parameters"] = f"{ASSUMED}: {', '.join(assumptions)}"
    joints = tuple(replace(joint, limits=limit) for joint, limit in zip(robot.joints, limits, strict=True))
    return replace(robot, joints=joints, parameters=values, sources=sources)


def nominal_bodies(robot: Robot) -> tuple[dict[str, float], str] | None:
    """Inertial parameters of all links as far as described, and what was assumed of the others, as text.

    None where the description holds neither bodies nor the arm's mass, or a part of a body only.
    """
    missing = missing_inertial(robot)
    bodiless = sorted({joint_of(name) + 1 for name in missing})
    known = {name: value for name, value in robot.parameters.items() if parameter_kind(name) in INERTIAL}
    if not bodiless:
        return known, ""
    weight = sum(value for name, value in known.items() if parameter_kind(name) == "M")
    if len(missing) < len(INERTIAL) * len(bodiless) or (robot.mass is None and not weight > 0.0):
        return None
    if robot.mass is None:
        fractions = [body.mass for body in cylinders(robot, 1.0)]
        total = weight / (1.0 - sum(fractions[link - 1] for link in bodiless))
        density = f"as dense as the others, which weigh {weight:.3g} kg"
    else:
        total, doubt = MOVING * robot.mass, " (itself assumed)" if robot.assumed("mass") else ""
        density = f"of {100 * MOVING:g} % of the arm's {robot.mass:g} kg{doubt}"
    bodies = cylinders(robot, total)
    for link in bodiless:
        known |= bodies[link - 1].named(str(link))
    which = "links" if len(bodiless) == robot.n else f"links without a body ({', '.join(map(str, bodiless))})"
    return known, f"{which} are cylinders {density}"


def rehearsed(robot: Robot) -> Robot:
    """Complete the robot ``with_stand_in`` where that has what it starts from, else ``with_assumed_limits``."""
    return with_stand_in(robot) if nominal_bodies(robot) else with_assumed_limits(robot)


def completed(robot: Robot, limits: bool = True, frames: int = 3) -> Robot:
    """Complete a robot that lacks parameters, or ``limits``, as ``rehearsed``, and warn of what was assumed.

    ``frames``: from here to the user's line, which the warning names.
    """
    check_robot(robot)
    told = all(name in robot.parameters for name in robot.standard)
    if told and (not limits or with_assumed_limits(robot) is robot):
        return robot
    whole = rehearsed(robot) if limits else with_stand_in(robot)
    new = {name: rule for name, rule in whole.assumed().items() if robot.sources.get(name) != whole.sources[name]}
    rules = "; ".join(f"{SOURCED[name]}: {rule}" for name, rule in new.items())
    if rules:
        warnings.warn(f"robot {robot.name!r}: assumed, as its description lacks them: {rules}", stacklevel=frames)
    return whole


def missing_inertial(robot: Robot) -> list[str]:
    """Inertial parameters that the description lacks."""
    names = (f"{kind}{link}" for link in range(1, robot.n + 1) for kind in INERTIAL)
    return [name for name in names if name not in robot.parameters]


def rotor_inertias(robot: Robot, parameters: Mapping[str, float]) -> Array:
    """Rotor inertias on the joints' side [kg m^2 or kg], shape (n,), where nothing is known of the drives.

    The fraction ``ROTOR`` of the largest inertia of links and rated payload, and twice the payload's own at the
    flange: rotors of an identified RX90 and UR10e are about as large, from the base to the wrist.
    """
    without = {name: 0.0 if parameter_kind(name) == "IA" else value for name, value in parameters.items()}
    _, inertia, load = _needed(robot, without)
    # About the flange's axis, for each kg (Steiner).
    own = PAYLOAD_COM[0] ** 2 + PAYLOAD_INERTIA
    return np.asarray(ROTOR * inertia.max(axis=1) + 2.0 * own * load)


def _needed(robot: Robot, parameters: Mapping[str, float]) -> tuple[Array, Array, float]:
    """Torque at rest and inertia of each joint, n x poses, at ``poses_in_range``, and with which payload [kg].

    It is the rated one or, where that is not known, a fraction of the links' mass.
    """
    links = sum(value for name, value in parameters.items() if parameter_kind(name) == "M")
    load = robot.rated_payload if np.isfinite(robot.rated_payload) else LOAD * links
    flange = robot.flange_pose or Pose()
    body = InertialParameters.from_com(load, PAYLOAD_COM, PAYLOAD_INERTIA * load * np.eye(3))
    chi = robot.chi(parameters, body.moved(flange.R, flange.p))
    q = ca.SX.sym("q", robot.n)
    torque = ca.Function("torque", [q], [gravity(robot)(q, chi), ca.diag(mass_matrix(robot)(q, chi))])
    rest, inertia = (np.array(part) for part in torque.map(POSES)(poses_in_range(robot, POSES).T))
    return rest, inertia, load


def poses_in_range(robot: Robot, count: int) -> Array:
    """Random positions in the joints' ranges, or one turn or metre without a range, count x n; always the same."""
    bound = np.array([np.pi if joint.revolute else 0.5 for joint in robot.joints])[:, None]
    low, high = np.clip([joint.limits.position for joint in robot.joints], -bound, bound).T
    return np.random.default_rng(0).uniform(low, high, (count, robot.n))
