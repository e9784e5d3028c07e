from . import controllers as controllers
from . import motions as motions
from . import simulators as simulators
