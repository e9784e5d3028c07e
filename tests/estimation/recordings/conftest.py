"""An arm, the signals of a log of it, and the same signals as a log of each format."""

import gzip
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.model import Recording, Robot, load_robot

Signals = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot("ur10e")


@pytest.fixture(scope="module")
def signals() -> Signals:
    draw = np.random.default_rng(0)
    rows = 400
    values = {kind: draw.uniform(-1.0, 1.0, (rows, 6)) for kind in ("q", "qd", "tau")}
    return {"t": 0.01 * np.arange(rows), **values}


NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


def as_csv(path: Path, signals: Signals) -> Path:
    header = ["t"] + [f"{kind}{j}" for kind in ("q", "qd", "tau") for j in range(1, 7)]
    table = np.column_stack(list(signals.values()))
    lines = [",".join(header), *(",".join(map(repr, row)) for row in table.tolist())]
    data = ("\n".join(lines) + "\n").encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


def as_npz(path: Path, signals: Signals) -> Path:
    arrays: dict[str, Any] = {kind: values.T if kind == "tau" else values for kind, values in signals.items()}
    np.savez(path, note=np.array("text"), gain=np.array(3.0), **arrays)
    return path


def as_mat5(path: Path, signals: Signals) -> Path:
    from scipy.io import savemat

    savemat(
        path, {"t": signals["t"], "q": signals["q"].T, "qd": signals["qd"], "tau": signals["tau"], "name": "run 1"}
    )
    return path


def as_mat7(path: Path, signals: Signals) -> Path:
    import h5py

    with h5py.File(path, "w", userblock_size=512) as data:
        for name, values in signals.items():
            data[name] = values.T.copy() if values.ndim == 2 else values[None]
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file")
    return path


def as_parquet(path: Path, signals: Signals) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns: dict[str, Any] = {"t": signals["t"], "mode": ["run"] * len(signals["t"])}
    columns |= {f"{kind}{j + 1}": signals[kind][:, j] for kind in ("q", "qd", "tau") for j in range(6)}
    pq.write_table(pa.table(columns), path)
    return path


MESSAGES = {
    "FrankaRobotState": "sensor_msgs/JointState measured_joint_state\nfloat64[7] ddq_d",
    "DynamicJointState": "string[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values",
}
"""Of messages that hold joint states: what follows the header."""


def as_bag(
    path: Path, signals: Signals, names: tuple[str, ...] = NAMES, gripper: bool = True, also: Sequence[str] = ()
) -> Path:
    """A ROS 2 bag whose joints stand in alphabetical order, with messages of a gripper in between.

    ``also``: kinds of messages that stand there instead of the arm's JointState.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.LATEST)
    store.register(
        get_types_from_msg("string[] interface_names\nfloat64[] values", "control_msgs/msg/InterfaceValue")
    )
    kinds = {kind: f"{'franka' if kind[0] == 'F' else 'control'}_msgs/msg/{kind}" for kind in also}
    for kind, name in kinds.items():
        store.register(get_types_from_msg(f"std_msgs/Header header\n{MESSAGES[kind]}", name))
    value = store.types["control_msgs/msg/InterfaceValue"]
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    clock = store.types["builtin_interfaces/msg/Time"]
    plugin = StoragePlugin.MCAP if path.name.startswith("mcap") else StoragePlugin.SQLITE3
    order = sorted(range(6), key=lambda j: names[j])
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        others = {kind: writer.add_connection(f"/{kind}", name, typestore=store) for kind, name in kinds.items()}
        for k, t in enumerate(signals["t"]):
            stamp = round(1e9 * t) + 1_700_000_000_123_456_789
            head = header(clock(stamp // 10**9, stamp % 10**9), "")
            rows = [np.ascontiguousarray(signals[kind][k, order]) for kind in ("q", "qd", "tau")]
            message = state(head, [names[j] for j in order], *rows)
            for kind, name in kinds.items():
                values = [
                    value(["position", "velocity", "effort"], np.array(own)) for own in zip(*rows, strict=True)
                ]
                content = (message, np.zeros(7)) if kind[0] == "F" else ([names[j] for j in order], values)
                other = store.types[name](head, *content)
                writer.write(others[kind], stamp, store.serialize_cdr(other, name))
            if not also:
                writer.write(connection, stamp, store.serialize_cdr(message, state.__msgtype__))
            if gripper and not also:
                finger_message = state(head, ["finger"], *(np.zeros(1) for _ in range(3)))
                writer.write(connection, stamp + 1, store.serialize_cdr(finger_message, state.__msgtype__))
    return path


def same(recording: Recording, signals: Signals) -> None:
    assert recording.qd is not None
    assert np.allclose(recording.t - recording.t[0], signals["t"], atol=1e-9)
    for values, kind in ((recording.q, "q"), (recording.qd, "qd"), (recording.torque, "tau")):
        assert np.array_equal(values, signals[kind])


FORMATS: dict[str, Callable[[Path, Signals], Path]] = {
    "a.csv": as_csv,
    "a.csv.gz": as_csv,
    "a.npz": as_npz,
    "five.mat": as_mat5,
    "seven.mat": as_mat7,
    "a.parquet": as_parquet,
}
