from .rank import base_parameters_of as base_parameters_of
from .rank import leftmost_independent as leftmost_independent
from .rank import random_states as random_states
from .rank import stacked_regressor as stacked_regressor
