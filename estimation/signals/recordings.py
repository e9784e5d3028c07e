"""Recordings as they come: mistakes of unit and dead channels, gaps, and samples that a logger wrote again.

Mistakes are refused before any number is computed. Short gaps are interpolated later; at long ones a recording is
split before anything is filtered.
"""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np

from ...common import Array, Indices, InputError, Mask
from ...model import Recording, Robot
from ...model.robot import check_robot
from .filtering import monotone_cubic, taken

_MOST_TURNS = 4 * np.pi  # rad: no arm's joint goes further from zero
_BEYOND_LIMITS = 0.1  # of the range
_MOST_TORQUE = 1e5  # N·m or N: no arm's joint has more
_OVER_LIMIT = 3.0  # times the torque limit: sensors and currents overshoot, units are off by more
_MOVES = 1e-3  # rad or m: a joint that covers less does not move
_WEAKEST = 1.0  # N·m per cubic metre of reach: the lightest arms carry themselves with a hundred times this
_STRONGEST = 2e4  # N·m per cubic metre of reach: the strongest arms have a tenth of this
_OVER_SPEED = 3.0  # times the speed limit: noise and overshoot reach less
_MOST_SPEED = 50.0  # rad/s or m/s, for a joint without a limit
_WINDOW, _SEEN = 0.01, 0.05  # s: over which jumps, and speeds, are taken, to see past quantisation
_PLATEAU = 5  # samples in a row at the very extreme
_PLATEAU_SHARE = 0.01  # of the recording at the extreme
_PLATEAU_EXCESS = 20.0  # times as many samples as another level has: coarse numbers repeat everywhere


def check_given(robot: Robot, *groups: object) -> None:
    """Refuse what is no robot, no list of recordings, or of another number of joints."""
    check_robot(robot)
    for group in groups:
        if isinstance(group, Recording):
            raise InputError("a single recording: give a list of recordings, [recording]")
        if not isinstance(group, Sequence) or isinstance(group, str):
            raise InputError(f"recordings: give a list of them, not {group!r:.60}")
        for recording in group:
            if not isinstance(recording, Recording):
                raise InputError(f"{recording!r:.60} is no recording: give read_recording(path, robot)")
            if (n := recording.q.shape[1]) != robot.n:
                fault = f"{recording.source} is of {n} joints, robot {robot.name!r} has {robot.n}"
                raise InputError(f"{fault}: give the robot that was recorded")


def check_recordings(robot: Robot, *groups: Sequence[Recording]) -> None:
    """Refuse recordings whose units or channels cannot be right, and one that is given twice.

    ``groups``: recordings of one load, or those with payload, then those without.
    """
    for recordings in groups:
        if not recordings:
            raise InputError("no recordings: give at least one")
        for k, recording in enumerate(recordings):
            if earlier := next((earlier for earlier in recordings[:k] if _same(recording, earlier)), None):
                advice = "which would only make the result look more certain: give it once"
                raise InputError(f"{recording.source} has the same numbers as {earlier.source}, {advice}")
            if mistake := next(implausible(robot, recording), None):
                raise InputError(f"{recording.source}: {mistake}")
    for loaded, bare in product(*groups) if len(groups) > 1 else ():
        if _same(loaded, bare):
            without = f"{bare.source} without: give two recordings, one with and one without the payload"
            raise InputError(f"{loaded.source} with payload has the same numbers as {without}")


def without_dead(robot: Robot, recordings: Sequence[Recording]) -> Robot:
    """Take joints whose torque is one number throughout a recording as not measured, unless all are."""
    dead = {int(j) + 1 for own in recordings for j in np.flatnonzero(np.ptp(own.torque, axis=0) == 0.0)}
    if not 0 < len(dead) < robot.n:
        return robot
    return replace(robot, drives=replace(robot.drives, unmeasured=tuple(sorted(dead))))


def implausible(robot: Robot, recording: Recording) -> Iterator[str]:
    """Name everything that cannot be right with one recording, in text."""
    for check in (out_of_range, _motions, _torques):
        yield from check(robot, recording)


