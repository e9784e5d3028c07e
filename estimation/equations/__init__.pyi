from .equations import Equations as Equations
from .equations import merged as merged
from .observation import Observation as Observation
from .observer import Observer as Observer
from .reduction import reduced as reduced
from .reduction import reduced_measurement as reduced_measurement
from .reduction import reduced_pieces as reduced_pieces
