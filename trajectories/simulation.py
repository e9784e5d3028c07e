"""Simulated recordings of a robot with known parameters: exact ones, and those of a robot under its controller.

Every level of what disturbs them is a parameter, every draw is by a seed. The controller has a position and a speed
loop in cascade, with feed-forward; many runs go side by side in a batch.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from ..common import Array, Brief, InputError
from ..common.recursion import filtered
from ..model import BaseParameters, InertialParameters, Motion, Recording, Robot, base_parameters, dynamics
from ..model.kernel.kernel import Kernel
from ..model.motion import Measurement
from ..model.stand_in import completed, poses_in_range, rotor_inertias
from .motions.family import Plan, sample_count

_AFTER_DECIMATION = 0.28  # of white noise at 250 Hz, through the filter of a decimation by 10
_ROBOT, _RUN, _RECORDING = 0, 1, 2  # what a random stream belongs to
_POSES, _STIFF = 200, 20  # over which a joint's inertia is averaged, and of them those that show the stiffest mode
_TIMES = 2000  # of each reference, at which a payload's torque is looked at
_FEWEST, _FINEST = 4, 200  # steps of integration per sample
_SETTLE = 1.0  # s before a run starts, in which the loops take up the load
_CHUNK = 50  # samples whose references are computed at once
_LOST = 0.5  # rad or m from the reference: the controller has lost the robot

RX90_NOISE = (24.0, 30.0, 10.8, 5.1, 6.6, 2.3)
"""White torque noise per joint at 250 Hz [N·m] that leaves residuals like those behind the paper's Table 2."""


@lru_cache(maxsize=16)
def _torque_code(robot: Robot) -> Kernel:
    return Kernel(dynamics.inverse_dynamics(robot))