def out_of_range(robot: Robot, recording: Recording) -> Iterator[str]:
    """Say which joints leave their range, and whether as degrees, as a motor's, or by another zero."""
    turning = [(j, joint, recording.q[:, j]) for j, joint in enumerate(robot.joints) if joint.revolute]

    def outside(scale: float) -> dict[int, str]:
        found = {}
        for j, joint, q in turning:
            low, high = joint.limits.position
            margin = _BEYOND_LIMITS * (high - low) if np.isfinite(high - low) else 0.0
            low, high = max(low - margin, -_MOST_TURNS), min(high + margin, _MOST_TURNS)
            worst = scale * float(max(q.min(), q.max(), key=abs))
            if scale * q.min() < low or scale * q.max() > high:
                found[j + 1] = f"q{j + 1} reaches {worst:.4g} rad, outside {low:.3g} to {high:.3g}"
        return found

    still, found = still_joints([recording]), outside(1.0)
    if not found:
        return
    if 2 * len(found) < sum(j + 1 not in still for j, *_ in turning):
        advice = "its zero, sign or order differs: give zero_deg, sign or joints in a log map"
    elif not outside(np.radians(1.0)):
        advice = "all would fit as degrees, so add --units q=deg (motor positions need [motor] in a log map)"
    else:
        advice = "no joint turns that far, so these look like motor positions: give [motor] gear_ratios and side"
    more = f" (so do q{', q'.join(map(str, list(found)[1:]))})" if len(found) > 1 else ""
    first, text = next(iter(found.items()))
    yield f"{text}, the range of joint {first} of {robot.name} with a margin{more}: {advice}"


def _torques(robot: Robot, recording: Recording) -> Iterator[str]:
    lows, highs = recording.torque.min(axis=0), recording.torque.max(axis=0)
    worst, published = np.maximum(-lows, highs), not robot.assumed("torque")
    for j, joint in enumerate(robot.joints):
        most = min(_OVER_LIMIT * joint.limits.torque, _MOST_TORQUE) if published else _MOST_TORQUE
        if worst[j] > most:
            more = f"more than a joint of {robot.name} can give"
            advice = "state the unit of the torques, such as --units tau=mN·m for N·mm (--drive-gains are in N·m/A)"
            yield f"the torque of joint {j + 1} reaches {worst[j]:.4g} N·m, {more}: {advice}"
        if lows[j] == highs[j] and j + 1 not in robot.drives.unmeasured:
            yield f"the torque of joint {j + 1} is {lows[j]:g} throughout: the channel is dead"
    # Torques lie between the arm's own weight and what any arm of its size can give.
    if robot.n >= 5 and all(joint.revolute for joint in robot.joints) and any(robot.gravity):
        reach = sum(abs(one.d) + abs(one.r) for one in robot.joints[1:])
        if 0.0 < worst.max() < _WEAKEST * reach**3:
            little = f"too little for an arm of {reach:.2g} m reach to move its own weight"
            advice = "looks like kN·m or motor-side torque; torques must be in N·m at the joint"
            yield f"no torque exceeds {worst.max():.3g}, {little}: {advice}"
        if worst.max() > _STRONGEST * reach**3:
            much = f"too much for an arm of {reach:.2g} m reach, and looks like mN·m or mA"
            advice = "state the unit of the torques, such as --units tau=mN·m; drive gains are in N·m/A"
            yield f"the torque of joint {int(np.argmax(worst)) + 1} reaches {worst.max():.4g}, {much}: {advice}"
    # No torque stays at its very extreme while the arm moves: it was cut off; at rest it is held.
    speed = np.abs(np.gradient(recording.q, recording.t, axis=0))
    moves = (speed > robot.processing.still_speed).any(axis=1)
    for extreme in (lows, highs):
        for j, torque in enumerate(recording.torque.T):
            there = moves & (torque == extreme[j])
            fraction = float(np.mean(there))
            edges = np.flatnonzero(np.diff(there, prepend=False, append=False))
            longest = (edges[1::2] - edges[::2]).max(initial=0)  # run of rows
            if fraction < max(_PLATEAU_SHARE, _PLATEAU_EXCESS / len(np.unique(torque))) or longest < _PLATEAU:
                continue
            stays = f"stays at its extreme {extreme[j]:.4g} for {100 * fraction:.0f} % of the recording"
            yield f"the torque of joint {j + 1} {stays}: it is saturated; record a gentler motion"


