"""ROS 2 bags (a folder, or one .mcap or .db3 file) with sensor_msgs/JointState, by the library rosbags."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError
from .extras import extra
from .layout import Layout
from .table import BLOCK, RawLog, Table

_TYPE = "sensor_msgs/msg/JointState"
_FIELDS = {"position": "position", "velocity": "velocity", "effort": "effort"}
_LOOK = 200  # messages that are looked at for the names of joints


def ros_bag(path: Path, layout: Layout) -> RawLog:
    """Open a bag: columns ``t`` [s] and ``<joint>.position``, ``.velocity``, ``.effort``.

    Times are the messages' own stamps, or where these are zero the times of recording, from the first one on.

    Raises:
        InputError: if it is no bag, has no such topic, or rosbags is not installed.
    """
    joints: dict[str, set[str]] = {}
    topic = layout.topic
    with _reader(path) as (reader, store):
        topic = _topic(path, reader, topic)
        for count, (_, message) in enumerate(_messages(reader, store, topic)):
            for place, joint in enumerate(message.name):
                fields = {field for field in _FIELDS if len(getattr(message, field)) > place}
                joints[joint] = joints.get(joint, set()) | fields
            if count >= _LOOK:
                break
    if not joints:
        raise InputError(f"{path}: topic {topic} holds no joint states")
    names = ["t", *(f"{joint}.{field}" for joint, there in joints.items() for field in _FIELDS if field in there)]

    def blocks(wanted: Sequence[str]) -> Iterator[Table]:
        return _blocks(path, topic, wanted)

    return RawLog(path, tuple(names), blocks, lambda row: f"message {row + 1}", tuple(joints))


def _blocks(path: Path, topic: str, wanted: Sequence[str]) -> Iterator[Table]:
    """Messages that hold other joints only (a gripper's on the same topic) are left out."""
    columns = [name.rsplit(".", 1) for name in wanted if name != "t"]
    needed = {joint for joint, _ in columns}
    first: int | None = None
    rows: list[list[float]] = []
    with _reader(path) as (reader, store):
        for stamp, message in _messages(reader, store, topic):
            place = {joint: k for k, joint in enumerate(message.name)}
            if not needed & set(place):
                continue
            missing = sorted(needed - set(place))
            if missing:
                raise InputError(f"{path}: a message of {topic} lacks joint {missing[0]!r}, which others hold")
            first = stamp if first is None else first
            row = [1e-9 * (stamp - first)] if "t" in wanted else []
            for joint, field in columns:
                values = getattr(message, field)
                row.append(float(values[place[joint]]) if place[joint] < len(values) else float("nan"))
            rows.append(row)
            if len(rows) == BLOCK:
                yield Table(_ordered(wanted), np.array(rows))
                rows = []
    if rows:
        yield Table(_ordered(wanted), np.array(rows))


def _ordered(wanted: Sequence[str]) -> tuple[str, ...]:
    """The order of a row's numbers: time first."""
    return (*(["t"] if "t" in wanted else []), *(name for name in wanted if name != "t"))


@contextmanager
def _reader(path: Path) -> Iterator[tuple[Any, Any]]:
    """An open bag and its store of message types."""
    highlevel, typesys = extra("rosbags.highlevel", "a ROS bag"), extra("rosbags.typesys", "a ROS bag")
    exceptions = (extra("rosbags.rosbag2", "a ROS bag").ReaderError, extra("rosbags.highlevel", "").AnyReaderError)
    store = typesys.get_typestore(typesys.Stores.LATEST)
    try:
        with highlevel.AnyReader([path], default_typestore=store) as reader:
            yield reader, store
    except (*exceptions, OSError, KeyError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: not a ROS 2 bag that can be read ({error})") from None


def _topic(path: Path, reader: Any, topic: str) -> str:
    found = sorted({connection.topic for connection in reader.connections if connection.msgtype == _TYPE})
    if topic and topic not in found:
        raise InputError(f"{path}: no topic {topic!r} with {_TYPE}; found {', '.join(found) or 'none'}")
    if not topic and len(found) != 1:
        raise InputError(
            f"{path}: {len(found)} topics with {_TYPE}"
            + (f" ({', '.join(found)}): choose one by --topic" if found else ": record /joint_states")
        )
    return topic or found[0]


def _messages(reader: Any, store: Any, topic: str) -> Iterator[tuple[int, Any]]:
    """Time [ns] and message."""
    connections = [connection for connection in reader.connections if connection.topic == topic]
    for connection, recorded, data in reader.messages(connections=connections):
        message = reader.deserialize(data, connection.msgtype)
        stamp = message.header.stamp
        own = stamp.sec * 1_000_000_000 + stamp.nanosec
        yield own or recorded, message
