"""ROS 2 bags (a folder, or one .mcap or .db3 file) with sensor_msgs/JointState, by the library rosbags."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .map import Layout
from .table import RawLog, extra, reading

_TYPE = "sensor_msgs/msg/JointState"
_FIELDS = ("position", "velocity", "effort")
_LOOK = 200  # messages that are looked at for the names of joints


def ros_bag(path: Path, layout: Layout) -> RawLog:
    """Open a bag: columns ``t`` [s] and ``<joint>.position``, ``.velocity``, ``.effort``.

    Times are the messages' own stamps, or where these are zero the times of recording, from the first one on.
    """
    joints: dict[str, set[str]] = {}
    topic = layout.topic
    with _reader(path) as reader:
        topics = sorted({connection.topic for connection in reader.connections if connection.msgtype == _TYPE})
        if topic and topic not in topics:
            raise InputError(f"{path}: no topic {topic!r} with {_TYPE}; found {', '.join(topics) or 'none'}")
        if not topic and len(topics) != 1:
            choice = f" ({', '.join(topics)}): choose one by topic in the log map"
            raise InputError(
                f"{path}: {len(topics)} topics with {_TYPE}{choice if topics else ': record /joint_states'}"
            )
        topic = topic or topics[0]
        for count, (_, message) in enumerate(_messages(reader, topic)):
            for place, joint in enumerate(message.name):
                fields = {field for field in _FIELDS if len(getattr(message, field)) > place}
                joints[joint] = joints.get(joint, set()) | fields
            if count >= _LOOK:
                break
    if not joints:
        raise InputError(f"{path}: topic {topic} holds no joint states")
    names = ["t", *(f"{joint}.{field}" for joint, there in joints.items() for field in _FIELDS if field in there)]

    def read(columns: Sequence[str]) -> Array:
        with _reader(path) as reader:
            rows = _rows(path, topic, _messages(reader, topic), columns)
            return np.fromiter(chain.from_iterable(rows), float).reshape(-1, len(columns))

    return RawLog(path, tuple(names), read, lambda row: f"message {row + 1}", tuple(joints))


def _rows(
    path: Path, topic: str, messages: Iterable[tuple[int, Any]], columns: Sequence[str]
) -> Iterator[list[float]]:
    """Numbers of each message; those that hold other joints only (a gripper's on the same topic) are left out."""
    fields = [None if name == "t" else name.rsplit(".", 1) for name in columns]
    joints = {field[0] for field in fields if field}
    first: int | None = None
    for stamp, message in messages:
        place = {joint: k for k, joint in enumerate(message.name)}
        missing = sorted(joints - set(place))
        if len(missing) == len(joints):
            continue
        if missing:
            raise InputError(f"{path}: a message of {topic} lacks joint {missing[0]!r}, which others hold")
        first = stamp if first is None else first
        row = []
        for field in fields:
            values = getattr(message, field[1])[place[field[0]] :] if field else [1e-9 * (stamp - first)]
            row.append(float(values[0]) if len(values) else float("nan"))
        yield row


@contextmanager
def _reader(path: Path) -> Iterator[Any]:
    """An open bag."""
    highlevel, typesys = extra("rosbags.highlevel", "a ROS bag"), extra("rosbags.typesys", "a ROS bag")
    store = typesys.get_typestore(typesys.Stores.LATEST)
    kind, remedy = "a ROS 2 bag", "copy or record it again"
    with reading(path, kind, remedy), highlevel.AnyReader([path], default_typestore=store) as reader:
        yield reader


def _messages(reader: Any, topic: str) -> Iterator[tuple[int, Any]]:
    """Time [ns] and message."""
    connections = [connection for connection in reader.connections if connection.topic == topic]
    for connection, recorded, data in reader.messages(connections=connections):
        message = reader.deserialize(data, connection.msgtype)
        stamp = message.header.stamp
        own = stamp.sec * 1_000_000_000 + stamp.nanosec
        yield own or recorded, message
