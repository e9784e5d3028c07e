from .alignment import aligned as aligned
from .decimation import decimated as decimated
from .decimation import noise_bandwidth as noise_bandwidth
from .filtering import measurement as measurement
from .filtering import resampled as resampled
from .measurements import Measurements as Measurements
