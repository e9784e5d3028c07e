"""ROS 2 bags (a folder, or one .mcap or .db3 file) with messages of joint states, by the library rosbags."""

from array import array
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from ....common import Array, InputError
from ...extras import extra, reading
from ..columns import RawLog
from ..map import Layout

_FRANKA, _DYNAMIC = "franka_msgs/msg/FrankaRobotState", "control_msgs/msg/DynamicJointState"
_TYPES = (_FRANKA, "sensor_msgs/msg/JointState", _DYNAMIC)
"""Messages with joint states; of a bag that has several kinds the first is taken."""
_VALUE = "control_msgs/msg/InterfaceValue"
_DEFINITIONS = {
    _DYNAMIC: f"std_msgs/Header header\nstring[] joint_names\n{_VALUE}[] interface_values",
    _VALUE: "string[] interface_names\nfloat64[] values",
}
"""Of messages that neither a bag without definitions nor the library knows."""
_FIELDS = ("position", "velocity", "effort", "torque", "current")
_NEEDED = "reading a ROS bag needs rosbags: install dynident[logs]"
_LOOK = 200  # messages that are looked at for the names of joints


def ros_bag(path: Path, layout: Layout) -> RawLog:
    """Open a bag: columns ``t`` [s] and ``<joint>.position``, ``.velocity``, ``.effort``.

    Times are the messages' own stamps, or where these are zero the times of recording, from the first one on.
    """
    with _reader(path) as reader:
        kinds = {one.topic: one.msgtype for one in reader.connections if one.msgtype in _TYPES and one.msgcount}
        topics = sorted(topic for topic, kind in kinds.items() if kind in reader.typestore.fielddefs)
        if layout.topic and layout.topic not in topics:
            raise InputError(f"{path}: no joint states in {layout.topic!r}; found {', '.join(topics) or 'none'}")
        first = min((kinds[topic] for topic in topics), key=_TYPES.index, default="")
        usual = [layout.topic] if layout.topic else [topic for topic in topics if kinds[topic] == first]
        if len(usual) != 1:
            choice = f" ({', '.join(usual)}): choose one by topic in the log map"
            advice = f": record as MCAP, which defines {', '.join(kinds.values())}, or /joint_states"
            choice = choice if usual else advice if kinds else ": record /joint_states"
            raise InputError(f"{path}: {len(usual)} topics with joint states that can be read{choice}")
        (topic,) = usual
        messages = islice(_messages(reader, topic), _LOOK)
        seen = dict.fromkeys(chain.from_iterable(_values(message) for _, message in messages))
    if not seen:
        raise InputError(f"{path}: topic {topic} has no joint states")
    joints = tuple(dict.fromkeys(joint for joint, _ in seen))
    names = ["t", *(f"{joint}.{field}" for joint in joints for field in _FIELDS if (joint, field) in seen)]
    units = {f"{joint}.effort": "N·m" for joint in joints if kinds[topic] == _FRANKA}

    def read(columns: Sequence[str]) -> Array:
        places, stamps, numbers = [name.rpartition(".") for name in columns], list[int](), array("d")
        sought = {joint for joint, _, field in places if field != "t"}
        with _reader(path) as reader:
            for stamp, message in _messages(reader, topic):
                values = _values(message)
                missing = sorted(sought.difference(joint for joint, _ in values))
                if len(missing) == len(sought):  # other joints only, a gripper's on the same topic
                    continue
                if missing:
                    raise InputError(f"{path}: a message of {topic} lacks joint {missing[0]!r}, which others have")
                stamps.append(stamp)
                values["", "t"] = 1e-9 * (stamp - stamps[0])
                numbers.extend(values.get((joint, field), nan) for joint, _, field in places)
        return np.array(numbers).reshape(-1, len(columns))

    return RawLog(path, tuple(names), read, lambda row: f"message {row + 1}", joints, units)


def _values(message: Any) -> dict[tuple[str, str], float]:
    """Numbers of a message by joint and field."""
    if hasattr(message, "interface_values"):
        pairs = zip(message.joint_names, message.interface_values, strict=False)
        named = {joint: dict(zip(own.interface_names, own.values, strict=False)) for joint, own in pairs}
    else:
        state = getattr(message, "measured_joint_state", message)
        signals = [(field, getattr(state, field)) for field in _FIELDS[:3]]
        named = {joint: {field: x[k] for field, x in signals if len(x) > k} for k, joint in enumerate(state.name)}
    return {(joint, field): own[field] for joint, own in named.items() for field in _FIELDS if field in own}


@contextmanager
def _reader(path: Path) -> Iterator[Any]:
    highlevel, typesys = (extra(f"rosbags.{part}", _NEEDED) for part in ("highlevel", "typesys"))
    store = typesys.get_typestore(typesys.Stores.LATEST)
    for name, text in _DEFINITIONS.items():
        store.register(typesys.get_types_from_msg(text, name))
    kind, remedy = "a ROS 2 bag", "copy or record it again"
    with reading(path, kind, remedy), highlevel.AnyReader([path], default_typestore=store) as reader:
        yield reader


def _messages(reader: Any, topic: str) -> Iterator[tuple[int, Any]]:
    """Time [ns] and message."""
    connections = [connection for connection in reader.connections if connection.topic == topic]
    for connection, recorded, data in reader.messages(connections=connections):
        message = reader.deserialize(data, connection.msgtype)
        stamp = message.header.stamp
        yield stamp.sec * 1_000_000_000 + stamp.nanosec or recorded, message


READERS = {".mcap": ros_bag, ".db3": ros_bag}
