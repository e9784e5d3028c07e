"""What else is in the torques of recordings: a tilt, a delay, a slip, or a pull at the flange."""

from ...model import Robot
from ..payload.problem import Source
from .evidence import Sampled
from .nuisances import Nuisance, Tilt, nuisances, tilt
from .pull import Pull, outstanding
from .rivals import rivals
from .states import states_of
from .thinned import Thinned, thinned_robot


def in_the_torques(system: Thinned) -> tuple[Tilt | None, tuple[Nuisance, ...], tuple[Pull, ...]]:
    """A tilt, a delay and a slip, or a pull at the flange: no tilt where that explains the recordings better."""
    leaning, others = tilt(system), nuisances(system)
    pulls = outstanding(system, leaning, others)
    return (None if pulls else leaning), others, pulls


def beside_robot(robot: Robot, source: Source) -> Sampled:
    """Other ways to take recordings of a robot alone, and what else is in their torques."""
    states = states_of(source)
    system = thinned_robot(robot, states)
    leaning, others, pulls = in_the_torques(system) if system is not None else (None, (), ())
    return Sampled(rivals(robot, states), tilt=leaning, nuisances=others, pulls=pulls)
