"""A whole robot in the format of a simulator: one file a format.

Every number of a robot says who decided it (data, rule or prior) and how sure it is, in comments and in what a
simulator keeps when it writes the model again; what a format has no place for is said.
"""

from ..format import formats
from ..robot import robot_head

FORMATS = formats(__name__, __path__, head=robot_head)  # every format of a robot by its name
