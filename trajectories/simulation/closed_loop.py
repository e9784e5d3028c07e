"""Robots under their joint controllers: forward dynamics in closed loop, and experiments of recorded runs.

The controller has a position and a speed loop in cascade, with feed-forward. Many runs go side by side in a batch.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from ...common import Array, Brief, InputError
from ...model import (
    BaseParameters,
    InertialParameters,
    Motion,
    Recording,
    Robot,
    base_parameters,
    forward_dynamics_base,
    inverse_dynamics_base,
    mass_matrix,
    standard_columns,
)
from ...model.dynamics import SMOOTHING, dry_friction_names, runge_kutta, smooth_dry_friction, stable_steps
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.stand_in import completed, poses_in_range, rotor_inertias, with_rotors
from ..motions.family import Plan, sample_count
from .simulator import Disturbances, Simulator, draw_friction, draw_robot_errors, no_disturbances, record

_POSES = 200  # over which a joint's inertia is averaged
_TIMES = 2000  # of each reference, at which a payload's torque is looked at
_FEWEST, _FINEST = 4, 200  # steps of integration per sample
_SETTLE = 1.0  # s before a run starts, in which the loops take up the load
_CHUNK = 50  # samples whose references are computed at once
_LOST = 0.5  # rad or m from the reference: the controller has lost the robot


@dataclass(frozen=True)
class Controller:
    """Gains of a joint's loops; torques are these times the joint's mean inertia.

    motor torque = J (kv (v - qd) + ki z) + feed-forward, with v = qd_r + kp (q_r - q) and z' = v - qd.

    The feed-forward is the model's torque on the reference motion: the unloaded robot's, without dry friction, for
    a controller knows neither the payload nor how stiff the gears are today. Without an integral nothing takes up
    what the payload adds: the arm sags until the position error holds it, by its torque / (J kp kv). The loops
    see the exact positions and speeds: a step of the encoder of 1e-5 rad changes the torque by far less than the
    recorded noise.

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
            motion = Motion(t, *reference.at(t))
            differences.append(simulator.measure(motion, payload).torque - simulator.measure(motion).torque)
        acceleration = np.sqrt(np.mean(np.concatenate(differences) ** 2, axis=0)) / mean_inertia(robot)
        ratio = np.sqrt(float(acceleration.max()) / sag / (self.position * self.speed))
        return replace(self, position=ratio * self.position, speed=ratio * self.speed)


CONTROLLERS = {
    "integral": Controller(),
    "proportional": Controller(integral=0.0),
    "gravity": Controller(integral=0.0, compensates="gravity"),
}
"""Controllers: loops of most industrial arms; without integral action; and those that know gravity alone."""


class Task(NamedTuple):
    """Run to be simulated.

    Attributes:
        name: of the recording.
        reference: what the robot is to do.
        payload: fixed to the last link, in the robot's payload frame.
        friction: dry friction at each sample [N·m or N], at least (samples, names) with the columns of
            ``dry_friction_names``; the last row holds on. None for the robot's own at all times.
    """

    name: str
    reference: Plan
    payload: InertialParameters | None = None
    friction: Array | None = None


