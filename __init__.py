"""dynident: what hangs on the flange of an industrial manipulator.

Identifies the inertial parameters of a robot and of its payload from recordings of the joints, and says how
far each number can be trusted. The rooms: ``dynident.model`` (the robot and its dynamics),
``dynident.estimation`` (recordings to parameters), ``dynident.trajectories`` (motions and simulation). The
names below are the short way to what most scripts need; they are imported on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .common.errors import InputError
    from .estimation import answer_payload, identify, identify_payload, payload_problem, read_recording
    from .model import InertialParameters, Recording, Robot, base_parameters, load_robot
    from .trajectories import Simulator, random_via_points

__version__ = "0.1.0"

__all__ = [
    "InertialParameters",
    "InputError",
    "Recording",
    "Robot",
    "Simulator",
    "answer_payload",
    "base_parameters",
    "identify",
    "identify_payload",
    "load_robot",
    "payload_problem",
    "random_via_points",
    "read_recording",
]

_ROOMS = {
    "estimation": {"answer_payload", "identify", "identify_payload", "payload_problem", "read_recording"},
    "model": {"InertialParameters", "InputError", "Recording", "Robot", "base_parameters", "load_robot"},
    "trajectories": {"Simulator", "random_via_points"},
}


def __getattr__(name: str) -> Any:
    for room, names in _ROOMS.items():
        if name in names:
            return getattr(import_module(f".{room}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
