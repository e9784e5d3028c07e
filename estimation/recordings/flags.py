"""A log map's entries from the command line."""

from collections.abc import Sequence
from dataclasses import replace

from ...common.errors import InputError
from .mapping import LogMap, Quantity

_SHORT = {"t": "time", "q": "position", "qd": "velocity", "tau": "torque", "i": "current"}


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
