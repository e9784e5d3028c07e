"""Live: share of one core while 500 Hz are recorded, cost and memory of the moving window, false changes.

    python benchmarks/live.py [seconds] [empty recordings]

Asked for: 500 Hz for 60 s with at most 10 % of one core and 99.5 % of the samples; a window of 20 s updates in
20 ms; memory flat; no change told in 20 simulated recordings of an empty arm.
"""

import resource
import statistics
import sys
import time
import tracemalloc

import numpy as np
from dynident import estimation, live
from dynident.estimation.payload import LiveWeighing, MovingWindow
from dynident.model import Recording, load_robot
from dynident.tests.live.played import playing
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points


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


def empty(simulator: Simulator, seed: int) -> Recording:
    motion = random_via_points(simulator.robot, 14, seed=seed).motion(100.0)
    torque = simulator.measure(motion).torque
    noise = np.random.default_rng(seed).standard_normal(torque.shape) * np.array(RX90_NOISE)
    return Recording(motion.t, motion.q, torque + noise, motion.qd)


def weigh(count: int) -> None:
    simulator = Simulator(load_robot("rx90"))
    known = estimation.identify(simulator.robot, [empty(simulator, 1)]).estimate
    window = MovingWindow(simulator.robot, known)
    list(LiveWeighing(window).feed(empty(simulator, 2)))
    times = []
    for _ in range(10):
        begin = time.process_time()
        window.weighed()
        times.append(1e3 * (time.process_time() - begin))
    print(f"window of {window.seconds:.0f} s: {statistics.median(times):.0f} ms to solve it (CPU)")
    told, seconds, sizes = 0, 0.0, []
    tracemalloc.start()
    for seed in range(100, 100 + count):
        recording = empty(simulator, seed)
        weighing = LiveWeighing(MovingWindow(simulator.robot, known))
        list(weighing.feed(recording))
        told, seconds = told + len(weighing.changes), seconds + float(np.ptp(recording.t))
        sizes.append(tracemalloc.get_traced_memory()[0] / 2**20)
    print(f"{count} empty recordings, {seconds:.0f} s: {told} changes told")
    if sizes:
        print(f"memory after the first and the last of them: {sizes[0]:.1f} and {sizes[-1]:.1f} MiB")


if __name__ == "__main__":
    record(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
    weigh(int(sys.argv[2]) if len(sys.argv) > 2 else 20)