class ClosedLoop:
    """Simulates a robot with known parameters, its controller and its gears, in steps within each sample."""

    def __init__(
        self,
        robot: Robot,
        controller: Controller | None = None,
        disturbances: Disturbances | None = None,
        phases: Array | None = None,
    ) -> None:
        """Generate the code of one step; ``disturbances``: whose ripple, of ``phases`` [rad], n x waves, acts."""
        robot, own = completed(robot, limits=False, frames=4), controller or Controller()
        self.robot, self.rate, self._controller, self._rotors = robot, own.rate, own, np.zeros(robot.n)
        if robot.drives.side == "link":
            # Sensors behind the gears see no rotor, but the arm turns them.
            self._rotors = rotor_inertias(robot, robot.parameters)
            robot = with_rotors(robot, self._rotors)
        self._plant, self._base, self._dry = robot, base_parameters(robot), dry_friction_names(robot)
        inertia = mean_inertia(robot)
        self.steps = steps_per_sample(robot, own, inertia)
        disturbances = disturbances or replace(no_disturbances(robot.n), waves=())
        phases = draw_robot_errors(disturbances, 0)[0] if phases is None else phases
        gains = [1.0 / (self.rate * self.steps), own.position, own.speed, own.integral]
        ripple = (disturbances.ripple, disturbances.waves, phases.T.ravel())
        self._settings = np.concatenate([gains, inertia, *ripple])
        self._step = Kernel(integration_step(robot, self._base, len(disturbances.waves)))
        self._feed_forward = Kernel(inverse_dynamics_base(robot, self._base))
        self._bare = self._parameters(None)

    def run(
        self, tasks: Sequence[Task], progress: Callable[[float], None] | None = None
    ) -> list[tuple[Measurement, Array]]:
        """Simulate all tasks in lockstep; no task has an effect on another.

        Returns:
            For each task the exact motion with the motor torques, and the reference positions (N, n).

        Raises:
            InputError: if the controller loses the robot.
        """
        n, rate, halves = self.robot.n, self.rate, 2 * self.steps
        moving = float(self._controller.compensates == "motion")
        counts = np.array([sample_count(task.reference.duration, rate) for task in tasks])
        own = np.array([[self.robot.parameters[name] for name in self._dry]])
        frictions = [own if task.friction is None else np.asarray(task.friction) for task in tasks]
        chi = np.array([self._parameters(task.payload) for task in tasks])
        state = np.zeros((len(tasks), 3 * n))
        state[:, :n] = [task.reference.at(np.zeros(1))[0][0] for task in tasks]
        log = np.zeros((int(counts.max()), len(tasks), 5 * n))  # q, qd, torque, qdd, reference
        first = -round(_SETTLE * rate)
        for start in range(first, len(log), _CHUNK):
            # Runs that have not ended go on for some samples.
            stop, active = min(start + _CHUNK, len(log)), np.flatnonzero(counts > start).tolist()
            # Positions, speeds and feed-forward at every half step.
            t, sample = np.arange(start * halves, stop * halves + 1) / (rate * halves), np.arange(start, stop)
            known = dict[int, Array]()  # once for runs on the same reference
            for plan in (tasks[k].reference for k in active):
                if id(plan) not in known:
                    q, qd, qdd = plan.at(t)
                    torque = self._feed_forward(q, moving * qd, moving * qdd, self._bare).T
                    known[id(plan)] = np.hstack([q, qd, self._controller.feed_forward * torque])
            reference = np.stack([known[id(tasks[k].reference)] for k in active], axis=1)
            wanted = (reference[k : len(reference) - 2 + k : 2] for k in range(3))
            levels = [frictions[k][np.clip(sample, 0, len(frictions[k]) - 1)] for k in active]
            friction = np.repeat(np.stack(levels, axis=1), self.steps, axis=0)
            out = self._step.chain(state[active], *wanted, chi[active], friction, self._settings).swapaxes(1, 2)
            states = np.concatenate([state[active][None], out[:, :, : 3 * n]])
            logged = slice(max(start, 0), stop)
            if logged.start < stop:
                at = self.steps * np.arange(logged.start - start, stop - start)
                parts = [states[at, :, : 2 * n], out[at, :, 3 * n :], reference[2 * at, :, :n]]
                log[logged, active] = np.concatenate(parts, axis=2)
            state[active] = states[-1]
            far = np.abs(states[-1][:, :n] - reference[-1, :, :n])
            if not (far < _LOST).all():
                joint = int(np.argmax(np.nan_to_num(far, nan=np.inf).max(axis=0))) + 1
                raise InputError(
                    f"robot {self.robot.name!r}: its controller loses joint {joint} at {stop / rate:.2f} s: "
                    "make the motion slower or the payload lighter (is its mass in kg?)"
                )
            if progress:
                progress((start - first) / (counts.max() - first))
        finished = []
        for k, count in enumerate(counts):
            q, qd, torque, qdd, reference = np.split(log[:count, k], 5, axis=1)
            motion = Motion(np.arange(count) / rate, q, qd, qdd)
            finished.append((Measurement(motion, torque - self._rotors * qdd), reference))
        return finished

    def _parameters(self, payload: InertialParameters | None) -> Array:
        """Values of the base parameters, dry friction left out."""
        vector = self._plant.chi(payload=payload)
        values = dict(zip(standard_columns(self._plant), vector, strict=True)) | dict.fromkeys(self._dry, 0.0)
        return self._base.value(values)


