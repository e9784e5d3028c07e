"""How a log becomes a recording: its layout, columns, units, sides and signs, by a file or the command line."""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from msgspec import field
from msgspec.structs import force_setattr, replace

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Real, Table, WrongKeyError, at, read_toml
from .quantity import QUANTITIES, REFERENCES, SI, Quantity, Reference, ToolColumns, factor
from .table import Layout, Texts, listed

_SHORT = {"t": "time", "q": "position", "qd": "velocity", "tau": "torque", "i": "current"}


class FilePart(Layout, frozen=True, kw_only=True):
    """One of several files that together make a log: ``name`` within the folder, and its layout."""

    name: str


class Time(Table, frozen=True):
    """The column of time and its unit ("s", "ms", "us" or "ns"), or the even sampling rate of a log without one.

    Empty: the column is found by its name, the unit by name or steps.
    """

    column: str = ""
    unit: str = ""
    rate: Real | None = field(default=None, name="rate_hz")

    def __post_init__(self) -> None:
        """Refuse unknown units and rates without meaning."""
        if self.rate is None:
            if self.unit:
                factor("time", self.unit)
        elif self.column or self.unit:
            raise ValueError("give rate_hz, or column and unit")
        elif not 0.0 < self.rate < 1e9:
            raise ValueError(f"rate_hz must be positive, got {self.rate}")


class _Coupling(Table, frozen=True):
    motor: int
    joint: int
    ratio: Real | None = None


class Gears(Table, frozen=True):
    """Gear ratios of the motors, and motors that turn with a joint that is not their own."""

    gear_ratios: tuple[Real, ...]
    coupling: tuple[_Coupling, ...] = ()

    def __post_init__(self) -> None:
        """Refuse motors that do not turn with their joints."""
        if self.gear_ratios and abs(np.linalg.det(self.matrix())) < 1e-9:
            raise ValueError("gear ratios: a motor does not turn with its joint (ratio 0)")

    def matrix(self) -> Array:
        """G of q_r = G q (8): ratios on the diagonal, couplings beside it, n x n."""
        n, matrix = len(self.gear_ratios), np.diag(self.gear_ratios)
        for number, coupling in enumerate(self.coupling, start=1):
            motor, joint = coupling.motor, coupling.joint
            if not (1 <= motor <= n and 1 <= joint <= n) or motor == joint:
                raise WrongKeyError(f"coupling[{number}]", f"motor {motor} and joint {joint} are no two of {n}")
            ratio = self.gear_ratios[motor - 1] if coupling.ratio is None else coupling.ratio
            matrix[motor - 1, joint - 1] = ratio
        return matrix


class LogMap(Table, frozen=True, dict=True):
    """How to read a log; without arguments the standard CSV in SI units.

    Attributes:
        source: where it came from, for messages.
        joints: names of the joints, base to tip.
        layout: of a text file.
        files: the files of a log that is a folder.
        motor: gears, where anything is on the motor side.
        pose: columns of the tool's pose.
        position, velocity, torque, current: what the log holds; what is absent goes by the standard names.
        position_reference, torque_reference: what the controller wanted; else by standard names.
    """

    source: str = field(default="log map", name="title")
    joints: Texts = ()
    layout: Layout = field(default=Layout(), name="file")
    files: tuple[FilePart, ...] = ()
    time: Time = Time()
    motor: Gears | None = None
    pose: ToolColumns | None = None
    position: Quantity = Quantity()
    velocity: Quantity = Quantity()
    torque: Quantity = Quantity()
    current: Quantity = Quantity()
    position_reference: Reference | None = None
    torque_reference: Reference | None = None

    def __post_init__(self) -> None:
        """Refuse motor sides without gears, joints that are named twice, and what no quantity of a kind has."""
        force_setattr(self, "joints", listed(self.joints))
        for kind in QUANTITIES:
            with at(kind):
                self.quantity(kind).check_kind(kind)
        for kind in self._references():
            with at(kind):
                getattr(self, kind).check_kind(kind)
        if any(self.quantity(kind).side == "motor" for kind in QUANTITIES) and not self.motor:
            raise ValueError("motor side without gear ratios: give [motor] gear_ratios")
        if len(set(self.joints)) != len(self.joints):
            raise ValueError("a joint is named twice")

    @cached_property
    def G(self) -> Array:  # noqa: N802  the paper's (8): q_r = G q
        """The gears as a matrix, n x n; empty without gears."""
        return self.motor.matrix() if self.motor else np.zeros((0, 0))

    def quantity(self, kind: str) -> Quantity:
        """What is said of one quantity."""
        quantity: Quantity = getattr(self, kind)
        return quantity

    def _references(self) -> Iterator[str]:
        """The references of which something is said."""
        yield from (kind for kind in REFERENCES if getattr(self, kind))

    def reference(self, kind: str) -> Quantity:
        """What is said of a reference, of ``REFERENCES``: sign, side and zero are those of the measured quantity.

        A torque's side is the joint's. Units are a position's own, N·m or N for a torque, unless they are given.
        """
        measured, reference = self.quantity(REFERENCES[kind]), getattr(self, kind) or Reference(())
        if kind == "torque_reference":
            measured = Quantity(sign=measured.sign)
        rated = () if reference.unit else measured.rated
        return replace(measured, columns=reference.columns, unit=reference.unit or measured.unit, rated=rated)

    def check(self, n: int) -> None:
        """Refuse a map for another number of joints."""
        for kind in QUANTITIES:
            self.quantity(kind).check(kind, n, self.source)
        for kind in self._references():
            self.reference(kind).check(REFERENCES[kind], n, self.source)
        for name, values in (("joints", self.joints), ("gear ratios", self.G)):
            if len(values) not in (0, n):
                raise InputError(
                    f"{self.source}: {len(values)} {name}, the robot has {n} joints: give one for each joint"
                )

    def si(self, kind: str, raw: Array) -> Array:
        """Numbers of a log as joint-side SI values, rows x n.

        Args:
            kind: of ``QUANTITIES`` or ``REFERENCES``.
            raw: the columns, rows x n.
        """
        quantity = self.reference(kind) if kind in REFERENCES else self.quantity(kind)
        kind = REFERENCES.get(kind, kind)
        values = raw * quantity.factors(kind, raw.shape[1])
        if quantity.side == "motor":  # (8) and by duality (9): tau = G' tau_m
            values = values @ self.G if kind == "torque" else values @ np.linalg.inv(self.G).T
        return values + quantity.zero if quantity.zero else values


