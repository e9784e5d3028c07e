"""A path that differs: an arm that sags under the load does not run the motion it ran without.

The difference of the torques then holds Phi(q_L) chi - Phi(q_U) chi of the robot itself, about 100 N·m/rad at the
second joint, and repeats with the motion: no block of time shows it. It is taken off by parameters fitted to the
recording without payload, and a quarter of what it changes is part of the uncertainty: alignment takes part of a
sag for a delay.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...model import BaseParameters, Motion, Robot
from ...model.motion import Measurement
from ...model.names import parameter_kind
from ..equations.equation_code import PATH
from ..equations.equations import Equations
from ..equations.observation import Observation
from ..equations.observer import Observer
from ..equations.shared_torque import known_spring
from ..fit.roles import Known

_UNSURE = 0.25
"""Share of the correction that may be wrong (1 sigma)."""
_SMALL = 1e-3
"""Of the largest singular value, columns scaled: smaller ones the recording without payload does not show."""
_FRICTION = ("FS", "FV", "OFF", "FSM", "FVM")


def robot_of(unloaded: Equations) -> Array:
    """The robot's parameters by a recording without payload, as far as it shows them, friction zero; shape (c,).

    Joints weigh by their torques: weights by residuals would fall for a joint that is explained by chance.
    """
    rms = unloaded.torque_norms / np.sqrt(np.maximum(unloaded.rows, 1))
    weights = np.divide(1.0, rms, out=np.zeros_like(rms), where=rms > 0.0)
    factor = unloaded.stacked(weights)
    W, Y = factor[:, :-1], factor[:, -1]
    scale = np.linalg.norm(W, axis=0)
    scale[scale == 0.0] = 1.0
    U, singular, V = np.linalg.svd(W / scale, full_matrices=False)
    significant = singular > _SMALL * singular.max(initial=0.0)
    values = (V[significant].T @ ((U[:, significant].T @ Y) / singular[significant])) / scale
    return np.array(
        [
            0.0 if parameter_kind(name) in _FRICTION else value
            for name, value in zip(unloaded.columns, values, strict=True)
        ]
    )


def path_torque(robot: Robot, base: BaseParameters, chi: Array, unloaded: Motion, loaded: Motion) -> Array:
    """What the robot itself needs more on the loaded than on the unloaded path [N·m or N], N x n.

    Args:
        chi: their values, friction zero.
        unloaded: motion on the same time.
        loaded: motion.
    """
    observer = Observer(robot, base.columns)
    return observer.torques(loaded, chi) - observer.torques(unloaded, chi)


def less_path(robot: Robot, change: Measurement, path: Array) -> tuple[Measurement, Measurement]:
    """A difference of torques less what the path explains, and that as a measurement of its own."""
    spring = known_spring(robot)
    before = None if spring is None else spring.torque(change.motion.q[:, spring.joint - 1])
    return replace(change, torque=change.torque - path), Measurement(change.motion, path, before)


def with_path(change: Observation, path: Observation) -> Observation:
    """Equations with one more column: the torque that was taken off."""
    W = tuple(np.column_stack([own, path_column]) for own, path_column in zip(change.W, path.Y, strict=True))
    return replace(change, columns=(*change.columns, PATH), W=W)


def known_path(columns: Sequence[str], joints: int) -> tuple[Known, ...]:
    """What is known of it: nothing of it is left, but for a quarter."""
    if PATH not in columns:
        return ()
    return (
        Known(
            (PATH,),
            np.zeros(1),
            np.zeros((1, 1)),
            np.full((1, 1), _UNSURE**2),
            gain_sensitivity=lambda: np.zeros((1, joints)),
        ),
    )