@dataclass(frozen=True, repr=False)
class Simulator(Brief):
    """Simulates recordings by the inverse dynamics of one robot with known parameters.

    Attributes:
        robot: by its description; what that lacks is completed ``with_stand_in``, and a warning says by what.

    Raises:
        InputError: if the robot's description lacks standard parameters that nothing stands in for.

    >>> motion = random_via_points(robot, count=8, seed=0).motion(rate=100.0)
    >>> Simulator(robot).record(motion, body).torque.shape == motion.q.shape
    True
    """

    robot: Robot

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", completed(self.robot, limits=False, frames=4))

    def measure(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> Measurement:
        """Compute exact joint torques [N·m or N] on a motion; ``parameters``: of a twin, else the robot's own."""
        chi, kernel = self.robot.chi(parameters, payload), _torque_code(self.robot)
        torque = np.zeros(motion.q.shape)
        torque[:, kernel.rows] = kernel(motion.q, motion.qd, motion.qdd, chi).T
        return Measurement(motion, torque)

    def record(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        noise: Array | Sequence[float] | None = None,
        seed: int | Sequence[int] = 0,
        source: str = "simulated",
        parameters: Mapping[str, float] | None = None,
    ) -> Recording:
        """Record positions and torques on a motion, torques with white noise and to an exact scale.

        Args:
            payload: fixed to the last link, given in the robot's payload frame.
            noise: standard deviation of the torque noise per joint [N·m or N]; None for none.
            source: name of the recording.
            parameters: of a twin of the robot; the robot's own by default.
        """
        torque = np.array(self.measure(motion, payload, parameters).torque)
        if noise is not None:
            torque += np.asarray(noise) * np.random.default_rng(seed).standard_normal(torque.shape)
        return Recording(motion.t, motion.q, torque, None, source, gain_sigma=0.0)


@dataclass(frozen=True, eq=False, repr=False)
class Disturbances(Brief):
    """Levels of all that stands between a robot's model and its recordings.

    Ripple and the level of dry friction act on the moving robot; the rest on what its controller writes down.

    Attributes:
        white: standard deviation of each joint's torque noise, independent from sample to sample [N·m or N].
        slow: standard deviation of a torque noise with exponential memory [N·m or N].
        slow_memory: its correlation time [s].
        ripple: amplitude of a torque [N·m or N], periodic in the joint's position for each of ``waves`` alike.
        waves: periods per turn [1 per 2 pi rad or 2 pi m].
        friction: standard deviation of the level of dry friction, relative to its mean.
        friction_memory: correlation time of the level [s].
        encoder: step of the recorded positions [rad or m].
        gain_error: standard deviation of the joints' drive gains, relative.
    """

    white: tuple[float, ...]
    slow: tuple[float, ...]
    ripple: tuple[float, ...]
    slow_memory: float = 0.8
    waves: tuple[int, ...] = (8, 36)
    friction: float = 0.0
    friction_memory: float = 2.0
    encoder: float = 0.0
    gain_error: float = 0.0

    def __post_init__(self) -> None:
        if not len(self.white) == len(self.slow) == len(self.ripple):
            raise ValueError("white, slow and ripple need one number per joint")
        levels = (*self.white, *self.slow, *self.ripple, self.friction, self.encoder, self.gain_error)
        if not all(0.0 <= level < np.inf for level in levels):
            raise ValueError("a level must not be negative")
        if not (self.slow_memory > 0.0 and self.friction_memory > 0.0 and all(wave > 0 for wave in self.waves)):
            raise ValueError("memories and waves must be positive")


def no_disturbances(n: int) -> Disturbances:
    """Make levels of zero: recordings exactly as the robot moves."""
    return Disturbances(*((0.0,) * n,) * 3)


_RX90 = (16.9, 29.7, 9.4, 4.66, 6.07, 2.74)  # N·m: white noise
RX90_DISTURBANCES = Disturbances(_RX90, (0.0,) * 6, (1.7, 2.7, 0.95, 0.46, 0.54, 0.24), friction=0.12, encoder=1e-5)
"""Make levels as noisy as the paper's robot: (17)-(19) come out like Table 2's.

Its printed deviations need a relative residual of 7 to 8 % in all and of 20 to 25 % on joints 5 and 6: residuals of
4 to 5 % would give deviations that are too small, both cannot be had. How the residual is shared out between white
noise, ripple and friction is not published; it is assumed here, as are the encoder's step and the ripple's waves.
"""

RX90_SLOW_NOISE = replace(RX90_DISTURBANCES, white=(0.0,) * 6, slow=tuple(_AFTER_DECIMATION * x for x in _RX90))
"""Make the paper's levels with noise that remembers 0.8 s instead of white noise.

Residuals are as large as those of white noise at 250 Hz after decimation by 10, but say far less about the robot.
"""


def remembered_disturbances(noise: Array, rate: float) -> Disturbances:
    """Make levels as a design assumes them: ``noise`` [N·m or N], (n,), that remembers half of 1/``rate`` [s]."""
    none = (0.0,) * len(noise)
    return Disturbances(none, tuple(noise.tolist()), none, slow_memory=0.5 / rate, encoder=1e-5)


def relative_disturbances(torque: Array, share: float) -> Disturbances:
    """Make levels of the joints' rms torque, (n,): the fraction ``share`` white, half of it ripple and friction."""
    joints = tuple(float(x) for x in share * torque)
    half, none = tuple(0.5 * x for x in joints), (0.0,) * len(joints)
    return Disturbances(joints, none, half, friction=0.5 * share, encoder=1e-5)


def draw_robot_errors(disturbances: Disturbances, seed: int) -> tuple[Array, Array]:
    """Draw the ripple's phases [rad], n x waves, and the drives' gains, (n,), alike in all recordings."""
    draw, n = np.random.default_rng([seed, _ROBOT]), len(disturbances.white)
    phases = draw.uniform(-np.pi, np.pi, (n, len(disturbances.waves)))
    return phases, 1.0 + disturbances.gain_error * draw.standard_normal(n)


def draw_friction(robot: Robot, disturbances: Disturbances, count: int, rate: float, seed: Sequence[int]) -> Array:
    """Draw dry friction of one run, one row a sample [N·m or N], columns as ``dry_friction_names``."""
    names = dynamics.dry_friction_names(robot)
    mean = np.array([robot.parameters[name] for name in names])
    draw = np.random.default_rng([*seed, _RUN])
    change = _exponential(draw, (count, len(names)), disturbances.friction_memory * rate)
    return np.asarray(mean * np.maximum(1.0 + disturbances.friction * change, 0.0))


def record(
    exact: Measurement, disturbances: Disturbances, gains: Array, seed: Sequence[int], source: str = "simulated"
) -> Recording:
    """Record a motion and its motor torques as controllers do; ``gains``: measured over true torque, (n,)."""
    motion, torque, step = exact.motion, exact.torque, disturbances.encoder
    draw = np.random.default_rng([*seed, _RECORDING])
    noise = disturbances.white * draw.standard_normal(torque.shape)
    noise += disturbances.slow * _exponential(draw, torque.shape, disturbances.slow_memory * motion.rate)
    q = step * np.round(motion.q / step) if step > 0.0 else motion.q
    return Recording(motion.t, q, gains * torque + noise, None, source, gain_sigma=disturbances.gain_error)


def _exponential(draw: np.random.Generator, shape: tuple[int, ...], memory: float) -> Array:
    """Draw noise of unit variance whose correlation falls by e in ``memory`` samples, column by column."""
    # A first-order autoregression, its first sample of the same variance as all others.
    decay = float(np.exp(-1.0 / memory))
    fresh = draw.standard_normal(shape)
    fresh[1:] *= np.sqrt(1.0 - decay**2)
    return filtered([(1.0, 0.0, 0.0, -decay, 0.0)], fresh, np.zeros(shape[1]))


@dataclass(frozen=True)
class Controller:
    """Gains of a joint's loops; torques are these times the joint's mean inertia.

    motor torque = J (kv (v - qd) + ki z) + feed-forward, with v = qd_r + kp (q_r - q) and z' = v - qd.

    The feed-forward is the model's torque on the reference motion: the unloaded robot's, without dry friction, for
    a controller knows neither the payload nor how stiff the gears are today. Without an integral nothing takes up
    what the payload adds: the arm sags until the position error holds it, by its torque / (J kp kv). The loops see
    exact positions and speeds: an encoder's step of 1e-5 rad changes the torque far less than the recorded noise.

    Attributes:
        position: kp [1/s].
        speed: kv [1/s].
        integral: ki [1/s^2].
        feed_forward: fraction of the model's torque that is fed forward.
        compensates: whether that is the torque of the whole motion, or only what holds the reference pose at rest.
        rate: samples a second that it records [Hz].
    """

    position: float = 100.0
    speed: float = 450.0
    integral: float = 30000.0
    feed_forward: float = 1.0
    compensates: Literal["motion", "gravity"] = "motion"
    rate: float = 250.0

    def __post_init__(self) -> None:
        if not (self.position > 0.0 and self.speed > 0.0 and self.integral >= 0.0):
            raise ValueError("position and speed gains must be positive, the integral gain not negative")
        if self.compensates not in ("motion", "gravity"):
            raise ValueError(f"compensates must be 'motion' or 'gravity', got {self.compensates!r}")

    def sagging(
        self, robot: Robot, payload: InertialParameters, references: Sequence[Plan], sag: float
    ) -> "Controller":
        """Weaken the loop until a payload pulls the arm off its path by as much as asked for.

        Args:
            payload: given in the robot's payload frame.
            references: the motions on which that shall be so.
            sag: of the joint that gives way most, root mean square over all of them [rad or m].

        Raises:
            InputError: if the loops have an integral, which takes every sag up.
        """
        if self.integral > 0.0:
            raise InputError("a controller with integral action does not sag: choose one without")
        if not sag > 0.0:
            raise InputError(f"a sag of {sag:g} rad: give a positive one")
        simulator, differences = Simulator(robot), []
        for reference in references:
            t = np.linspace(0.0, reference.duration, _TIMES)
            loaded, bare = (simulator.measure(Motion(t, *reference.at(t)), body) for body in (payload, None))
            differences.append(loaded.torque - bare.torque)
        inertia = np.diagonal(inertia_matrices(robot), axis1=1, axis2=2).mean(axis=0)
        acceleration = np.sqrt(np.mean(np.concatenate(differences) ** 2, axis=0)) / inertia
        ratio = np.sqrt(float(acceleration.max()) / sag / (self.position * self.speed))
        return replace(self, position=ratio * self.position, speed=ratio * self.speed)


CONTROLLERS = {
    "integral": Controller(),
    "proportional": Controller(integral=0.0),
    "gravity": Controller(integral=0.0, compensates="gravity"),
}
"""Controllers: loops of most industrial arms; without integral action; and those that know gravity alone."""


class Task(NamedTuple):
    """Run to be simulated; its recording takes its name.

    Attributes:
        reference: what the robot is to do.
        payload: fixed to the last link, in the robot's payload frame.
    """

    name: str
    reference: Plan
    payload: InertialParameters | None = None


def integration_step(robot: Robot, base: BaseParameters, waves: int) -> ca.Function:
    """``step(x, wanted, wanted_middle, wanted_end, chi, level, settings)`` by the classical Runge-Kutta method.

    x holds q, qd and the controller's integral z; the three wanted hold q_r, qd_r and the feed-forward torque at
    the start, middle and end of the step; chi the base parameters with dry friction zero; level the dry friction;
    settings the step [s], kp, kv, ki, the controller's inertia, and the ripple's amplitudes, waves and phases: the
    code of a robot is compiled once. It gives x after the step, then motor torque and acceleration at its start.
    """
    n, dry = robot.n, dynamics.dry_friction_names(robot)
    forward = dynamics.forward_dynamics_base(robot, base, dynamics.SMOOTHING)
    x, reference = ca.SX.sym("x", 3 * n), [ca.SX.sym(f"wanted{k}", 3 * n) for k in range(3)]
    chi, level = ca.SX.sym("chi", len(base.columns)), ca.SX.sym("level", len(dry))
    ends = np.cumsum([0, 1, 1, 1, 1, n, n, waves, n * waves]).tolist()
    settings = ca.SX.sym("settings", ends[-1])
    h, kp, kv, ki, J, amplitude, w, phases = ca.vertsplit(settings, ends)
    own = ca.SX(chi)
    apart = [k for k, name in enumerate(dry) if name in base.columns]  # the others are grouped, as constant
    own[[base.columns.index(dry[k]) for k in apart]] = level[apart]

    def slope(x: ca.SX, reference: ca.SX) -> tuple[ca.SX, ca.SX]:
        (q, qd, z), (q_r, qd_r, feed_forward) = ca.vertsplit(x, n), ca.vertsplit(reference, n)
        error = qd_r + kp * (q_r - q) - qd
        torque = J * (kv * error + ki * z) + feed_forward
        ripple = sum(amplitude * ca.sin(w[k] * q + phases[k * n : (k + 1) * n]) for k in range(waves))
        return ca.vertcat(qd, forward(q, qd, torque + ripple, own), error), torque

    (start, middle, end), (at_start, torque) = reference, slope(x, reference[0])
    after = dynamics.runge_kutta(lambda x, reference: slope(x, reference)[0], x, h, (start, middle, end))
    out = ca.cse(ca.densify(ca.vertcat(after, torque, at_start[n : 2 * n])))
    return ca.Function("step", [x, *reference, chi, level, settings], [out])


def inertia_matrices(robot: Robot) -> Array:
    """Inertia matrices [kg m^2 or kg], K x n x n, in random poses of the joints' ranges."""
    A, chi = dynamics.mass_matrix(robot), robot.chi()
    return np.array([np.array(A(q, chi)) for q in poses_in_range(robot, _POSES)])


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedRun(Brief):
    """Simulated run: what was recorded, and what is known of it."""

    task: Task
    recording: Recording
    exact: Measurement  # the motion and the motor torques without errors of measurement
    friction: dict[str, float]  # dry friction averaged over the motion, by parameter [N·m or N]
    tracking_error: Array  # largest distance from the reference, per joint [rad or m]


@dataclass(frozen=True, eq=False, repr=False)
class Experiment(Brief):
    """Runs of one robot with what disturbs it.

    Attributes:
        robot: the robot; its parameters are the truth, dry friction on average over all times.
        phases, gains: of the ripple and of the drives, as ``draw_robot_errors`` gives them by ``seed``.
        runs: in the order of the tasks.
    """

    robot: Robot
    disturbances: Disturbances
    phases: Array
    gains: Array
    seed: int
    runs: tuple[SimulatedRun, ...]

    def again(self, disturbances: Disturbances) -> "Experiment":
        """Record the same runs again with other errors of measurement.

        Raises:
            ValueError: if the robot itself would move otherwise.
        """
        for name in ("ripple", "waves", "friction", "friction_memory"):
            if getattr(self.disturbances, name) != getattr(disturbances, name):
                raise ValueError(f"{name} acts on the moving robot: simulate again")
        (phases, gains), runs = draw_robot_errors(disturbances, self.seed), list[SimulatedRun]()
        for k, run in enumerate(self.runs):
            again = record(run.exact, disturbances, gains, [self.seed, k], run.task.name)
            runs.append(replace(run, recording=again))
        return replace(self, disturbances=disturbances, phases=phases, gains=gains, runs=tuple(runs))


def run_experiment(
    robot: Robot,
    tasks: Sequence[Task],
    disturbances: Disturbances,
    seed: int = 0,
    controller: Controller | None = None,
    progress: Callable[[float], None] | None = None,
) -> Experiment:
    """Simulate a robot, its controller and its gears in all tasks side by side, and record them.

    Dry friction is drawn by the disturbances; no task has an effect on another. ``seed``: the same seed gives the
    same recordings.

    Raises:
        InputError: if parameters are missing, the robot cannot move, friction is too fast to integrate, or the
            controller loses the robot.
    """
    robot, controller = completed(robot, limits=False), controller or Controller()
    phases, gains = draw_robot_errors(disturbances, seed)
    n, rate, plant, rotors = robot.n, controller.rate, robot, np.zeros(robot.n)
    if robot.drives.side == "link":
        # Sensors behind the gears see no rotor, but the arm turns them.
        rotors = rotor_inertias(robot, robot.parameters)
        own = {f"IA{number}": inertia for number, inertia in enumerate(rotors.tolist(), start=1)}
        drives = replace(robot.drives, side="motor", rotor_inertia=True)
        plant = replace(robot, drives=drives, parameters={**robot.parameters, **own})
    base, dry, matrices = base_parameters(plant), dynamics.dry_friction_names(plant), inertia_matrices(plant)
    inertia = np.diagonal(matrices, axis1=1, axis2=2).mean(axis=0)
    # So many steps a sample integrate the stiffest mode, dry friction about rest, stably.
    dry_torque, speeds = dynamics.smooth_dry_friction(plant, dynamics.SMOOTHING), ca.SX.sym("qd", n)
    resisting = dry_torque(speeds, [plant.parameters[name] for name in dry])
    slope = ca.Function("slope", [speeds], [ca.densify(ca.jacobian(resisting, speeds))])
    damping = np.array(slope(0.0)) + np.diag(inertia * (controller.speed + controller.position))
    if np.linalg.eigvalsh(matrices[:_STIFF]).min() <= 0.0:
        fault = "its parameters give an inertia matrix that is not positive definite"
        raise InputError(f"robot {robot.name!r} cannot move: {fault}: correct the inertias in its description")
    # Rates of A qdd = -D qd: the eigenvalues of A^-1 D.
    fastest = float(np.abs(np.linalg.eigvals(np.linalg.inv(matrices[:_STIFF]) @ damping)).max())
    steps = max(_FEWEST, dynamics.stable_steps(fastest, 1.0 / rate))
    if steps > _FINEST:
        fault = f"robot {robot.name!r}: friction about rest has a rate of {fastest:.0f} 1/s, too fast to integrate"
        raise InputError(f"{fault}: are its rotor inertias (IA) missing?")
    loop = [1.0 / (rate * steps), controller.position, controller.speed, controller.integral]
    settings = np.concatenate([loop, inertia, disturbances.ripple, disturbances.waves, phases.T.ravel()])
    step = Kernel(integration_step(plant, base, len(disturbances.waves)))
    model_torque = Kernel(dynamics.inverse_dynamics_base(plant, base))
    bodies = (None, *(task.payload for task in tasks))
    values = (dict(zip(plant.standard, plant.chi(payload=body), strict=True)) for body in bodies)
    bare, *loads = (base.value(of_body | dict.fromkeys(dry, 0.0)) for of_body in values)
    loaded = np.array(loads)
    halves, moving = 2 * steps, float(controller.compensates == "motion")
    counts = [sample_count(task.reference.duration, rate) for task in tasks]
    frictions = [draw_friction(robot, disturbances, count, rate, [seed, k]) for k, count in enumerate(counts)]
    state = np.zeros((len(tasks), 3 * n))
    state[:, :n] = [task.reference.at(np.zeros(1))[0][0] for task in tasks]
    before = round(_SETTLE * rate)
    log = np.zeros((before + max(counts), len(tasks), 5 * n))  # q, qd, torque, qdd, reference
    for start in range(0, len(log), _CHUNK):
        # Runs that have not ended go on for some samples.
        stop = min(start + _CHUNK, len(log))
        active = [k for k, count in enumerate(counts) if before + count > start]
        # Positions, speeds and feed-forward at every half step.
        t = np.arange((start - before) * halves, (stop - before) * halves + 1) / (rate * halves)
        known = dict[int, Array]()  # once for runs on the same reference
        for plan in {id(tasks[k].reference): tasks[k].reference for k in active}.values():
            q, qd, qdd = plan.at(t)
            torque = model_torque(q, moving * qd, moving * qdd, bare).T
            known[id(plan)] = np.hstack([q, qd, controller.feed_forward * torque])
        reference = np.stack([known[id(tasks[k].reference)] for k in active], axis=1)
        wanted = (reference[k : len(reference) - 2 + k : 2] for k in range(3))
        levels = [frictions[k][np.clip(np.arange(start, stop) - before, 0, counts[k] - 1)] for k in active]
        friction = np.repeat(np.stack(levels, axis=1), steps, axis=0)
        out = step.chain(state[active], *wanted, loaded[active], friction, settings).swapaxes(1, 2)
        states = np.concatenate([state[active][None], out[:, :, : 3 * n]])
        parts = [states[:-1:steps, :, : 2 * n], out[::steps, :, 3 * n :], reference[:-1:halves, :, :n]]
        log[start:stop, active] = np.concatenate(parts, axis=2)
        state[active] = states[-1]
        far = np.abs(states[-1][:, :n] - reference[-1, :, :n])
        if not (far < _LOST).all():
            joint = int(np.argmax(np.nan_to_num(far, nan=np.inf).max(axis=0))) + 1
            fault = f"robot {robot.name!r}: its controller loses joint {joint} at {(stop - before) / rate:.2f} s"
            raise InputError(f"{fault}: make the motion slower or the payload lighter (is its mass in kg?)")
        if progress:
            progress(start / len(log))
    runs = []
    for k, (task, friction, count) in enumerate(zip(tasks, frictions, counts, strict=True)):
        q, qd, torque, qdd, path = np.split(log[before : before + count, k], 5, axis=1)
        exact = Measurement(Motion(np.arange(count) / rate, q, qd, qdd), torque - rotors * qdd)
        recording = record(exact, disturbances, gains, [seed, k], task.name)
        mean = dict(zip(dry, friction.mean(axis=0).tolist(), strict=True))
        runs.append(SimulatedRun(task, recording, exact, mean, np.abs(q - path).max(axis=0)))
    return Experiment(robot, disturbances, phases, gains, seed, tuple(runs))
