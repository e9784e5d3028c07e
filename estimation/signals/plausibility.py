"""Checks for mistakes of unit and dead channels in recordings before any number is computed from them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ...common import Array, InputError
from ...model import Recording, Robot
from ...model.robot import check_robot

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
