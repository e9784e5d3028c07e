"""Payloads of a set as bodies: drawn, the worst ones, and what torques they need, by an arm's own regressor."""

from typing import Any

import numpy as np
from dynident.common.arrays import Array
from dynident.model import Motion, Robot, payload_regressor
from dynident.model.kernel.kernel import Kernel
from dynident.trajectories import PayloadSet
from dynident.trajectories.design.payloads import unit_point
from dynident.trajectories.simulation.simulator import parameter_vector


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
    from dynident.model import inverse_dynamics

    chi = parameter_vector(robot, robot.parameters, None)
    kernel = Kernel(inverse_dynamics(robot))
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
