"""Joints and frames in a robot's TOML file: angles in degrees, everything else in SI units."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from ...common.schema import Real, Table, Triple, WrongKeyError
from ..pose import Pose
from ..robot import Joint, Limits

_TREES = "trees are not supported: give the joints of one chain, base to tip"
_UNITS = {"revolute": "deg", "prismatic": "m"}
_LIMITS = {"position": "position_{}", "speed": "speed_{}_s", "acceleration": "acceleration_{}_s2"}
Pair = tuple[Real, Real]
"""Two numbers."""


class PoseTable(Table, frozen=True):
    """A frame in another one."""

    xyz: Triple = (0.0, 0.0, 0.0)
    rpy_deg: Triple = (0.0, 0.0, 0.0)

    @staticmethod
    def of(pose: Pose) -> "PoseTable":
        """Table of a frame."""
        roll, pitch, yaw = map(degrees, pose.rpy)
        return PoseTable(xyz=pose.origin, rpy_deg=(roll, pitch, yaw))

    def pose(self) -> Pose:
        """The frame."""
        return Pose.from_rpy(self.xyz, [math.radians(angle) for angle in self.rpy_deg])


class JointTable(Table, frozen=True):
    """A joint; ``d`` and ``r`` are lengths or names of lengths, the limits' units go by the joint's kind."""

    advice: ClassVar[Mapping[str, str]] = {
        "parent": _TREES,
        "antecedent": _TREES,
        "kind": "must be 'revolute' or 'prismatic' (a body fixed to a link is part of it)",
    }

    kind: Literal["revolute", "prismatic"] = "revolute"
    alpha_deg: Real = 0.0
    d: Real | str = 0.0
    theta_deg: Real = 0.0
    r: Real | str = 0.0
    position_deg: Pair | None = None
    position_m: Pair | None = None
    speed_deg_s: Real | None = None
    speed_m_s: Real | None = None
    acceleration_deg_s2: Real | None = None
    acceleration_m_s2: Real | None = None
    torque: Real | None = None

    @staticmethod
    def of(joint: Joint, number: int) -> "JointTable":
        """Table of a joint; limits that are infinite are left out."""
        shown = degrees if joint.revolute else float
        values: dict[str, Any] = {}
        for name, key in _LIMITS.items():
            value = getattr(joint.limits, name)
            if all(map(math.isfinite, value if name == "position" else [value])):
                shorter = [shown(end) for end in value] if name == "position" else shown(value)
                values[key.format(_UNITS[joint.kind])] = shorter
        names = length_names(joint, number)
        return JointTable(
            kind=joint.kind,
            alpha_deg=degrees(joint.alpha),
            d=names[0] if joint.d else 0.0,
            theta_deg=degrees(joint.theta),
            r=names[1] if joint.r else 0.0,
            torque=joint.limits.torque if math.isfinite(joint.limits.torque) else None,
            **values,
        )

    def joint(self, lengths: Mapping[str, float]) -> Joint:
        """The joint."""
        unit, other_unit = ("deg", "m") if self.kind == "revolute" else ("m", "deg")
        scale = math.pi / 180.0 if unit == "deg" else 1.0
        limits: dict[str, Any] = {} if self.torque is None else {"torque": self.torque}
        for name, key in _LIMITS.items():
            if getattr(self, key.format(other_unit)) is not None:
                raise WrongKeyError(key.format(other_unit), f"a {self.kind} joint takes {key.format(unit)}")
            value = getattr(self, key.format(unit))
            if value is not None:
                limits[name] = tuple(end * scale for end in value) if name == "position" else value * scale
        (d, d_name), (r, r_name) = self._length("d", lengths), self._length("r", lengths)
        alpha, theta = math.radians(self.alpha_deg), math.radians(self.theta_deg)
        return Joint(self.kind, alpha, d, theta, r, Limits(**limits), (d_name, r_name))

    def _length(self, key: str, lengths: Mapping[str, float]) -> tuple[float, str]:
        value = getattr(self, key)
        if not isinstance(value, str):
            return value, ""
        if value not in lengths:
            raise WrongKeyError(key, f"no length {value!r} in [lengths]")
        return lengths[value], value


def length_names(joint: Joint, number: int) -> tuple[str, str]:
    """What the lengths d and r of a joint (from 1) are called."""
    return joint.names[0] or f"D{number}", joint.names[1] or f"R{number}"


def degrees(angle: float) -> float:
    """Write an angle in as few digits as give it back to 1e-14 rad."""
    degrees = math.degrees(angle)
    short = (round(degrees, digits) + 0.0 for digits in range(14))
    return next(
        (value for value in short if abs(math.radians(value) - angle) <= 1e-14 * max(1.0, abs(angle))), degrees
    )
