"""From a file to signals in SI units: recordings, poses of the tool, planned motions."""

import hashlib
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from msgspec import structs

from ...common.arrays import Array, Mask
from ...common.errors import InputError, encodable
from ...common.schema import WrongKeyError
from ...estimation.signals.recordings import cut, frozen_rows, origin, pieces, typical_step, without_held
from ...model import Processing, Recording, Robot
from ..extras import modules
from . import formats
from .columns import PLAIN, Naming, RawLog, check_missing, choose, in_a_row, recognised, time_column
from .csv_log import CsvLog
from .formats.ros_bag import ros_bag
from .map import CURRENT, SHORT, SI, Layout, LogMap, Quantity, factor

if TYPE_CHECKING:
    from ...estimation.diagnosis.kinematics import ToolPoses

_READERS: dict[str, Callable[[Path, Layout], RawLog]] = {
    ending: reader
    for module in modules(formats.__name__, formats.__path__).values()
    for ending, reader in module.READERS.items()
}
"""Readers by ending; everything else is text."""
LogPath = str | Path | Sequence[str | Path]  # a file or folder, or the files of one recording, one a signal
SUFFIXES = (".csv", ".csv.gz", ".tsv", ".tsv.gz", *_READERS)
"""Endings of the files of a folder that are taken for logs."""
_MOVES = 1e-3  # rad or m: a joint that covers less does not move
_SLOWEST = {"s": 0.5, "ms": 100.0, "us": 1e5, "ns": 1e8}
"""Longest step that each unit is taken for: robots are recorded at 10 Hz to 10 kHz, so units stay apart."""
_EPOCH = 1e8  # s: more than three years; such a time counts from 1970 or from the start of a machine
_MOST_REPEATED = 0.9  # of the rows
_SIGNAL = re.compile(
    "(?<![a-z])(?:(?P<position>q|pos|positions?|angles)|(?P<velocity>qd|dq|vel|velocity|velocities|speeds?)|"
    "(?P<torque>tau|torques?)|(?P<effort>efforts?)|(?P<current>i|currents?)|"
    "(?P<reference>qref|tauref))(?![a-z])",
    re.IGNORECASE,
)
"""Words in the name of a file that holds one signal of all joints."""
_OTHER_NAMES = re.compile(r"(?<![a-z])(effort|load|counts)(?![a-z])", re.IGNORECASE)
"""Names of torques that drivers also give to currents, percentages and counts."""
_MOST_FROZEN = 5.0  # percent of the rows


def open_log(path: LogPath, log_map: LogMap) -> RawLog:
    """Open a file, a ROS 2 bag's folder, or files of one recording: those of ``LogMap.files``, or one a signal."""
    if not isinstance(path, str | Path):
        paths = [Path(one) for one in path]
        if log_map.layout.name:
            raise InputError(f"{log_map.source}: [file] name has no effect on files that are named: omit it")
        label = paths[0].with_name(f"{paths[0].name} and {len(paths) - 1} more")
        return _side_by_side(label, paths, [log_map.layout] * len(paths))
    path, files = Path(path), log_map.files or ((log_map.layout,) if log_map.layout.name else ())
    is_bag = not files and (path / "metadata.yaml").is_file()
    reader = ros_bag if is_bag else _READERS.get(path.suffix.lower(), CsvLog)
    if log_map.layout.topic and reader is not ros_bag and path.exists():
        raise InputError(f"{path}: is not a ROS 2 bag and has no topics: omit topic")
    if files:
        if not path.is_dir():
            raise InputError(f"{path}: {log_map.source} needs the folder that holds {files[0].name}")
        return _side_by_side(path, [path / part.name for part in files], files)
    if not path.exists():
        raise InputError(f"{path}: no such file: check the path and the current folder")
    if not is_bag and not path.is_file():
        kind = "is a folder, but not a ROS 2 bag" if path.is_dir() else "is not a regular file"
        raise InputError(f"{path}: {kind}: give the path of a log file or of a ROS 2 bag")
    return reader(path, log_map.layout)


