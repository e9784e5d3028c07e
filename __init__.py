"""dynident: what hangs on the flange of an industrial manipulator.

Identifies the inertial parameters of a robot and of its payload from recordings of the joints, and says how
far each number can be trusted.
"""

__version__ = "0.1.0"
