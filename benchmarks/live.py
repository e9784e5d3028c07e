"""Live: CPU of a recording and of the window's updates, memory over an hour, false and missed changes of payload.

    python benchmarks/live.py [record SECONDS] [update] [memory MINUTES] [empty HOURS] [told TRIALS]

Asked for: 500 Hz for 60 s with at most 10 % of one core and 99.5 % of the samples; a window of 20 s updates in
20 ms; memory flat over an hour; no change told in 20 empty hours; the smallest mass told within 3 s of motion.
Arms other than the RX90 have invented links and drives; noise is white, 5 % of each joint's torque.
"""

import resource
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from dynident import estimation
from dynident.apps import live
from dynident.benchmarks import invented
from dynident.estimation import Estimate
from dynident.estimation.payload import LiveWeighing, MovingWindow
from dynident.estimation.payload.change import ChangeWatch
from dynident.estimation.signals.live import BlockCutter
from dynident.model import InertialParameters, Recording, Robot
from dynident.tests.live.played import playing
from dynident.trajectories import Simulator, random_via_points

ARMS = ("rx90", "ur10e", "panda", "iiwa14", "gp7", "kr6_r900")
NOISE = 0.05
"""Of each joint's torque (rms)."""
MASSES = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0)  # kg


def cpu() -> float:
    """CPU time of this process [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def record(seconds: float) -> None:
    with playing(rate=500) as player, live.Client("127.0.0.1", player.port) as client, client.stream() as stream:
        recorder, begin = live.Recorder(stream.recipe, stream.rate, seconds), cpu()
        while not recorder.over:
            recorder.add(stream.take())
        used = cpu() - begin
    share = recorder.count / (recorder.count + recorder.dropped)
    print(f"record 500 Hz, {seconds:g} s: {100 * used / seconds:.1f} % of one core, {100 * share:.2f} % of samples")


class Arm:
    """A simulated arm, identified once from a recording without payload."""

    def __init__(self, name: str) -> None:
        """Identify it."""
        self.robot: Robot = invented.robot(name)
        self.simulator = Simulator(self.robot)
        self.known: Estimate = estimation.identify(self.robot, [self.recorded(1)]).estimate

    def recorded(self, seed: int, points: int = 14, payload: InertialParameters | None = None) -> Recording:
        """Torques on a planned path, with fresh noise."""
        motion = random_via_points(self.robot, points, seed=seed).motion(100.0)
        torque = self.simulator.measure(motion, payload).torque
        return noisy(Recording(motion.t, motion.q, torque, motion.qd), seed)


def noisy(recording: Recording, seed: int) -> Recording:
    torque = recording.torque
    size = NOISE * np.sqrt((torque**2).mean(axis=0))
    torque = torque + np.random.default_rng(seed).standard_normal(torque.shape) * size
    return Recording(recording.t, recording.q, torque, recording.qd)


def endless(first: Recording, seconds: float) -> Iterator[Recording]:
    """One path again and again, its noise anew, a second of rest that is not recorded in between."""
    period, seed = float(np.ptp(first.t)) + 1.0, 0
    while seed * period < seconds:
        part = noisy(first, 10_000 + seed)
        for rows in np.array_split(np.arange(len(part.t)), max(len(part.t) // 100, 1)):
            qd = part.qd[rows] if part.qd is not None else None
            yield Recording(part.t[rows] + seed * period, part.q[rows], part.torque[rows], qd)
        seed += 1


def update() -> None:
    """CPU of the parts of an update, once the window is full."""
    for name in ARMS[:2]:
        arm = Arm(name)
        window = MovingWindow(arm.robot, arm.known)
        watch, cutter, times = ChangeWatch(window), BlockCutter(arm.robot.processing), []
        for data in cutter.feed(arm.recorded(2, 60)):
            marks = [time.process_time()]
            block = window.block(data)
            if block is not None:
                window.add(block)
                marks.append(time.process_time())
                watch.change()
                marks.append(time.process_time())
                window.weighed()
                marks.append(time.process_time())
                times.append(np.diff(marks))
        parts = 1e3 * np.median(np.array(times[22:]), axis=0)
        each = ", ".join(
            f"{label} {ms:.1f}" for label, ms in zip(("equations", "change", "weighed"), parts, strict=True)
        )
        print(f"{name}: window of {window.seconds:.0f} s, an update {parts.sum():.1f} ms CPU ({each})", flush=True)


def resident() -> float:
    """Memory of this process that is in use [MiB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def memory(minutes: float) -> None:
    """Resident memory while an hour goes by, faster than it does."""
    arm, marks = Arm("rx90"), [m for m in (0.5, 10.0, 30.0, 60.0) if m <= minutes]
    weighing, begin = LiveWeighing(MovingWindow(arm.robot, arm.known)), cpu()
    updates = 0
    for recording in endless(arm.recorded(2), 60.0 * minutes + 1.0):
        updates += sum(1 for _ in weighing.feed(recording))
        while marks and recording.t[-1] >= 60.0 * marks[0]:
            print(f"after {marks.pop(0):g} min: {resident():.1f} MiB", flush=True)
    used = 1e3 * (cpu() - begin) / max(updates, 1)
    print(f"{updates} updates, {used:.1f} ms CPU each with samples; {len(weighing.changes)} changes told")


def watched(arm: Arm, recordings: Iterator[Recording] | list[Recording]) -> tuple[list[tuple[float, float]], float]:
    """When changes begin and are told [s], and the motion that was watched [s]; nothing is weighed."""
    window, cutter, changes, seconds = (
        MovingWindow(arm.robot, arm.known),
        BlockCutter(arm.robot.processing),
        [],
        0.0,
    )
    watch = ChangeWatch(window)
    for recording in recordings:
        for data in cutter.feed(recording):
            block = window.block(data)
            if block is None:
                continue
            window.add(block)
            seconds += block.stop - block.start
            change = watch.change()
            if change is not None:
                changes.append((change.time, block.stop))
                window.since(change.time + 0.5 * (block.stop - block.start))
    return changes, seconds


def empty(hours: float) -> None:
    """False changes, each arm an equal share of the time on paths of its own."""
    alarms, seconds, share = 0, 0.0, 3600.0 * hours / len(ARMS)
    for name in ARMS:
        arm, own, seed, false = Arm(name), 0.0, 100, 0
        while own < share:
            changes, length = watched(arm, [arm.recorded(seed, 200)])
            false, own, seed = false + len(changes), own + length, seed + 1
        print(f"{name}: {own / 3600.0:.2f} empty hours, {false} changes told", flush=True)
        alarms, seconds = alarms + false, seconds + own
    print(f"all: {alarms} changes told in {seconds / 3600.0:.2f} empty hours (asked 0 in 20)")


def told(trials: int) -> None:
    """The smallest mass that is told within 3 s of motion in every trial, put on after 25 s."""
    for name in ARMS:
        arm, passed = Arm(name), {}
        for mass in reversed(MASSES):
            body = InertialParameters.from_com(mass, [0.02, -0.01, 0.1], np.diag([0.004, 0.004, 0.002]) * mass)
            passed[mass] = sum(in_time(arm, body, seed) for seed in range(trials))
            if not passed[mass]:
                break
        sure = min((mass for mass, count in passed.items() if count == trials), default=float("nan"))
        shares = ", ".join(f"{mass:g} kg {count}/{trials}" for mass, count in passed.items())
        print(f"{name}: {sure:g} kg is always told within 3 s ({shares})", flush=True)


def in_time(arm: Arm, body: InertialParameters, seed: int) -> bool:
    """Whether one change is told, and by 3 s of motion after it."""
    bare, loaded = arm.recorded(300 + seed), arm.recorded(600 + seed, 6, body)
    put_on = float(bare.t[-1]) + 0.5
    changes, _ = watched(arm, [bare, Recording(loaded.t + put_on, loaded.q, loaded.torque, loaded.qd)])
    return len(changes) == 1 and put_on - 1.0 <= changes[0][0] and changes[0][1] <= put_on + 3.2


PARTS: dict[str, tuple[Callable[[float], None], float]] = {
    "record": (record, 60.0),
    "update": (lambda _: update(), 0.0),
    "memory": (memory, 60.0),
    "empty": (empty, 1.0),
    "told": (lambda trials: told(int(trials)), 3.0),
}

if __name__ == "__main__":
    words = sys.argv[1:] or list(PARTS)
    for place, word in enumerate(words):
        if word in PARTS:
            part, usual = PARTS[word]
            size = words[place + 1] if words[place + 1 : place + 2] and words[place + 1] not in PARTS else usual
            part(float(size))
