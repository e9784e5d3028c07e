"""A user's own model of the robot, moved by MuJoCo."""

from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot

_STEP = 1e-3
"""s: the longest step of the simulation."""


class MujocoArm:
    """A robot described by MJCF or URDF; its first n joints are taken for the robot's, in order."""

    def __init__(self, path: str | Path, robot: Robot) -> None:
        """Load the model.

        Raises:
            InputError: if MuJoCo is not installed, the file cannot be read, or it has other joints.
        """
        try:
            import mujoco
        except ImportError:
            raise InputError(
                f"{path}: MuJoCo is needed to move this model: pip install 'dynident[simulators]'"
            ) from None
        if not Path(path).is_file():
            raise InputError(f"{path}: no such file")
        self.name, self._mujoco = Path(path).name, mujoco
        try:
            self._model: Any = mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            raise InputError(f"{path}: MuJoCo cannot read it: {error}") from None
        if self._model.nv != robot.n:
            raise InputError(
                f"{path} has {self._model.nv} degrees of freedom, {robot.name} has {robot.n}: give a model of the "
                "arm alone, fixed to the ground"
            )
        self._model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)

    def positions(self, q: Array, qd: Array, torque: Array, step: float) -> Array:
        """Positions under torques alone; arguments and result are those of ``IdentifiedArm.positions``."""
        count = max(1, int(np.ceil(step / _STEP - 1e-9)))
        self._model.opt.timestep = step / count
        result = np.empty_like(torque)
        for start in range(len(q)):
            data = self._mujoco.MjData(self._model)
            data.qpos[:], data.qvel[:] = q[start], qd[start]
            for k in range(torque.shape[1]):
                result[start, k] = data.qpos
                here, after = torque[start, k], torque[start, min(k + 1, torque.shape[1] - 1)]
                for part in range(count):
                    data.qfrc_applied[:] = here + (part + 0.5) / count * (after - here)
                    self._mujoco.mj_step(self._model, data)
        return result
