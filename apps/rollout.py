"""Open loop and replay: how far predicted motion strays from measured motion, by horizon.

Simulator users accept a model by the motion it predicts over a fraction of a second from the measured torques, on a
recording that was never fitted. Small residuals do not prove that: a rotor inertia at zero leaves the torques right
and the motion wrong. Open loop alone does not prove the contrary either: where errors of the start grow fast, no
model could do better, and the replay under a controller decides.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..common import Array, InputError
from ..common.progress import each
from ..estimation import Settings, measurement
from ..estimation.fit.settings import DEFAULTS
from ..estimation.results.robot import Horizon, Rollout
from ..estimation.signals.filtering import least_speed, lowpass
from ..model import BaseParameters, Recording, Robot, base_parameters, forward_dynamics_base
from ..model.dynamics import SMOOTHING, dry_friction_names, smooth_dry_friction, stable_steps
from ..model.kernel.kernel import Kernel
from .extras import mujoco_model

HORIZONS = (0.1, 0.5, 1.0, 2.0)  # s: after which times the error is stated, unless others are asked for
IDENTIFIED, CONSTANT = "identified", "constant speed"
_STARTS = 200  # at most
_APART = 0.05  # s: between starts, at least
_SETTLING = 3.0  # periods of the cut-off at the ends of a recording that the filter does not get right
_LARGEST_END = 0.05  # of the recording
_CURVE = 40  # points of the drawn curve
_NUDGE = 1e-6  # rad or m: an error of the start whose growth is looked at
GROWTH_TIME = 0.5  # s: after which the growth of an error of the start is stated
_SEGMENT, _LEAD = 2.5, 0.5  # s: of the replay, which is made in pieces, and what its controller takes to settle
_STEP = 1e-3  # s: the longest step of the integration
_FINEST = 200  # steps per sample
_AT_ONCE = 20  # samples whose path is made at once
_STATES = 20  # of a path, at which stiffness and inertia are looked at
_BANDWIDTH = 200.0  # 1/s: of the critically damped controller that follows a path

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
        from ..trajectories.simulation import integration_step  # loads what simulations need

        n, known = robot.n, dict(zip(base.columns, values, strict=True))
        self.robot, self._chi, self._step = robot, values, Kernel(integration_step(robot, base, 0))
        self._level = np.array([known.get(name, 0.0) for name in dry_friction_names(robot)])
        x, torque = ca.SX.sym("x", n), ca.SX.sym("torque", n)
        friction = smooth_dry_friction(robot, SMOOTHING)(x, self._level)
        slopes = ca.Function("slope", [x], [ca.densify(ca.jacobian(friction, x))])
        self._friction_slopes = np.array(slopes(np.zeros(n)))
        acceleration = forward_dynamics_base(robot, base, SMOOTHING)(x, ca.SX.zeros(n), torque, values)
        self._mobility = ca.Function("mobility", [x, torque], [ca.densify(ca.jacobian(acceleration, torque))])

    def positions(self, q: Array, qd: Array, torque: Array, step: float) -> Array:
        """Positions under torques alone; see ``Predict``."""
        path = np.concatenate([np.zeros((*torque.shape[:2], 2 * self.robot.n)), torque], axis=2)
        return self._run(q, qd, path, step, np.zeros(self.robot.n))[0]

    def followed(self, q: Array, qd: Array, step: float) -> tuple[Array, Array]:
        """Positions and torques of a critically damped controller that follows paths, S x K x n."""
        inertia = np.mean(np.diagonal(np.linalg.inv(self._mobilities(q)), axis1=1, axis2=2), axis=0)
        return self._run(q[:, 0], qd[:, 0], np.concatenate([q, qd, np.zeros_like(q)], axis=2), step, inertia)

    def _run(self, q: Array, qd: Array, path: Array, step: float, inertia: Array) -> tuple[Array, Array]:
        """``path``: positions, speeds, torques beside the controller's, S x K x 3 n; no inertia, no controller."""
        from scipy.interpolate import CubicHermiteSpline, make_interp_spline

        # Steps per sample that integrate the stiffest mode stably: dry friction about rest, or the controller.
        n, samples, mobilities = self.robot.n, path.shape[1], self._mobilities(q)
        damping = self._friction_slopes + np.diag(2.0 * _BANDWIDTH * inertia)
        matrices = mobilities @ damping, mobilities @ np.diag(_BANDWIDTH**2 * inertia)
        rate, stiffness = (float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in matrices)
        count = max(1, int(np.ceil(step / _STEP - 1e-9)), stable_steps(max(rate, stiffness**0.5), step))
        if count > _FINEST:
            j = int(np.argmax(np.diagonal(matrices[0], axis1=1, axis2=2).max(axis=0))) + 1
            more = f"Identify it with a motion that accelerates joint {j} more"
            advice = f"is its rotor inertia IA{j} missing, or at its bound of zero? {more}"
            if self.robot.drives.side == "link":
                judge = "open loop judges nothing here, the torques of 'dynident identify --validate' do"
                advice = f"sensors on the link side see no rotor, and the links alone weigh too little: {judge}"
            fault = f"friction of joint {j} of {self.robot.name} is too fast to integrate ({rate:.0f} 1/s)"
            raise InputError(f"{fault}: {advice}")
        settings = np.concatenate([[step / count, 0.5 * _BANDWIDTH, 2.0 * _BANDWIDTH, 0.0], inertia, np.zeros(n)])
        positions, torques = (np.empty((len(q), samples, n)) for _ in range(2))
        x = np.hstack([q, qd, np.zeros_like(q)])
        with np.errstate(all="ignore"):  # a start that diverges ends as nan and is counted as such
            for k in range(0, samples, _AT_ONCE):
                part = np.arange(k, min(k + _AT_ONCE, samples))
                # Torques are linear between samples; positions and speeds follow Hermite's cubic: a controller as
                # stiff as this would feel the corners of a path made of straight lines.
                sampled = path[:, [*part, min(part[-1] + 1, samples - 1)]].swapaxes(0, 1)
                q_path, qd_path, torque = np.split(sampled, 3, axis=2)
                t = np.arange(len(sampled))
                fine = np.linspace(0.0, t[-1], 2 * count * t[-1] + 1)  # half steps
                along, driven = CubicHermiteSpline(t, q_path, step * qd_path), make_interp_spline(t, torque, 1)
                halves = np.concatenate([along(fine), along(fine, 1) / step, driven(fine)], axis=2)
                wanted = (halves[h : len(halves) - 2 + h : 2] for h in range(3))
                out = self._step.chain(x, *wanted, self._chi, self._level, settings).swapaxes(1, 2)
                states = np.concatenate([x[None], out[:, :, : 3 * n]])
                positions[:, part] = states[:-1:count, :, :n].swapaxes(0, 1)
                torques[:, part] = out[::count, :, 3 * n : 4 * n].swapaxes(0, 1)
                x = states[-1]
        return positions, torques

    def _mobilities(self, q: Array) -> Array:
        """Inverses of the inertia matrix at some states of paths S x K x n, states x n x n."""
        n, states = self.robot.n, q.reshape(-1, self.robot.n)
        picked = states[np.linspace(0, len(states) - 1, min(_STATES, len(states))).astype(int)]
        mobilities = np.array([np.array(self._mobility(state, np.zeros(n))) for state in picked])
        if not (np.linalg.eigvalsh(0.5 * (mobilities + mobilities.swapaxes(1, 2))) > 0.0).all():
            fault = f"the parameters of {self.robot.name} are of no robot that can move"
            advice = "Identify with --constrained prior, or over a motion that excites it more"
            raise InputError(f"{fault}: its inertia matrix is not positive definite. {advice}")
        return mobilities


