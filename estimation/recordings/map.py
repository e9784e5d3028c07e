"""How a log becomes a recording: its layout, columns, units, sides and signs, by a file or the command line."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .quantity import REFERENCES, Quantity, ToolColumns, factor
from .table import Layout

_SHORT = {"t": "time", "q": "position", "qd": "velocity", "tau": "torque", "i": "current"}


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
        time_unit: "s", "ms", "us" or "ns".
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
    quantities: tuple[Quantity, ...] = ()
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
        """What is said of a reference, of ``REFERENCES``: sign, side and zero are those of the measured quantity.

        A torque's side is the joint's. Units are a position's own, N·m or N for a torque, unless they are given.
        """
        measured = self.quantity(REFERENCES[kind])
        if kind == "torque_reference":
            measured = Quantity("torque", sign=measured.sign)
        _, columns, units = next((entry for entry in self.references if entry[0] == kind), (kind, (), ()))
        return replace(
            measured, columns=columns, unit=units or measured.unit, rated=() if units else measured.rated
        )

    def names(self, kind: str) -> bool:
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
        """Numbers of any quantity's columns as joint-side SI values, rows x n."""
        values = raw * quantity.factors(raw.shape[1])
        if quantity.side == "motor":  # (8) and by duality (9): tau = G' tau_m
            values = values @ self.G if quantity.kind == "torque" else values @ np.linalg.inv(self.G).T
        return values + quantity.zero if quantity.zero else values

    def with_quantity(self, quantity: Quantity) -> "LogMap":
        """A map with another entry for one quantity."""
        others = tuple(q for q in self.quantities if q.kind != quantity.kind)
        return replace(self, quantities=(*others, quantity))


def with_flags(
    log_map: LogMap,
    joints: Sequence[str] = (),
    units: Sequence[str] = (),
    signs: Sequence[float] = (),
    topic: str = "",
) -> LogMap:
    """A log map with what the command line says instead.

    Args:
        log_map: from a file, or the standard.
        joints: names, base to tip.
        units: "q=deg", "tau=mN·m", "t=ms", ...
        signs: 1 or -1 for each joint, of positions, speeds, torques and currents alike: its sense is turned.
        topic: of a ROS bag.

    Raises:
        InputError: says which entry cannot be.
    """
    try:
        for entry in units:
            name, _, unit = entry.partition("=")
            if name not in _SHORT or not unit:
                raise InputError(f"--units {entry!r}: give q=, qd=, tau=, i= or t= with a unit, as q=deg")
            kind = _SHORT[name]
            if kind == "time":
                log_map = replace(log_map, time_unit=unit)
            else:
                log_map = log_map.with_quantity(replace(log_map.quantity(kind), unit=(unit,)))
        if signs:
            for kind in _SHORT.values():
                if kind != "time":
                    log_map = log_map.with_quantity(_turned(log_map.quantity(kind), signs))
        if joints:
            log_map = replace(log_map, joints=tuple(joints))
        if topic:
            log_map = replace(log_map, layout=replace(log_map.layout, topic=topic))
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"command line: {error}") from None
    return log_map


def _turned(quantity: Quantity, signs: Sequence[float]) -> Quantity:
    if quantity.sign:
        raise InputError("--signs and a sign in the log map: give only one of them")
    return replace(quantity, sign=tuple(signs))