def _side_by_side(label: Path, paths: Sequence[Path], layouts: Sequence[Layout]) -> RawLog:
    """Files of one recording as one log, row by row; a joint's column that stands in all gets the signal's name."""
    logs, found, notes = list[RawLog](), dict[str, tuple[RawLog, str]](), list[str]()
    for path, layout in zip(paths, layouts, strict=True):
        if not path.is_file():
            raise InputError(f"{path}: no such file; {label.name} needs it")
        logs.append(_READERS.get(path.suffix.lower(), CsvLog)(path, layout))
    time = time_column(logs[0].names, PLAIN)
    shared = set(logs[0].names).intersection(*(log.names for log in logs[1:])) - {time}
    joints = tuple(name for name in logs[0].names if name in shared and len(logs) > 1)
    for log in logs:
        signal, _ = _signal_of(log.path)
        if joints and not signal:
            raise InputError(f"{log.path}: name it after its signal: position, velocity, torque or current")
        for name in log.names:
            found.setdefault(f"{name}_{signal}" if name in joints else name, (log, name))

    def read(columns: Sequence[str]) -> Array:
        there, clocks, used = dict[str, Array](), list[Array](), list[str]()
        for log in logs:
            clock = [time] if time in columns and time in log.names else []
            if asked := [name for name in columns if found[name][0] is log]:
                values = log.whole([*(found[name][1] for name in asked), *clock])
                there |= dict(zip(asked, values.T, strict=False))
                clocks += [values[:, -1]] * len(clock)
                used.append(log.path.name)
        rows = len(set(map(len, there.values()))) == 1
        if not rows or any(abs(own - clocks[0]).max() > typical_step(clocks[0]) for own in clocks[1:]):
            unlike = f"have not the same {'times' if rows else 'number of rows'}"
            raise InputError(f"{label}: {', '.join(used)} {unlike}: are they of one recording?")
        notes[:] = (f"{log.path.name}: {note}" for log in logs for note in log.notes)
        return np.column_stack([there[name] for name in columns])

    units = {name: log.units[own] for name, (log, own) in found.items() if own in log.units}
    sigma = next((log.gain_sigma for log in logs if log.gain_sigma is not None), None)
    return RawLog(label, tuple(found), read, joints=joints, units=units, notes=notes, gain_sigma=sigma)


def _signal_of(path: str | Path) -> tuple[str, str]:
    """The signal that a file holds of all joints, by the last word for one in its name, and the name without."""
    name = Path(path).name.partition(".")[0]
    *_, found = (None, *_SIGNAL.finditer(name))
    rest = name[: found.start()] + name[found.end() :] if found else ""
    return (str(found.lastgroup), str(Path(path).with_name(f"{rest}.csv"))) if found else ("", "")


def grouped(paths: Sequence[str | tuple[str, ...]]) -> list[str | tuple[str, ...]]:
    """Recordings of a list of logs: files whose names differ in the signal alone, one of positions, are one."""
    groups, result = dict[object, list[str]](), list[str | tuple[str, ...]]()
    for number, path in enumerate(paths):
        own = [path] if isinstance(path, str) else path
        groups.setdefault(_signal_of(own[0])[1] or number, []).extend(own)
    for group in groups.values():
        there = [path for path in group if len(group) > 1 and Path(path).is_file()]
        complete = sum(recognised(open_log(path, LogMap()).names).size > 0 for path in there) > 1
        result += group if complete or len(group) == 1 else [tuple(group)]
    return result


def named(path: LogPath, robot: Robot, log_map: LogMap | None) -> Naming:
    """Open a log by a map that fits the robot, and find out what its columns are called."""
    log_map = log_map or LogMap()
    log_map.check(robot.n)
    naming = Naming(open_log(path, log_map), log_map, robot)
    torque = log_map.torque
    if torque.rated or CURRENT.keys().isdisjoint(torque.unit):
        return naming
    # Columns of torques that hold currents, counts, or percent of an unknown torque need gains, as currents do.
    current = Quantity(naming.columns("torque"), torque.unit, sign=torque.sign)
    return replace(naming, log_map=structs.replace(log_map, torque=Quantity(), current=current))