def integration_step(robot: Robot, base: BaseParameters, waves: int) -> ca.Function:
    """``step(x, wanted, wanted_middle, wanted_end, chi, level, settings)`` by the classical Runge-Kutta method.

    x holds q, qd and the controller's integral z; the three wanted hold q_r, qd_r and the feed-forward torque at
    the start, middle and end of the step; chi the base parameters with dry friction zero; level the dry friction;
    settings the step [s], kp, kv, ki, the controller's inertia, and the ripple's amplitudes, waves and phases.
    Nothing else is fixed: the code of a robot is compiled once.

    It gives x after the step, then motor torque and acceleration at its start, 5 n x 1.
    """
    n = robot.n
    x = ca.SX.sym("x", 3 * n)
    reference = [ca.SX.sym(f"wanted{k}", 3 * n) for k in range(3)]
    chi, level = ca.SX.sym("chi", len(base.columns)), ca.SX.sym("level", len(dry_friction_names(robot)))
    settings = ca.SX.sym("settings", 4 + 2 * n + waves * (n + 1))
    h, kp, kv, ki, J, amplitude, w, phases = ca.vertsplit(
        settings, np.cumsum([0, 1, 1, 1, 1, n, n, waves, n * waves]).tolist()
    )
    forward, dry = forward_dynamics_base(robot, base, SMOOTHING), dry_friction_names(robot)
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
    after = runge_kutta(lambda x, reference: slope(x, reference)[0], x, h, (start, middle, end))
    out = ca.cse(ca.densify(ca.vertcat(after, torque, at_start[n : 2 * n])))
    return ca.Function("step", [x, *reference, chi, level, settings], [out])


def steps_per_sample(robot: Robot, controller: Controller, inertia: Array) -> int:
    """Count the steps by which the stiffest mode, dry friction about rest, is integrated stably."""
    friction, qd = smooth_dry_friction(robot, SMOOTHING), ca.SX.sym("qd", robot.n)
    level = [robot.parameters[name] for name in dry_friction_names(robot)]
    slope = np.array(ca.Function("slope", [qd], [ca.densify(ca.jacobian(friction(qd, level), qd))])(0.0))
    damping = slope + np.diag(inertia * (controller.speed + controller.position))
    matrices = inertia_matrices(robot, 20)
    if np.linalg.eigvalsh(matrices).min() <= 0.0:
        raise InputError(
            f"robot {robot.name!r} cannot move: its parameters give an inertia matrix that is not positive "
            "definite: correct the inertias in its description"
        )
    # Rates of A qdd = -D qd: the eigenvalues of A^-1 D.
    fastest = float(np.abs(np.linalg.eigvals(np.linalg.inv(matrices) @ damping)).max())
    steps = max(_FEWEST, stable_steps(fastest, 1.0 / controller.rate))
    if steps > _FINEST:
        raise InputError(
            f"robot {robot.name!r}: friction about rest has a rate of {fastest:.0f} 1/s, too fast to integrate: "
            "are its rotor inertias (IA) missing?"
        )
    return steps


def mean_inertia(robot: Robot) -> Array:
    """Mean diagonal of the inertia matrix over the joints' ranges [kg m^2 or kg], shape (n,)."""
    return np.asarray(np.diagonal(inertia_matrices(robot, _POSES), axis1=1, axis2=2).mean(axis=0))


def inertia_matrices(robot: Robot, count: int) -> Array:
    """Inertia matrices, count x n x n, at ``poses_in_range``."""
    A, chi = mass_matrix(robot), robot.chi()
    return np.array([np.array(A(q, chi)) for q in poses_in_range(robot, count)])


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
        phases, gains: of the ripple and of the drives, as ``draw_robot_errors`` gives them.
        seed: of everything that was drawn.
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
        own = self.disturbances
        for name in ("ripple", "waves", "friction", "friction_memory"):
            if getattr(own, name) != getattr(disturbances, name):
                raise ValueError(f"{name} acts on the moving robot: simulate again")
        phases, gains = draw_robot_errors(disturbances, self.seed)
        runs = []
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
    """Run tasks under the controller and record them, dry friction drawn by the disturbances.

    Args:
        disturbances: what the robot and its recordings suffer from.
        seed: the same seed gives the same recordings.

    Raises:
        InputError: if the robot's parameters are missing, or its controller loses it.
    """
    phases, gains = draw_robot_errors(disturbances, seed)
    loop, runs = ClosedLoop(robot, controller, disturbances, phases), []
    robot = loop.robot
    counts = [sample_count(task.reference.duration, loop.rate) for task in tasks]
    frictions = [draw_friction(robot, disturbances, count, loop.rate, [seed, k]) for k, count in enumerate(counts)]
    rubbing = [task._replace(friction=friction) for task, friction in zip(tasks, frictions, strict=True)]
    for k, (task, (exact, reference)) in enumerate(zip(tasks, loop.run(rubbing, progress), strict=True)):
        recording = record(exact, disturbances, gains, [seed, k], task.name)
        levels = dict(zip(dry_friction_names(robot), frictions[k].mean(axis=0).tolist(), strict=True))
        distance = np.abs(exact.motion.q - reference).max(axis=0)
        runs.append(SimulatedRun(task, recording, exact, levels, distance))
    return Experiment(robot, disturbances, phases, gains, seed, tuple(runs))
