"""A path that differs: an arm that sags under the load does not run the motion it ran without.

The difference of the torques then holds Phi(q_L) chi - Phi(q_U) chi of the robot itself, about 100 N·m/rad at the
second joint, and repeats with the motion: no block of time shows it. It is taken off by parameters fitted to the
recording without payload, and a quarter of what it changes is part of the uncertainty: alignment takes part of a
sag for a delay.
"""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...model.drives import FRICTION, parameter_kind
from ..equations.equations import Equations
from ..equations.observer import PATH
from ..fit.linear_problem import Known

_UNSURE = 0.25
"""Share of the correction that may be wrong (1 sigma)."""
_SMALL = 1e-3
"""Of the largest singular value, columns scaled: smaller ones the recording without payload does not show."""


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
            0.0 if parameter_kind(name) in FRICTION else value
            for name, value in zip(unloaded.columns, values, strict=True)
        ]
    )


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
