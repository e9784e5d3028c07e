"""The commands, one a file: ``add_parser`` declares the arguments, ``run`` hands values from room to room.

Every heavy import waits inside ``run``, so that ``dynident --help`` answers at once.
"""

from . import check, codegen, demo, design, export, gains, identify, payload, robot, simulate, verify, weigh

COMMANDS = (weigh, verify, payload, identify, gains, check, export, robot, codegen, design, simulate, demo)
"""In the order of ``dynident --help``."""
__all__ = ["COMMANDS"]