def read_log_map(path: str | Path) -> LogMap:
    """Read a log map; docs/logs.md tells its keys.

    Raises:
        InputError: names the file and the key.
    """
    return replace(read_toml(path, LogMap), source=str(path))


def with_units(log_map: LogMap, kind: str, names: Sequence[str], units: Mapping[str, str], source: str) -> LogMap:
    """A log map with the units that the file itself tells of a quantity's columns, where the map says none.

    Raises:
        InputError: if a unit is not known.
    """
    stated = tuple(units.get(name, "") for name in names)
    quantity = log_map.quantity(kind)
    if quantity.unit or not any(stated):
        return log_map
    short = next(name for name, of in _SHORT.items() if of == kind)
    try:
        for unit in stated:
            factor(kind, unit or SI[kind])
        changed = replace(quantity, unit=tuple(unit or SI[kind] for unit in stated))
    except ValueError as error:
        raise InputError(
            f"{source}: column {names[0]!r}: {error} (--units {short}={SI[kind]} takes another one)"
        ) from None
    return replace(log_map, **{kind: changed})


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
        units: "q=deg", "tau=mN·m", "t=ms", ...; "t=500Hz" where a log has no time but that rate.
        signs: 1 or -1 for each joint, of positions, speeds, torques and currents alike: its sense is turned.
        topic: of a ROS bag.

    Raises:
        InputError: says which entry cannot be.
    """
    try:
        for entry in units:
            log_map = _with_unit(log_map, entry)
        for kind in QUANTITIES if signs else ():
            log_map = replace(log_map, **{kind: _turned(log_map.quantity(kind), signs)})
        if joints:
            log_map = replace(log_map, joints=tuple(joints))
        if topic:
            log_map = replace(log_map, layout=replace(log_map.layout, topic=topic))
    except WrongKeyError as fault:
        raise InputError(f"command line: {fault.problem}") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"command line: {error}") from None
    return log_map


def _with_unit(log_map: LogMap, entry: str) -> LogMap:
    """A log map with one unit of the command line, "q=deg"."""
    name, _, unit = entry.partition("=")
    if name not in _SHORT or not unit:
        raise InputError(f"--units {entry!r}: give q=, qd=, tau=, i= or t= with a unit, as q=deg")
    rate = re.fullmatch(r"([\d.]+) ?Hz", unit) if name == "t" else None
    before = getattr(log_map, _SHORT[name])
    changed = Time(rate=float(rate[1])) if rate else replace(before, unit=unit)
    return replace(log_map, **{_SHORT[name]: changed})


def _turned(quantity: Quantity, signs: Sequence[float]) -> Quantity:
    if quantity.sign:
        raise InputError("--signs and a sign in the log map: give only one of them")
    return replace(quantity, sign=tuple(signs))
