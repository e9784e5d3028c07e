"""How a log's columns become a recording: which columns, unit, side, sign."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .layout import Layout
from .pose_columns import ToolColumns
from .units import DEFAULT, factor, is_share

QUANTITIES = ("position", "velocity", "torque", "current")
"""What is measured of each joint."""
REFERENCES = {"position_reference": "position", "torque_reference": "torque"}
"""What the controller wanted of each joint, and the quantity it belongs to; read by ``read_following``."""


@dataclass(frozen=True)
class Quantity:
    """One measured quantity of all joints.

    Attributes:
        kind: of ``QUANTITIES``.
        columns: one name for each joint, or one pattern: "{}" stands for the joint's number, "{0}" for the number
            less one, "{joint}" for its name. Empty: the standard names q1, qd1, tau1, i1.
        unit: one for all joints, or one for each.
        side: "motor": before the gears.
        sign: 1 or -1 for each joint; of the column, before anything else.
        zero: added to joint-side positions [rad or m], one for each joint.
        rated: what 100 percent is, in N·m, N or A on the column's own side, one for each joint.
    """

    kind: str
    columns: tuple[str, ...] = ()
    unit: tuple[str, ...] = ()
    side: Literal["joint", "motor"] = "joint"
    sign: tuple[float, ...] = ()
    zero: tuple[float, ...] = ()
    rated: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.side not in ("joint", "motor"):
            raise ValueError(f"side {self.side!r}: give 'joint' or 'motor'")
        if self.side == "motor" and self.kind == "current":
            raise ValueError("a current has no side: leave 'side' out, drive gains tell its torque")
        if any(abs(sign) != 1.0 for sign in self.sign):
            raise ValueError("sign must be 1 or -1")
        if self.zero and self.kind != "position":
            raise ValueError("only positions have a zero")
        shares = [is_share(unit) for unit in self.units]
        if any(shares) != bool(self.rated):
            raise ValueError("rated goes with the unit percent: what 100 percent is, for each joint")
        for unit in self.units:
            factor(self.kind, unit)

    @property
    def units(self) -> tuple[str, ...]:
        """The units that are given, or the SI one."""
        return self.unit or (DEFAULT[self.kind],)

    def factors(self, n: int) -> Array:
        """What each column is multiplied by, shape (n,)."""
        factors = np.array([factor(self.kind, unit) for unit in self.units]) * np.ones(n)
        for values in (self.sign, self.rated):
            if values:
                factors = factors * values
        return factors

    def check(self, n: int, source: str) -> None:
        """Refuse lists that are not as long as the robot has joints.

        Raises:
            InputError: names the list.
        """
        lists = {"unit": self.unit[1:] and self.unit, "sign": self.sign, "zero": self.zero, "rated": self.rated}
        lists["columns"] = self.columns if len(self.columns) > 1 or "{" not in "".join(self.columns) else ()
        for name, values in lists.items():
            if values and len(values) != n:
                raise InputError(f"{source}: {self.kind}.{name} has {len(values)} entries, the robot {n} joints")


@dataclass(frozen=True)
class FilePart:
    """One of several files that together make a log: ``name`` within the folder, and its layout."""

    name: str
    layout: Layout


@dataclass(frozen=True)
class LogMap:
    """How to read a log; without arguments the standard CSV in SI units.

    Attributes:
        source: where it came from, for messages.
        layout: of a text file.
        files: the files of a log that is a folder.
        time: column of time; empty with ``rate``.
        time_unit: of ``units.TIME``.
        rate: even sampling rate [Hz] of a log without a column of time.
        quantities: what the log holds; kinds that are absent go by the standard names.
        joints: names of the joints, base to tip.
        gears: qm = G q, motor positions from joint positions, as rows of n; empty where nothing is on motor side.
        pose: columns of the tool's pose.
        references: (kind of ``REFERENCES``, columns, units) of what the controller wanted; else by standard names.
    """

    source: str = "log map"
    layout: Layout = Layout()
    files: tuple[FilePart, ...] = ()
    time: str = "t"
    time_unit: str = "s"
    rate: float | None = None
    quantities: tuple[Quantity, ...] = field(default=())
    joints: tuple[str, ...] = ()
    gears: tuple[tuple[float, ...], ...] = ()
    pose: ToolColumns | None = None
    references: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = ()

    def __post_init__(self) -> None:
        """Refuse motor sides without gears, unknown time units and rates without meaning."""
        factor("time", self.time_unit)
        if bool(self.time) == (self.rate is not None):
            raise ValueError("a log has either a column of time or a rate")
        if self.rate is not None and not 0.0 < self.rate < 1e9:
            raise ValueError(f"rate_hz must be positive, got {self.rate}")
        if any(quantity.side == "motor" for quantity in self.quantities) and not self.gears:
            raise ValueError("motor side without gear ratios: give [motor] gear_ratios")
        if self.gears and abs(np.linalg.det(self.G)) < 1e-9:
            raise ValueError("gear ratios: a motor does not turn with its joint (ratio 0)")
        if len(set(self.joints)) != len(self.joints):
            raise ValueError("a joint is named twice")

    @cached_property
    def G(self) -> Array:  # noqa: N802  the paper's (8): q_r = G q
        """The gears as a matrix, n x n."""
        return np.array(self.gears)

    def quantity(self, kind: str) -> Quantity:
        """What is said of one quantity, or the standard."""
        return next((q for q in self.quantities if q.kind == kind), Quantity(kind))

    def reference(self, kind: str) -> Quantity:
        """What is said of a reference: side, sign and zero are those of the measured quantity, a torque's side is
        the joint's; units are a position's own, N·m or N for a torque, unless they are given.

        Args:
            kind: of ``REFERENCES``.
        """
        own = self.quantity(REFERENCES[kind])
        if kind == "torque_reference":
            own = Quantity("torque", sign=own.sign)
        _, columns, units = next((one for one in self.references if one[0] == kind), (kind, (), ()))
        return replace(own, columns=columns, unit=units or own.unit, rated=() if units else own.rated)

    def told(self, kind: str) -> bool:
        """Whether columns of a quantity are named."""
        return bool(self.quantity(kind).columns)

    def check(self, n: int) -> None:
        """Refuse a map for another number of joints.

        Raises:
            InputError: names the list.
        """
        for quantity in (*self.quantities, *(self.reference(kind) for kind, *_ in self.references)):
            quantity.check(n, self.source)
        for name, values in (("joints", self.joints), ("gear ratios", self.gears)):
            if values and len(values) != n:
                raise InputError(f"{self.source}: {len(values)} {name}, the robot has {n} joints")

    def si(self, kind: str, raw: Array) -> Array:
        """Numbers of a log as joint-side SI values, rows x n.

        Args:
            kind: of ``QUANTITIES``.
            raw: the columns, rows x n.
        """
        return self.converted(self.quantity(kind), raw)

    def converted(self, quantity: Quantity, raw: Array) -> Array:
        """The same for any quantity."""
        values = raw * quantity.factors(raw.shape[1])
        if quantity.side == "motor":  # (8) and by duality (9): tau = G' tau_m
            values = values @ self.G if quantity.kind == "torque" else values @ np.linalg.inv(self.G).T
        return values + quantity.zero if quantity.zero else values

    def with_quantity(self, quantity: Quantity) -> "LogMap":
        """The same with another entry for one quantity."""
        others = tuple(q for q in self.quantities if q.kind != quantity.kind)
        return replace(self, quantities=(*others, quantity))