def _motions(robot: Robot, recording: Recording) -> Iterator[str]:
    t, q, qd = recording.t, recording.q, recording.qd

    def slopes(seconds: float) -> tuple[int, Array]:
        """Choose a window in samples; slopes of the positions over it."""
        window = max(1, int(seconds * (len(t) - 1) / (t[-1] - t[0])))
        return window, (q[window:] - q[:-window]) / (t[window:] - t[:-window])[:, None]

    window, slope = slopes(_WINDOW)
    speeds = np.array([joint.limits.speed for joint in robot.joints])
    over = np.abs(slope) / np.where(np.isfinite(speeds), _OVER_SPEED * speeds, _MOST_SPEED)
    for j in np.flatnonzero(over.max(axis=0, initial=0.0) > 1.0):
        k = int(np.argmax(over[:, j]))
        yield (
            f"q{j + 1} jumps by {q[k + window, j] - q[k, j]:.3g} (rad or m) within {t[k + window] - t[k]:.3g} s at "
            f"{t[k]:.4g} s, which joint {j + 1} of {robot.name} cannot: lost samples, a stuck encoder, poses "
            "without the motion between them, or another unit; record the motion itself"
        )
    window, slope = slopes(_SEEN)
    if qd is None or len(slope) <= window:
        return
    moved = np.sum(slope**2, axis=0)
    both = np.sum(0.5 * (qd[window:] + qd[:-window]) * slope, axis=0)
    for j in np.flatnonzero((np.ptp(q, axis=0) >= _MOVES) & (moved > 0.0)):
        if not 0.8 < (ratio := both[j] / moved[j]) < 1.25:
            unit = "; the speed looks like degrees per second" if 45 < ratio < 70 else ""
            alike = "both must be in the same unit (rad and rad/s) and on the same time"
            yield f"qd{j + 1} is {ratio:.3g} times the slope of q{j + 1}{unit}: {alike}"


def _same(a: Recording, b: Recording) -> bool:
    return np.array_equal(a.torque, b.torque) and np.array_equal(a.q, b.q)


