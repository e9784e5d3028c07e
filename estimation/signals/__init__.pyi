from .alignment import aligned as aligned
from .decimation import decimated as decimated
from .decimation import noise_bandwidth as noise_bandwidth
from .filtering import resampled as resampled
from .measurements import measurement as measurement
