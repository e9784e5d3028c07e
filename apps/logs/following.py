"""A controller does better with a right number: what it missed before and after it was given one.

A payload that is right lets the controller predict more of the torque, so that less is left to its feedback: the
following error falls. The torque itself does not tell: the same motion needs the same one.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from msgspec import field

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Document
from ...estimation.fit.covariance import student95
from ...estimation.signals.alignment import aligned
from ...estimation.signals.rows import cut, moving_parts, pieces
from ...model import Motion, Recording, Robot
from .map import LogMap
from .read import LogPath, named, read_beside, read_recording

Missed = Literal["following error", "unpredicted torque", "torque"]
"""Commanded less measured position; measured torque less that which the controller predicted; the torque itself,
where the log holds neither."""
_Clear = Literal["fell", "rose", "no clear change"]
_BLOCK = 1.0  # s: errors of neighbouring samples are alike
_FEWEST = 4  # blocks
_MOVES = 1e-2  # rad or m: a joint that spans less is held


Following = tuple[Missed, Recording]
"""Errors that a controller left, in the place of torques [rad or m, N·m or N], and which."""


class Change(Document, frozen=True):
    """Root mean square of a joint, or of all, before and after, and by what share it fell, with 95 % interval.

    ``clear`` tells on which side of zero the interval lies.
    """

    name: str
    before: float
    after: float
    fall: float
    interval: tuple[float, float]
    clear: _Clear


class FollowingChange(Document, frozen=True):
    """Following errors before and after a payload was entered: the document of ``verify --json``."""

    kind: Missed = field(name="compared")
    tells: bool  # it shows anything of the number entered
    lag: float = field(name="lag_s")  # what the second recording's clock shows more [s]
    joints: tuple[Change, ...]  # those that move
    total: Change = field(name="all")  # all of them


def read_following(
    path: LogPath, robot: Robot, drive_gains: Sequence[float] | None = None, log_map: LogMap | None = None
) -> Following:
    """Read a log with what the controller wanted beside the usual columns.

    By standard names: ``qref1..n`` in the unit of the positions, or ``tauref1..n`` in N·m or N; else those that the
    log map names by ``position_reference`` or ``torque_reference``.
    """
    naming = named(path, robot, log_map)
    for quantity in ("position_reference", "torque_reference"):
        names = naming.columns(quantity)
        there = [name for name in names if name in naming.raw.names]
        if not there and not getattr(naming.log_map, quantity):
            continue
        if missing := [name for name in names if name not in there]:
            beside = f", but {there[0]} is there: record it for every joint" if there else ""
            raise InputError(f"{naming.raw.path}: no column {', '.join(missing)}{beside}")
        recording, wanted = read_beside(path, robot, drive_gains, log_map, quantity)
        kind: Missed = "following error" if quantity == "position_reference" else "unpredicted torque"
        error = wanted - recording.q if kind == "following error" else recording.torque - wanted
        recording = replace(recording, torque=error, qd=None, fingerprint="")
        rows, notes = pieces(recording.t, robot.processing.cutoff, recording.source)
        if len(rows) > 1:
            raise InputError(f"{naming.raw.path}: {notes[-1]}: give a log without gaps")
        return kind, next(cut(recording, rows, notes))
    return "torque", read_recording(path, robot, drive_gains, log_map)


def following_change(
    before: Following, after: Following, still_speed: float = 2e-3, max_mismatch: float = 0.05
) -> FollowingChange:
    """Compare what was missed on one and the same motion, with the old number in the controller and the new one.

    A joint below ``still_speed`` [rad/s or m/s] stands still; positions may differ by ``max_mismatch`` [rad or m].
    """
    (kind, old), (new_kind, new) = before, after
    if kind != new_kind:
        held = f"{old.source} holds the {kind}, {new.source} the {new_kind}"
        raise InputError(f"{held}: log the same columns in both")
    pair = aligned(old, new, None, max_mismatch)
    t, q, joints, block = pair.loaded.t, pair.loaded.q, list[int](), np.zeros(0, dtype=np.int_)
    if len(t) > 1:
        qd: Array = np.gradient(q, t, axis=0)
        moving = moving_parts(Motion(t, q, qd, np.zeros_like(qd)), still_speed)
        spans = q[moving].max(axis=0, initial=-np.inf) - q[moving].min(axis=0, initial=np.inf)
        joints = np.flatnonzero(spans > _MOVES).tolist()
        block = np.searchsorted(np.arange(t[0], t[-1], _BLOCK), t[moving], side="right")
    if not joints or len(np.unique(block)) < _FEWEST:
        raise InputError(f"{new.source}: less than {_FEWEST} s of common motion: give the whole recordings")
    squares = [np.square(recording.torque[moving]) for recording in (pair.unloaded, pair.loaded)]

    def change(name: str, joints: list[int]) -> Change:
        """Share by which the root mean square fell; the interval by leaving out blocks of time."""
        sums = np.array([[own[:, joints][block == b].sum() for own in squares] for b in np.unique(block)])
        total, count = sums.sum(axis=0), len(sums)
        if not (total > 0.0).all():
            raise InputError(f"{name}: nothing was missed at all: the reference is the measurement itself")
        logs = 0.5 * np.diff(np.log(np.vstack([total, total - sums])))[:, 0]
        half = student95(count - 1) * np.sqrt((count - 1.0) * np.var(logs[1:]))
        low, fall, high = (1.0 - np.exp(logs[0] + half * np.array([1.0, 0.0, -1.0]))).tolist()
        clear: _Clear = "fell" if low > 0.0 else "rose" if high < 0.0 else "no clear change"
        old_rms, new_rms = np.sqrt(total / (len(block) * len(joints))).tolist()
        return Change(name, old_rms, new_rms, fall, (low, high), clear)

    each = tuple(change(f"joint {j + 1}", [j]) for j in joints)
    return FollowingChange(kind, kind != "torque", pair.lag, each, change("all joints", joints))