def read_recordings(
    path: LogPath,
    robot: Robot,
    drive_gains: Sequence[float] | None = None,
    log_map: LogMap | None = None,
    processing: Processing | None = None,
) -> tuple[Recording, ...]:
    """Read one log: CSV, TSV (plain or gzip), NPZ, MAT, Parquet or a ROS 2 bag, split where rows are missing.

    Args:
        path: the file or folder, or the files of one recording, one a signal.
        robot: tells how many joints there are.
        drive_gains: torque per current of each motor, on the joint side [N·m/A or N/A], if currents are to be used;
            of coupled drives motor j's and motor k's torques act on joint j, as (9) says.
        log_map: which columns, units, side and signs; by default those of a recorder that is known, else t, q1,
            tau1 or i1 and so on in SI units.
        processing: settings, of which the cut-off says what a gap is; the robot's own by default.

    Returns:
        The recording, or its pieces between gaps; notes tell how it was read and which columns were ignored.

    Raises:
        InputError: names the file, line and column of whatever cannot be used.
    """
    recording, _ = read_beside(named(path, robot, log_map), drive_gains)
    return tuple(cut(recording, *pieces(recording.t, (processing or robot.processing).cutoff, recording.source)))


def read_recording(
    path: LogPath, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Recording:
    """Read a log without gaps, as ``read_recordings``; one that gaps split is refused.

    >>> read_recording("log.csv", robot).q.shape[1]
    6
    """
    first, *others = read_recordings(path, robot, drive_gains, log_map)
    if others:
        raise InputError(f"{origin(first)}: {first.notes[-1]}: read_recordings gives them, or split the file")
    return first


def read_beside(
    naming: Naming, drive_gains: Sequence[float] | None, reference: str = ""
) -> tuple[Recording, Array]:
    """Read one log whole, gaps in it, with one of ``REFERENCES`` [rad, m, N·m or N], N x n, or N x 0 without."""
    raw, log_map, robot, told = naming.raw, naming.log_map, naming.robot, list[str]()
    columns, chosen = choose(naming, drive_gains)
    # Units that the file itself tells, where the map says none.
    for option, kind in ((option, kind) for option, kind in SHORT.items() if kind in columns and kind in SI):
        stated, own = [raw.units.get(name, "") for name in columns[kind]], log_map.quantity(kind)
        if not any(stated) or own.unit:
            continue
        units = tuple(unit or SI[kind] for unit in stated)
        try:
            log_map = structs.replace(log_map, **{kind: structs.replace(own, unit=units)})
        except WrongKeyError as error:
            fault = f"column {columns[kind][0]!r}: {error.problem}"
            raise InputError(f"{raw.path}: {fault} (or --units {option}={SI[kind]})") from None
        told.append(f"{kind} {', '.join(dict.fromkeys(units))}")
    notes = [f"units as the file tells them: {'; '.join(told)}"] if told else []
    asked = _OTHER_NAMES.search(columns.get("torque", ("",))[0]) if not log_map.torque.unit else None
    unit: Literal["named", "given", "unknown"] = "given" if log_map.torque.unit else "unknown" if asked else "named"
    if asked:
        notes.append(f"nothing tells the unit of {asked[0]}: N·m (or N) is taken; --units tau=.. says which it is")
    if reference:
        columns[reference] = naming.columns(reference)
    values = raw.whole(list(chain.from_iterable(columns.values())))
    if len(values) < 2:
        few = f"has {len(values)} rows of numbers, which is no recording"
        raise InputError(f"{raw.path}: {few}: record again, or give the file with the rows")
    t, since = np.arange(len(values)) / (log_map.time.rate or 1.0), 0.0
    time, unit_of_time = naming.time
    if time:
        t, later, since = _clock(raw, time, unit_of_time, values[:, 0], notes)
        values = values if later.all() else values[later]
    columns.pop("time", None)
    values, names = values[:, bool(time) :], list(chain.from_iterable(columns.values()))
    # What a logger wrote more than once is taken out: freezes, and samples that are held.
    frozen = frozen_rows(values, values[:, : robot.n])
    if count := int(np.sum(frozen[1:] & ~frozen[:-1])):
        share = 100.0 * float(frozen.mean())
        text = f"all columns stand still and then jump {count} time{'s' * (count > 1)} ({share:.2g} % of the rows)"
        if share > _MOST_FROZEN:
            first = raw.place(int(np.argmax(frozen)))
            raise InputError(f"{raw.path}: {text}, first at {first}: the logger froze; record without losing rows")
        notes.append(f"{text}: cut out")
        t, values = t[~frozen], values[~frozen]
    slowest = columns["current" if "current" in columns else "torque"]
    periods, rows, values = without_held(t, values, np.array([name in slowest for name in names]))
    if there := {name for name, period in zip(names, periods, strict=True) if period}:
        taken = f"thinned to {len(rows)} rows" if len(rows) < len(t) else "interpolated between these"
        kinds = [(kind, own, [name for name in own if name in there]) for kind, own in columns.items()]
        those = ", ".join(kind if len(held) == len(own) else in_a_row(held) for kind, own, held in kinds if held)
        rate = 1.0 / typical_step(t)
        notes.append(f"held samples: {those} change once in {periods.max():.2g} rows ({rate:.4g} Hz): {taken}")
    t = t[rows]
    parts = np.split(values, np.cumsum([len(names) for names in columns.values()])[:-1], axis=1)
    si = {kind: log_map.si(kind, part) for kind, part in zip(columns, parts, strict=True)}
    q, qd, load = si["position"], si.get("velocity"), si["current" if "current" in si else "torque"]
    read = hashlib.blake2b(np.ascontiguousarray(np.column_stack([t, q, load])).data, digest_size=16).hexdigest()
    torque, gains = load, tuple(drive_gains) if "current" in si and drive_gains is not None else ()
    if gains:
        torque = load * np.array(gains, dtype=float)
        torque = robot.coupling.joint_torques(torque) if robot.coupling else torque
    notes = [*raw.notes, *notes, *chosen]
    unmoved = ~qd.any(axis=0) & (np.ptp(q, axis=0) > _MOVES) if qd is not None else np.zeros(robot.n, dtype=bool)
    if joints := ", ".join(str(j + 1) for j in np.flatnonzero(unmoved)):
        qd = None
        notes.append(f"speeds of joint {joints} are zero throughout: taken from positions")
    if joints := ", ".join(str(j + 1) for j in np.flatnonzero(np.ptp(load, axis=0) == 0.0)):
        notes.append(f"torque of joint {joints}: one number throughout, a dead channel; left out if others suffice")
    name, noted = encodable(str(raw.path)), tuple(f"{encodable(raw.path.name)}: {note}" for note in notes)
    recording = Recording(t, q, torque, qd, name, noted, read, gains, since, raw.gain_sigma, unit)
    return recording, si.get(reference, q[:, :0])


def _clock(raw: RawLog, column: str, unit: str, values: Array, notes: list[str]) -> tuple[Array, Mask, float]:
    """Seconds of a log's column of time, in ``unit`` or, where that is empty, in the one that is found out.

    Only of rows that come later than the row before; then which rows those are, and what the column holds where
    seconds are 0 [s]. What is to be said of it joins ``notes``.
    """
    where, steps = f"{raw.path}: column {column!r}", np.diff(values)
    if (still := np.count_nonzero(steps == 0.0) / len(steps)) > _MOST_REPEATED:
        raise InputError(f"{where}: time does not advance in {100 * still:.0f} % of the rows: write more digits")
    if not unit:
        typical = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
        if len(steps) > 1 and (steps == 1.0).all():
            advice = "--units t=500Hz takes it for the number of a row (or another rate), --units t=ms for"
            raise InputError(f"{where} counts by ones: {advice} milliseconds")
        unit = next((unit for unit, slowest in _SLOWEST.items() if typical <= slowest), "")
        if not unit:
            raise InputError(f"{where}: {typical:g} from row to row fits no known unit of time: give --units t=..")
        if unit != "s":
            notes.append(f"time is in {unit} (steps of {typical:g}); --units t=.. takes another unit")
    scale = factor("time", unit)
    origin = float(values[0]) if values[0] * scale > _EPOCH else 0.0
    t = (values - origin) * scale
    if (steps < 0.0).any():
        k, advice = int(np.argmax(steps < 0.0)), "split the file there and give both parts"
        if (steps <= 0.0).all():
            advice = "all its rows are in reverse order: sort them by time"
        fault = f"column {column!r}: time runs backwards ({t[k]:g} s, then {t[k + 1]:g} s)"
        raise InputError(f"{raw.path}: {raw.place(k + 1)}, {fault}: {advice}")
    later = np.append(True, np.diff(t) > 0.0)
    if repeated := len(t) - int(later.sum()):
        rows = "1 row repeats" if repeated == 1 else f"{repeated} rows repeat"
        notes.append(f"{rows} the time of the row before ({100 * repeated / len(t):.2g} %): left out")
    if (typical := typical_step(t[later])) > _SLOWEST["s"]:
        raise InputError(f"{where}: {typical:g} s from row to row: t must be in s; is it in ms? (--units t=ms)")
    return t[later], later, origin * scale


def read_tool_poses(path: LogPath, robot: Robot, log_map: LogMap | None = None) -> "ToolPoses | None":
    """Read joint positions and tool poses of a log; None if it has none.

    The map's ``pose`` names the columns; without it x, y, z [m] and qx, qy, qz, qw are taken, if there.
    """
    from ...estimation.diagnosis.kinematics import ToolPoses

    naming = named(path, robot, log_map)
    raw, log_map, pose = naming.raw, naming.log_map, naming.pose
    if pose is None:
        return None
    columns = (*naming.columns("position"), *pose.columns, *pose.rotation)
    check_missing(raw, columns)
    values = raw.whole(columns)
    if len(values) < 4:
        raise InputError(f"{raw.path}: {len(values)} rows of numbers: a tool pose is compared from 4 on")
    q, place, turn = np.split(values, [robot.n, robot.n + 3], axis=1)
    q, place = log_map.si("position", q), place * factor("position", pose.unit)
    if not pose.rotation:
        return ToolPoses(str(raw.path), q, place, None)
    from scipy.spatial.transform import Rotation

    if pose.form == "quaternion":
        norms = np.linalg.norm(turn, axis=1)
        k = int(np.argmax(abs(norms - 1.0)))
        if abs(norms[k] - 1.0) > 0.01:
            where = f"{raw.path}: {raw.place(k)}, columns {', '.join(pose.rotation)}"
            raise InputError(f"{where}: a quaternion of length {norms[k]:.3g}: it must be 1")
        turned = Rotation.from_quat(turn)
    else:
        turn = turn * factor("position", pose.rotation_unit)
        turned = Rotation.from_euler("xyz", turn) if pose.form == "rpy" else Rotation.from_rotvec(turn)
    return ToolPoses(str(raw.path), q, place, np.asarray(turned.as_matrix()))


def read_trajectory(path: str | Path, robot: Robot) -> tuple[Array, Array, Array | None, Array | None]:
    """Read a planned motion: times, positions, and speeds and accelerations where the file has them, in SI units.

    From columns ``t``, ``q1..qn``, ``qd1..qdn`` and ``qdd1..qddn``; others are not used.
    """
    n, raw, columns = robot.n, open_log(path, LogMap()), ["t"]
    for kind in ("q", "qd", "qdd"):
        numbered = [f"{kind}{joint}" for joint in range(1, n + 1)]
        if kind != "q" and not set(numbered) & set(raw.names):
            break
        columns += numbered
    if missing := [name for name in columns if name not in raw.names]:
        found = f"column {', '.join(missing)} is missing for {n} joints; found {', '.join(raw.names)}"
        raise InputError(f"{path}: {found}")
    if f"q{n + 1}" in raw.names:
        raise InputError(f"{path}: column 'q{n + 1}', robot {robot.name!r} has {n} joints: is it the right one?")
    values = raw.whole(columns)
    if len(values) < 2:
        raise InputError(f"{path}: {len(values)} rows of numbers: a trajectory needs more")
    t, q, qd, qdd = np.split(values, [1, 1 + n, 1 + 2 * n], axis=1)
    t = t[:, 0]
    _, later, _ = _clock(raw, "t", "s", t, [])
    if not later.all():
        where = raw.place(int(np.argmin(later)))
        raise InputError(f"{raw.path}: {where}, column 't': time does not advance: remove the repeated rows")
    steps = np.diff(t)
    k = int(np.argmax(steps))
    if steps[k] > max(10.0 * typical_step(t), 0.25):
        fault = f"column 't': {steps[k]:g} s missing after {t[k]:g} s: plan every moment"
        raise InputError(f"{raw.path}: {raw.place(k + 1)}, {fault}")
    return t, q, qd if qd.shape[1] else None, qdd if qdd.shape[1] else None