def mujoco_arm(path: str | Path, robot: Robot) -> Predict:
    """Make a prediction by MJCF or URDF; the model's first n joints are taken for the robot's, in order."""
    mujoco, model = mujoco_model(path)
    if model.nv != robot.n:
        fault = f"has {model.nv} degrees of freedom, {robot.name} has {robot.n}"
        raise InputError(f"{path} {fault}: give a model of the arm alone, fixed to the ground")
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


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of predicted motion on one recording, from every start."""

    turning: bool  # all joints turn: errors are in rad then, else mixed with m
    times: Array  # after the start [s], shape (K,), the horizons among them
    by: Mapping[str, Array]  # model -> root mean square over the joints of each start at each time, S x K
    resting: NDArray[np.bool_]  # starts at which no joint moved, shape (S,)

    def spread(self, model: str, seconds: float, resting: bool = False) -> tuple[float, float] | None:
        """Error of a model after one of ``times``, median and 90 % of the starts; None without such starts."""
        errors = np.sort(self.by[model][self.resting == resting, int(np.argmin(np.abs(self.times - seconds)))])
        last = len(errors) - 1
        return (float(errors[int(0.5 * last)]), float(errors[int(0.9 * last)])) if len(errors) else None

    def spreads(self, seconds: float, resting: bool = False) -> dict[str, tuple[float, float]]:
        """Errors of every model by its name; empty without such starts."""
        every = {model: self.spread(model, seconds, resting) for model in self.by}
        return {model: spread for model, spread in every.items() if spread is not None}


def roll_out_all(
    robot: Robot,
    values: Array,
    recordings: Sequence[Recording],
    settings: Settings = DEFAULTS,
    horizons: Sequence[float] = HORIZONS,
    others: Mapping[str, Predict] | None = None,
) -> tuple[Rollout, ...]:
    """Predict each recording's motion from its torques, from many starts, and follow its path.

    Args:
        values: of the columns of ``base_parameters(robot)``.
        recordings: without payload, best such that were not fitted.
        settings: processing and progress.
        horizons: after which times errors are asked for [s]; those beyond half a recording are left out.
        others: models to compare with, by name.
    """
    settings.progress("the robot's equations of motion")
    base = base_parameters(robot)
    if len(values) != len(base.columns):
        advice = "give the robot as it was identified (Identification.robot), for its recordings chose its friction"
        raise InputError(f"{len(values)} values for {len(base.columns)} base parameters: {advice}")
    arm = IdentifiedArm(robot, base, values)
    models, processing = {IDENTIFIED: arm.positions, **(others or {})}, settings.processing_of(robot)
    rollouts = []
    for recording in recordings:
        measured = measurement(recording, processing)
        motion, step = measured.motion, float(measured.motion.t[1] - measured.motion.t[0])
        duration = step * (len(motion.t) - 1)
        lengths = [seconds for seconds in sorted(horizons) if seconds <= 0.5 * duration]
        if not lengths:
            fault = f"{duration:.3g} s are too short for a horizon of {min(horizons):g} s"
            raise InputError(f"{recording.source}: {fault}: record at least twice the horizon")
        count = round(lengths[-1] / step) + 1
        curve = np.linspace(0.0, lengths[-1], _CURVE + 1)[1:]
        samples = np.unique(np.clip(np.rint(np.concatenate([curve, lengths]) / step).astype(int), 1, count - 1))
        # Away from the ends, which the filter does not get right.
        size, cutoff = len(motion.t), processing.cutoff
        edge = min(round(_SETTLING / cutoff / step), int(_LARGEST_END * size)) if cutoff else 0
        last = size - count - edge
        number = min(_STARTS, max(1, int((last - edge) * step / _APART)))
        starts = np.linspace(edge, max(last, edge), number).astype(np.intp)
        q, qd, torque = motion.q[starts], motion.qd[starts], measured.torque[starts[:, None] + np.arange(count)]
        truth = motion.q[starts[:, None] + samples]
        label = partial("{}: {}".format, recording.source)
        names = each(list(models), label, settings.progress)
        predicted = {name: models[name](q, qd, torque, step)[:, samples] for name in names}
        predicted[CONSTANT] = q[:, None] + qd[:, None] * (step * samples)[:, None]
        with np.errstate(all="ignore"):
            rms = {name: np.sqrt(np.mean(np.square(x - truth), axis=2)) for name, x in predicted.items()}
        by = {name: np.nan_to_num(x, nan=np.inf, posinf=np.inf) for name, x in rms.items()}  # some starts run away
        resting = np.max(np.abs(qd), axis=1) < processing.still_speed
        settings.progress(f"{recording.source}: growth of errors, replay")
        growth, until = float("nan"), round(GROWTH_TIME / step) + 1
        if until <= count:  # the direction of the error is drawn, its seed fixed
            nudge = np.random.default_rng(0).standard_normal(q.shape)
            nudge *= _NUDGE / np.linalg.norm(nudge, axis=1, keepdims=True)
            ends = [arm.positions(start, qd, torque[:, :until], step)[:, -1] for start in (q, q + nudge)]
            with np.errstate(all="ignore"):
                grown = np.linalg.norm(ends[1] - ends[0], axis=1) / _NUDGE
            growth = float(np.median(np.nan_to_num(grown, nan=np.inf, posinf=np.inf)))
        # Replay: the path is followed in overlapping pieces, all at once; torques are compared below the cut-off.
        lead = min(round(_LEAD / step), size // 4)
        length = min(round(_SEGMENT / step), size - lead)
        pieces = max(1, (size - lead) // length)
        windows = length * np.arange(pieces)[:, None] + np.arange(lead + length)
        # A stiff controller would feel speeds that are not the slopes of the positions.
        path, followed = arm.followed(motion.q[windows], np.gradient(motion.q, step, axis=0)[windows], step)
        joined, speeds = slice(lead, lead + pieces * length), np.abs(motion.qd)
        fast = speeds[joined] >= least_speed(speeds.max(axis=0), processing)
        torques = measured.torque[joined], followed[:, lead:].reshape(-1, robot.n)
        torque, replayed = (np.where(fast, lowpass(x, step, cutoff, recording.source), 0.0) for x in torques)
        missed, norms = np.linalg.norm(replayed - torque, axis=0), np.linalg.norm(torque, axis=0)
        with np.errstate(all="ignore"):
            joints = np.where(norms > 0.0, missed / norms, np.nan)
            relative = float(np.linalg.norm(missed) / np.linalg.norm(norms))
        errors = Errors(all(joint.revolute for joint in arm.robot.joints), step * samples, by, resting)
        told = Rollout(
            source=recording.source,
            starts_in_motion=int((~resting).sum()),
            starts_at_rest=int(resting.sum()),
            diverged=int((~np.isfinite(by[IDENTIFIED][:, -1])).sum()),
            horizons=tuple(Horizon(t, errors.spreads(t) or None, errors.spreads(t, True) or None) for t in lengths),
            growth=growth,
            replay_relative=relative,
            replay_joints=joints,
            replay_strayed=float(np.sqrt(np.mean(np.square((path - motion.q[windows])[:, lead:])))),
        )
        rollouts.append(told.made_by(errors))
    return tuple(rollouts)
