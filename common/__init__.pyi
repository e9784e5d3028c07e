from numpy.typing import ArrayLike as ArrayLike

from .arrays import Array as Array
from .arrays import Brief as Brief
from .arrays import Indices as Indices
from .arrays import Mask as Mask
from .arrays import freeze_fields as freeze_fields
from .arrays import frozen_array as frozen_array
from .errors import InputError as InputError
from .errors import listed as listed
from .linear import decomposed as decomposed
from .linear import one_thread as one_thread
from .linear import without as without
from .schema import Document as Document
from .schema import Float as Float
from .schema import Vector as Vector
from .speech import Speaks as Speaks
