"""Arms that move under recorded torques: a robot of given base parameters, or a user's model in MuJoCo."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import BaseParameters, Robot, forward_dynamics_base
from ...model.dynamics import SMOOTHING, dry_friction_names, runge_kutta, smooth_dry_friction, stable_steps
from ...model.kernel.kernel import Kernel
from ..extras import extra

_STEP = 1e-3
"""s: the longest step of the integration."""
_FINEST = 200  # steps per sample
_AT_ONCE = 20  # samples whose path is made at once
_STATES = 20  # of a path, at which stiffness and inertia are looked at
_BANDWIDTH = 200.0
"""1/s: of the critically damped controller that follows a path."""


Predict = Callable[[Array, Array, Array, float], Array]
"""Positions under torques alone, S x K x n for S starts.

Of positions and speeds at the start, S x n, torques at each of K samples, linear between them, S x K x n, and the
time between samples [s].
"""


class IdentifiedArm:
    """Integrates M(q) qdd = Gamma - h(q, qd) of base parameters for many starts at once.

    Dry friction is FS tanh(qd / w), w = ``SMOOTHING``: a simulator's joints creep where a robot's would stick.
    """

    def __init__(self, robot: Robot, base: BaseParameters, values: Array) -> None:
        """Prepare the integration; ``values``: of ``base.columns``."""
        self.robot, self._base, n = robot, base, robot.n
        dry = dry_friction_names(robot)
        self._level = np.array([values[base.columns.index(name)] if name in base.columns else 0.0 for name in dry])
        self._chi, self._friction = values, smooth_dry_friction(robot, SMOOTHING)
        self._forward = forward_dynamics_base(robot, base, SMOOTHING)
        self._step = Kernel(self._integration_step(n))

    def _integration_step(self, n: int) -> ca.Function:
        """``step(x, start, middle, end, shared)`` to x after the step, then the torque at its start, 3 n x 1.

        x holds q and qd; start, middle and end hold torque, position and speed of the path; shared the parameters,
        gains of position and speed, and the step.
        """
        x = ca.SX.sym("x", 2 * n)
        start, middle, end = (ca.SX.sym(name, 3 * n) for name in ("start", "middle", "end"))
        shared = ca.SX.sym("shared", len(self._chi) + 2 * n + 1)
        chi, kp, kd, h = ca.vertsplit(shared, np.cumsum([0, len(self._chi), n, n, 1]).tolist())

        def torque_of(x: ca.SX, path: ca.SX) -> ca.SX:
            q, qd = ca.vertsplit(x, n)
            torque, along, speed = ca.vertsplit(path, n)
            return torque + kp * (along - q) + kd * (speed - qd)

        def slope(x: ca.SX, path: ca.SX) -> ca.SX:
            q, qd = ca.vertsplit(x, n)
            return ca.vertcat(qd, self._forward(q, qd, torque_of(x, path), chi))

        after = runge_kutta(slope, x, h, (start, middle, end))
        out = ca.cse(ca.densify(ca.vertcat(after, torque_of(x, start))))
        return ca.Function("rollout_step", [x, start, middle, end, shared], [out])

    def positions(self, q: Array, qd: Array, torque: Array, step: float) -> Array:
        """Positions under torques alone; see ``Predict``."""
        path = np.concatenate([torque, np.zeros((*torque.shape[:2], 2 * self.robot.n))], axis=2)
        none = np.zeros(self.robot.n)
        positions, _ = self._run(q, qd, path, step, none, none)
        return positions

    def followed(self, q: Array, qd: Array, step: float) -> tuple[Array, Array]:
        """Positions and torques of a controller kp (q_r - q) + kd (qd_r - qd) that follows paths, S x K x n."""
        inertia = np.mean([np.diag(np.linalg.inv(mobility)) for mobility in self._mobilities(q)], axis=0)
        path = np.concatenate([np.zeros_like(q), q, qd], axis=2)
        gains = _BANDWIDTH**2 * inertia, 2.0 * _BANDWIDTH * inertia
        return self._run(q[:, 0], qd[:, 0], path, step, *gains)

    def _run(self, q: Array, qd: Array, path: Array, step: float, kp: Array, kd: Array) -> tuple[Array, Array]:
        count = self._steps(q, kp, kd, step)
        shared = np.concatenate([self._chi, kp, kd, [step / count]])
        n, samples = self.robot.n, path.shape[1]
        positions, torques = (np.empty((len(q), samples, n)) for _ in range(2))
        x = np.hstack([q, qd])
        with np.errstate(all="ignore"):  # a start that diverges ends as nan and is counted as such
            for k in range(0, samples, _AT_ONCE):
                part = np.arange(k, min(k + _AT_ONCE, samples))
                halves = _half_steps(path[:, [*part, min(part[-1] + 1, samples - 1)]], 2 * count, step)
                out = self._step.chain(
                    x, *(halves[h : len(halves) - 2 + h : 2] for h in range(3)), shared
                ).swapaxes(1, 2)
                states = np.concatenate([x[None], out[:, :, : 2 * n]])
                positions[:, part] = states[:-1:count, :, :n].swapaxes(0, 1)
                torques[:, part] = out[::count, :, 2 * n :].swapaxes(0, 1)
                x = states[-1]
        return positions, torques

    def _steps(self, q: Array, kp: Array, kd: Array, step: float) -> int:
        """Steps per sample that integrate the stiffest mode stably: dry friction about rest, or the controller."""
        n, mobilities = self.robot.n, self._mobilities(q)
        speed = ca.SX.sym("qd", n)
        slope = ca.jacobian(self._friction(speed, self._level), speed)
        damping = np.array(ca.Function("slope", [speed], [ca.densify(slope)])(np.zeros(n))) + np.diag(kd)
        rate = max(np.abs(np.linalg.eigvals(mobility @ damping)).max() for mobility in mobilities)
        spring = max(np.abs(np.linalg.eigvals(mobility @ np.diag(kp))).max() ** 0.5 for mobility in mobilities)
        count = max(1, int(np.ceil(step / _STEP - 1e-9)), stable_steps(max(rate, spring), step))
        if count > _FINEST:
            j = int(np.argmax(np.max([np.diag(m @ damping) for m in mobilities], axis=0))) + 1
            advice = (
                f"is its rotor inertia IA{j} missing, or at its bound of zero? Identify it with a motion that "
                f"accelerates joint {j} more"
            )
            if self.robot.drives.side == "link":
                advice = (
                    "sensors on the link side see no rotor, and the links alone weigh too little: open loop "
                    "judges nothing here, the torques of 'dynident identify --validate' do"
                )
            fault = f"friction of joint {j} of {self.robot.name} is too fast to integrate ({rate:.0f} 1/s)"
            raise InputError(f"{fault}: {advice}")
        return count

    def _mobilities(self, q: Array) -> list[Array]:
        """Inverses of the inertia matrix at some states of paths S x K x n, n x n each."""
        n, mobilities = self.robot.n, list[Array]()
        states, none = q.reshape(-1, n), np.zeros(n)
        for state in states[np.linspace(0, len(states) - 1, min(_STATES, len(states))).astype(int)]:
            torques = (none, *np.eye(n))
            rest, *moved = (np.array(self._forward(state, none, torque, self._chi)).ravel() for torque in torques)
            mobility = np.column_stack(moved) - rest[:, None]
            if not np.linalg.eigvalsh(0.5 * (mobility + mobility.T))[0] > 0.0:
                raise InputError(
                    f"the parameters of {self.robot.name} are of no robot that can move: its inertia matrix is not "
                    "positive definite. Identify with --constrained prior, or over a motion that excites it more"
                )
            mobilities.append(mobility)
        return mobilities


def _half_steps(path: Array, count: int, step: float) -> Array:
    """A path of M + 1 samples, S x (M + 1) x 3 n, ``count`` times a sample and at the end: (M count + 1) x S x 3 n.

    Torques are linear; positions and speeds follow Hermite's cubic: a controller as stiff as this would feel the
    corners of a path made of straight lines.
    """
    from scipy.interpolate import CubicHermiteSpline, make_interp_spline

    torque, q, qd = np.split(path.swapaxes(0, 1), 3, axis=2)
    t = np.arange(len(q))
    fine, along = np.linspace(0.0, t[-1], count * t[-1] + 1), CubicHermiteSpline(t, q, step * qd)
    return np.concatenate([make_interp_spline(t, torque, 1)(fine), along(fine), along(fine, 1) / step], axis=2)


def mujoco_arm(path: str | Path, robot: Robot) -> Predict:
    """Make a prediction by MJCF or URDF; the model's first n joints are taken for the robot's, in order."""
    mujoco = extra("mujoco", f"{path}: to move it needs MuJoCo: pip install 'dynident[simulators]'")
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    try:
        model: Any = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo cannot read it: {error}") from None
    if model.nv != robot.n:
        raise InputError(
            f"{path} has {model.nv} degrees of freedom, {robot.name} has {robot.n}: give a model of the arm alone, "
            "fixed to the ground"
        )
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)

    def positions(q: Array, qd: Array, torque: Array, step: float) -> Array:
        count = max(1, int(np.ceil(step / _STEP - 1e-9)))
        model.opt.timestep = step / count
        result = np.empty_like(torque)
        for start in range(len(q)):
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = q[start], qd[start]
            for k in range(torque.shape[1]):
                result[start, k] = data.qpos
                here, after = torque[start, k], torque[start, min(k + 1, torque.shape[1] - 1)]
                for part in range(count):
                    data.qfrc_applied[:] = here + (part + 0.5) / count * (after - here)
                    mujoco.mj_step(model, data)
        return result

    return positions
