"""A robot under its controller: forward dynamics in closed loop, many runs side by side in one batch."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters, Motion, Robot, base_parameters, inverse_dynamics_base, standard_columns
from ...model.dynamics import dry_friction_names
from ...model.integration import Stepper
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.stand_in import rotor_inertias, with_rotors
from ..motions.samples import Plan, sample_count
from .controller import Controller, mean_inertia
from .integrator import Ripple, integration_step, step_settings, steps_per_sample
from .simulator import check_parameters, parameter_vector

_SETTLE = 1.0  # s before a run starts, in which the loops take up the load
_CHUNK = 50  # samples whose references are computed at once
_LOST = 0.5  # rad or m from the reference: the controller has lost the robot


class Task(NamedTuple):
    """A run to be simulated.

    Attributes:
        name: of the recording.
        reference: what the robot is told to do.
        payload: fixed to the last link, in the robot's payload frame.
        friction: dry friction at each sample [N·m or N], at least (samples, names) with the columns of
            ``dry_friction_names``; the last row holds on. None for the robot's own at all times.
    """

    name: str
    reference: Plan
    payload: InertialParameters | None = None
    friction: Array | None = None


class ClosedLoop:
    """A robot with known parameters, its controller and its gears.

    Attributes:
        rate: of the samples [Hz].
        steps: of the integration (classical Runge-Kutta) per sample.
    """

    def __init__(
        self, robot: Robot, controller: Controller | None = None, ripple: Ripple | None = None, rate: float = 250.0
    ) -> None:
        """Generate the code of one integration step.

        Raises:
            InputError: if the robot's description lacks standard parameters, or its links cannot exist.
        """
        check_parameters(robot)
        self.robot, self.rate = robot, rate
        self._rotors = np.zeros(robot.n)
        if robot.drives.side == "link":
            # Sensors behind the gears see no rotor, but the arm turns them.
            self._rotors = rotor_inertias(robot, robot.parameters)
            robot = with_rotors(robot, self._rotors)
        self._plant, self._controller = robot, controller or Controller()
        self._base = base_parameters(robot)
        self._dry = dry_friction_names(robot)
        inertia = mean_inertia(robot)
        self.steps = steps_per_sample(robot, self._controller, inertia, rate)
        ripple = ripple or Ripple(np.zeros(robot.n), (), np.zeros((robot.n, 0)))
        self._settings = step_settings(1.0 / (rate * self.steps), self._controller, inertia, ripple)
        self._step = Stepper(integration_step(robot, self._base, len(ripple.waves)))
        self._feed_forward = Kernel(inverse_dynamics_base(robot, self._base))
        self._bare = self._parameters(None)

    def run(
        self, tasks: Sequence[Task], progress: Callable[[float], None] | None = None
    ) -> list[tuple[Measurement, Array]]:
        """Simulate all tasks in lockstep; each comes out as if it were alone.

        Returns:
            For each task the exact motion with the motor torques, and the reference positions (N, n).

        Raises:
            InputError: if the controller loses the robot.
        """
        counts = np.array([sample_count(task.reference.duration, self.rate) for task in tasks])
        own = np.array([[self.robot.parameters[name] for name in self._dry]])
        tasks = [task if task.friction is not None else task._replace(friction=own) for task in tasks]
        batch = _Batch(tasks, counts, self.robot.n, [self._parameters(task.payload) for task in tasks])
        first = -round(_SETTLE * self.rate)
        for start in range(first, int(counts.max()), _CHUNK):
            self._advance(batch, start, min(start + _CHUNK, int(counts.max())))
            if progress:
                progress((start - first) / (counts.max() - first))
        return [batch.result(k, self.rate, self._rotors) for k in range(len(tasks))]

    def _advance(self, batch: "_Batch", start: int, stop: int) -> None:
        """Integrate the runs that have not ended over some samples."""
        n, active = self.robot.n, np.flatnonzero(batch.counts > start).tolist()
        reference = self._wanted([batch.tasks[k].reference for k in active], start, stop)
        levels = np.array([batch.friction(active, sample) for sample in range(start, stop)])
        out = self._step(
            batch.state[active],
            *(reference[k : len(reference) - 2 + k : 2] for k in range(3)),
            batch.chi[active],
            np.repeat(levels, self.steps, axis=0),
            self._settings,
        ).swapaxes(1, 2)
        states = np.concatenate([batch.state[active][None], out[:, :, : 3 * n]])
        logged = slice(max(start, 0), stop)
        if logged.start < stop:
            at = self.steps * np.arange(logged.start - start, stop - start)
            batch.log[logged, active] = np.concatenate(
                [states[at, :, : 2 * n], out[at, :, 3 * n :], reference[2 * at, :, :n]], axis=2
            )
        batch.state[active] = x = states[-1]
        far = np.abs(x[:, :n] - reference[-1, :, :n])
        if not (far < _LOST).all():
            joint = int(np.argmax(np.nan_to_num(far, nan=np.inf).max(axis=0))) + 1
            raise InputError(
                f"robot {self.robot.name!r}: its controller loses joint {joint} at {stop / self.rate:.2f} s: "
                "make the motion slower or the payload lighter"
            )

    def _wanted(self, references: Sequence[Plan], start: int, stop: int) -> Array:
        """Reference positions, speeds and feed-forward at every half step, (half steps, runs, 3 n)."""
        halves = 2 * self.steps
        t = np.arange(start * halves, stop * halves + 1) / (self.rate * halves)
        known: dict[int, Array] = {}
        for reference in references:
            if id(reference) not in known:
                q, qd, qdd = reference.at(t)
                moving = float(self._controller.compensates == "motion")
                torque = self._feed_forward(q, moving * qd, moving * qdd, self._bare).T
                known[id(reference)] = np.hstack([q, qd, self._controller.feed_forward * torque])
        return np.stack([known[id(reference)] for reference in references], axis=1)

    def _parameters(self, payload: InertialParameters | None) -> Array:
        """Base parameters, dry friction left out."""
        vector = parameter_vector(self._plant, self._plant.parameters, payload)
        values = dict(zip(standard_columns(self._plant), vector, strict=True)) | dict.fromkeys(self._dry, 0.0)
        return self._base.value(values)


class _Batch:
    """States and logs of the runs; rows of ``log``: q, qd, torque, qdd, reference."""

    def __init__(self, tasks: Sequence[Task], counts: NDArray[np.int_], n: int, chi: Sequence[Array]) -> None:
        self.tasks, self.counts, self.chi = tasks, counts, np.array(chi)
        self.state = np.zeros((len(tasks), 3 * n))
        for state, task in zip(self.state, tasks, strict=True):
            state[:n] = task.reference.at(np.zeros(1))[0][0]
        self.log = np.zeros((int(counts.max()), len(tasks), 5 * n))

    def friction(self, active: Sequence[int], sample: int) -> Array:
        rows = [np.asarray(self.tasks[k].friction) for k in active]
        return np.array([levels[min(max(sample, 0), len(levels) - 1)] for levels in rows])

    def result(self, k: int, rate: float, rotors: Array) -> tuple[Measurement, Array]:
        q, qd, torque, qdd, reference = np.split(self.log[: self.counts[k], k], 5, axis=1)
        motion = Motion(np.arange(self.counts[k]) / rate, q, qd, qdd)
        return Measurement(motion, torque - rotors * qdd), reference
