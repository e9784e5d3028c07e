"""The commands, one a file: ``add_parser`` declares the arguments, ``run`` hands values from room to room.

Every heavy import waits inside ``run``, so that ``dynident --help`` answers at once.
"""

from . import codegen, demo, design, export, identify, payload, simulate

COMMANDS = (payload, identify, export, codegen, design, simulate, demo)
"""In the order of ``dynident --help``."""
__all__ = ["COMMANDS"]
