"""Names that several files of this room use."""

from ...model import INERTIAL

PAYLOAD = tuple(f"{kind}_L" for kind in INERTIAL)
"""Names of the payload's ten parameters chi_L, in the order of (6)."""