def still_joints(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """Numbers of the joints that move in none of the recordings."""
    spans = np.max([np.ptp(recording.q, axis=0) for recording in recordings], axis=0)
    return tuple(int(j) + 1 for j in np.flatnonzero(spans < _MOVES))


_PIECE = re.compile(r"( \(\S+ to \S+ s\))+$")  # pattern of the name that ``cut`` gives to a piece of a file
_GAP = 5.0  # median steps
_LOST = 1.5  # median steps: a longer one lacks rows
_SHORTEST = 2.0  # s
_FORGETS = 5.0  # time constants of the filter
_FEWEST = 20  # changes of a column that tell how often it changes
_REGULAR = 0.8  # of the spaces between changes that lie near the usual one
_QUANTUM = 0.5  # of the changes as large as the one before: more are steps of coarse numbers
_FROZEN = 3  # rows, and usual steps of a position after them


def shortest_piece(cutoff: float | None) -> float:
    """Shortest piece that is kept [s]: 2 s, or five time constants of the filter of a cut-off [Hz]."""
    return max(_SHORTEST, _FORGETS / (2.0 * math.pi * cutoff) if cutoff else 0.0)


def origin(recording: Recording) -> str:
    """Name the file that a recording, or the whole of which it is a piece, was read from."""
    return _PIECE.sub("", recording.source)


def pieces(t: Array, cutoff: float | None, source: str) -> tuple[list[slice], list[str]]:
    """Split a recording at its gaps, by its times [s]: stretches without one, and what to report of the gaps.

    A gap is longer than five median steps, and than half a period of the cut-off.

    ``cutoff``: of the filter that it will pass [Hz]; None without one.

    Raises:
        InputError: if gaps leave no stretch that is long enough to be filtered.
    """
    steps, typical = np.diff(t), typical_step(t)
    longest = max(_GAP * typical, 0.5 / cutoff if cutoff else 0.0)
    gaps, notes = np.flatnonzero(steps > longest), []
    lacking = steps[(steps > _LOST * typical) & (steps <= longest)].tolist()
    if lacking:
        rows = sum(max(1, round(step / typical) - 1) for step in lacking)
        most = f"{len(lacking)} step{'s' * (len(lacking) > 1)} of up to {max(lacking):.3g} s"
        notes.append(f"{rows} row{'s are' if rows > 1 else ' is'} missing ({most}): interpolated")
    if not len(gaps):
        return [slice(0, len(t))], notes
    least = shortest_piece(cutoff)
    every = [slice(start, stop) for start, stop in pairwise([0, *(gaps + 1).tolist(), len(t)])]
    lasts = [float(t[piece.stop - 1] - t[piece.start]) for piece in every]
    long_enough = [piece for piece, last in zip(every, lasts, strict=True) if last >= least]
    begins, worst = ", ".join(f"{begin:.4g}" for begin in t[gaps[:3]]) + " s", float(steps[gaps].max())
    begins += f" and {len(gaps) - 3} more" * (len(gaps) > 3)
    if not long_enough:
        left = f"gaps after {begins} ({worst:.3g} s at most) leave no {least:.2g} s without one"
        raise InputError(f"{source}: {left}: record without losing rows")
    note = f"split at {len(gaps)} gap{'s' * (len(gaps) > 1)} (after {begins}; {worst:.3g} s at most) into "
    note += f"{len(long_enough)} piece{'s' * (len(long_enough) > 1)}"
    if short := [last for last in lasts if last < least]:
        note += f"; {len(short)} shorter than {least:.2g} s left out ({sum(short):.3g} s)"
    return long_enough, [*notes, note]


def cut(recording: Recording, rows: Sequence[slice], notes: Sequence[str]) -> Iterator[Recording]:
    """Cut a recording into its pieces; a whole one stays as it is."""
    told = (f"{Path(recording.source).name}: {note}" for note in notes)
    recording = replace(recording, notes=(*recording.notes, *told))
    for piece in rows:
        if piece == slice(0, len(recording.t)):
            yield recording
            continue
        part, mark = taken(recording, piece), f"{recording.fingerprint} {piece.start} {piece.stop}".encode()
        yield replace(
            part,
            source=f"{recording.source} ({part.t[0]:.4g} to {part.t[-1]:.4g} s)",
            fingerprint=hashlib.blake2b(mark, digest_size=16).hexdigest() if recording.fingerprint else "",
        )


def typical_step(t: Array) -> float:
    """Median time between rows [s]."""
    return float(np.median(np.diff(t))) if len(t) > 1 else 0.0


def frozen_rows(values: Array, positions: Array) -> Mask:
    """Mark rows that repeat the one before in all columns until a position jumps, shape (N,).

    A robot at rest goes off by small steps; after a freeze the first step is several times those around it.
    """
    frozen = np.zeros(len(values), dtype=bool)
    steps = np.abs(np.diff(positions, axis=0))
    edges = np.flatnonzero(np.diff((values[1:] == values[:-1]).all(axis=1), prepend=False, append=False))
    lengths = edges[1::2] - edges[::2]
    least = _FROZEN * (1.0 + np.median(lengths) if len(lengths) >= _FEWEST else 1.0)  # held samples repeat too
    for first, last, length in zip(edges[::2], edges[1::2], lengths, strict=True):
        if length < least or last == len(steps):
            continue
        before, after = steps[max(0, first - 2 * length) : first], steps[last + 1 : last + 1 + 2 * length]
        usual = [np.median(own[own > 0.0]) if own.any() else np.inf for own in np.vstack([before, after]).T]
        if (steps[last] > _FROZEN * np.array(usual)).any():
            frozen[first + 1 : last + 1] = True
    return frozen


def without_held(t: Array, values: Array, slowest: Mask) -> tuple[Array, Indices, Array]:
    """Take columns that are held between the samples of a slower signal at these alone.

    Rows are left at which one of the columns ``slowest`` changes, where all of these are held; else all rows. There
    any other held column is interpolated between its own samples.

    ``t``: times [s], shape (N,); ``values``: numbers as they stand in the log, N x k; ``slowest``: marks torques,
    which would count as measured where they are interpolated, shape (k,).

    Returns:
        Rows of the log to a sample of each column, 0 where it is not held; rows that are left; all values there.
    """
    changes = values[1:] != values[:-1]
    periods = np.zeros(values.shape[1])
    for k, column in enumerate(values.T):
        changed = np.flatnonzero(changes[:, k]) + 1
        # Coarse numbers repeat too, but change by one quantum at a time, and a joint at rest changes seldom.
        spaces, jumps = np.diff(changed), np.abs(column[changed] - column[changed - 1])
        usual = float(np.median(spaces)) if len(spaces) >= _FEWEST else 0.0
        near = (spaces >= 0.5 * usual) & (spaces <= 2.0 * usual)
        alike = np.abs(np.diff(jumps)) <= 1e-6 * jumps[1:]
        if usual >= 2.0 and near.mean() >= _REGULAR and alike.mean() <= _QUANTUM:
            periods[k] = spaces[near & (spaces < 1.5 * usual)].mean()
    rows, alive = np.arange(len(t)), periods[slowest][changes[:, slowest].any(axis=0)]
    if alive.all() and len(alive):
        rows = _sampled(changes[:, slowest].any(axis=1), alive.min())
    left = values[rows]
    for held in np.flatnonzero(periods):
        own = _sampled(changes[:, held], periods[held])
        times = np.clip(t[rows], t[own[0]], t[own[-1]])
        left[:, held] = monotone_cubic(t[own], values[own, held])(times)
    return periods, rows, left


def _sampled(changes: Mask, period: float) -> Indices:
    """Rows of the samples: where values change, and between these where a sample equals the one before."""
    changed = np.append(0, np.flatnonzero(changes) + 1)
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(np.diff(changed) / period))))
    return np.asarray(np.rint(np.interp(np.arange(number[-1] + 1), number, changed)), dtype=np.intp)
