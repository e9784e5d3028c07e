"""Drive gains, torque per motor current, from recordings of currents without and with a known payload."""

from ..gain_recordings import GainRecordings
from .answer import identify_gains
from .known_load import KnownLoad, known_mass, read_known_load
from .problem import GainProblem, gain_problem
from .result import DriveGains
from .stored import StoredGains, read_stored_gains

__all__ = [
    "DriveGains",
    "GainProblem",
    "GainRecordings",
    "KnownLoad",
    "StoredGains",
    "gain_problem",
    "identify_gains",
    "known_mass",
    "read_known_load",
    "read_stored_gains",
]
