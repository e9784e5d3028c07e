"""One integration step of a robot under its controller, as one function of scalar operations."""

from typing import NamedTuple

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import BaseParameters, Robot, forward_dynamics_base, mass_matrix
from ...model.dynamics import dry_friction_names, smooth_dry_friction
from ...model.integration import SMOOTHING, runge_kutta, stable_steps
from .controller import Controller, motor_torque, random_positions, speed_error
from .simulator import parameter_vector

_FEWEST, _FINEST = 4, 200  # steps per sample


class Ripple(NamedTuple):
    """Torque A sin(w q + phase) on each joint: amplitudes (n,), waves [1/rad or 1/m], phases (n, waves)."""

    amplitude: Array
    waves: tuple[int, ...]
    phases: Array


def integration_step(robot: Robot, base: BaseParameters, waves: int) -> ca.Function:
    """``step(x, wanted, wanted_middle, wanted_end, chi, level, settings)`` by the classical Runge-Kutta method.

    x holds q, qd and the controller's integral z; the three wanted hold q_r, qd_r and the feed-forward torque at
    the start, middle and end of the step; chi the base parameters with dry friction zero; level the dry friction;
    settings what ``step_settings`` gives. Nothing else is fixed: the code of a robot is compiled once.

    Args:
        waves: number of waves of the ripple.

    Returns:
        Function to x after the step, then motor torque and acceleration at its start, 5 n x 1.
    """
    n = robot.n
    x = ca.SX.sym("x", 3 * n)
    reference = [ca.SX.sym(f"wanted{k}", 3 * n) for k in range(3)]
    chi, level = ca.SX.sym("chi", len(base.columns)), ca.SX.sym("level", len(dry_friction_names(robot)))
    settings = ca.SX.sym("settings", 4 + 2 * n + waves * (n + 1))
    h, kp, kv, ki, J, amplitude, w, phases = ca.vertsplit(
        settings, np.cumsum([0, 1, 1, 1, 1, n, n, waves, n * waves]).tolist()
    )
    forward, friction = forward_dynamics_base(robot, base), smooth_dry_friction(robot, SMOOTHING)

    def slope(x: ca.SX, reference: ca.SX) -> tuple[ca.SX, ca.SX]:
        q, qd, z = ca.vertsplit(x, n)
        error = speed_error(q, qd, reference, kp)
        torque = motor_torque(error, z, reference, J, kv, ki)
        ripple = ca.SX.zeros(n)
        for k in range(waves):
            ripple += amplitude * ca.sin(w[k] * q + phases[k * n : (k + 1) * n])
        return ca.vertcat(qd, forward(q, qd, torque + ripple - friction(qd, level), chi), error), torque

    at_start, torque = slope(x, reference[0])
    after = runge_kutta(
        lambda x, reference: slope(x, reference)[0], x, h, (reference[0], reference[1], reference[2])
    )
    out = ca.cse(ca.densify(ca.vertcat(after, torque, at_start[n : 2 * n])))
    return ca.Function("step", [x, *reference, chi, level, settings], [out])


def step_settings(h: float, controller: Controller, inertia: Array, ripple: Ripple) -> Array:
    """What all runs share: step [s], gains, the controller's inertia, ripple."""
    gains = [h, controller.position, controller.speed, controller.integral]
    return np.concatenate([gains, inertia, ripple.amplitude, ripple.waves, ripple.phases.T.ravel()])


def steps_per_sample(robot: Robot, controller: Controller, inertia: Array, rate: float) -> int:
    """So many that the stiffest mode, dry friction about rest, is integrated stably.

    Raises:
        InputError: if the robot's links cannot exist or its friction is too stiff.
    """
    chi = parameter_vector(robot, robot.parameters)
    friction, names = smooth_dry_friction(robot, SMOOTHING), dry_friction_names(robot)
    qd, level = ca.SX.sym("qd", robot.n), [robot.parameters[name] for name in names]
    slope = np.array(ca.Function("slope", [qd], [ca.densify(ca.jacobian(friction(qd, level), qd))])(0.0))
    damping = slope + np.diag(inertia * (controller.speed + controller.position))
    fastest, A = 0.0, mass_matrix(robot)
    for q in random_positions(robot, 20):
        matrix = np.array(A(q, chi))
        if np.linalg.eigvalsh(matrix)[0] <= 0.0:
            raise InputError(
                f"robot {robot.name!r} cannot move: its parameters give an inertia matrix that is not positive "
                "definite: correct the inertias in its description"
            )
        fastest = max(fastest, float(np.abs(np.linalg.eigvals(np.linalg.solve(matrix, damping))).max()))
    steps = max(_FEWEST, stable_steps(fastest, 1.0 / rate))
    if steps > _FINEST:
        raise InputError(
            f"robot {robot.name!r}: friction about rest has a rate of {fastest:.0f} 1/s, too fast to integrate: "
            "are its rotor inertias (IA) missing?"
        )
    return steps
