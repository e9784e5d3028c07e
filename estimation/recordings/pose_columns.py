"""Which columns of a log hold the tool's pose."""

from collections.abc import Collection
from dataclasses import dataclass

FORMS = {"rotation_vector": 3, "rpy": 3, "quaternion": 4}
"""How axes are written, and in how many columns."""
_LENGTHS, _ANGLES = ("m", "mm"), ("rad", "deg")
_PLACE, _QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class ToolColumns:
    """Columns of the tool's position and, perhaps, of its axes, in any fixed frame.

    Attributes:
        columns: of x, y, z.
        unit: of these, "m" or "mm".
        rotation: columns of the axes; empty where they are not logged.
        form: of ``FORMS``: "rotation_vector" (Universal Robots), "rpy": roll, pitch, yaw about fixed x, y, z, or
            "quaternion": x, y, z, w.
        rotation_unit: "rad" or "deg", of a rotation vector and of rpy.
    """

    columns: tuple[str, ...]
    unit: str = "m"
    rotation: tuple[str, ...] = ()
    form: str = ""
    rotation_unit: str = "rad"

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if len(self.columns) != 3:
            raise ValueError(f"pose.columns has {len(self.columns)} names: give those of x, y and z")
        for name, unit, known in (("unit", self.unit, _LENGTHS), ("rotation_unit", self.rotation_unit, _ANGLES)):
            if unit not in known:
                raise ValueError(f"pose.{name} {unit!r}: give one of {', '.join(known)}")
        if bool(self.rotation) != bool(self.form):
            raise ValueError(f"pose.rotation and pose.form go together; form is one of {', '.join(FORMS)}")
        if self.form and self.form not in FORMS:
            raise ValueError(f"pose.form {self.form!r}: give one of {', '.join(FORMS)}")
        if self.form and len(self.rotation) != FORMS[self.form]:
            raise ValueError(
                f"pose.rotation has {len(self.rotation)} names: a {self.form} has {FORMS[self.form]} columns"
            )
        if self.form == "quaternion" and self.rotation_unit != "rad":
            raise ValueError("pose.rotation_unit: a quaternion has none, leave it out")

    @property
    def all(self) -> tuple[str, ...]:
        """Every column."""
        return (*self.columns, *self.rotation)


def standard_pose(names: Collection[str]) -> ToolColumns | None:
    """What a log without a map holds: x, y, z [m], perhaps with a quaternion qx, qy, qz, qw; None without them."""
    if not set(_PLACE) <= set(names):
        return None
    if set(_QUATERNION) <= set(names):
        return ToolColumns(_PLACE, "m", _QUATERNION, "quaternion")
    return ToolColumns(_PLACE)
