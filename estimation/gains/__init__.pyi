from .known_load import KnownLoad as KnownLoad
from .known_load import known_mass as known_mass
from .known_load import read_known_load as read_known_load
from .mounting import Mountings as Mountings
from .problem import GainProblem as GainProblem
from .problem import gain_problem as gain_problem
