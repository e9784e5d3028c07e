"""Recording from a controller: CPU and samples kept.

    python benchmarks/live.py [SECONDS]

Asked for: 500 Hz for 60 s with at most 10 % of one core and 99.5 % of the samples.
"""

import resource
import sys

from dynident.apps import live
from dynident.tests.live.played import playing


def cpu() -> float:
    """CPU time of this process [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def record(seconds: float) -> None:
    with playing(rate=500) as player, live.Client("127.0.0.1", player.port) as client:
        client.start()
        recorder, begin = live.Recorder(client.rate, seconds), cpu()
        while not recorder.over:
            recorder.add(client.take())
        used = cpu() - begin
    share = recorder.count / (recorder.count + recorder.dropped)
    print(f"record 500 Hz, {seconds:g} s: {100 * used / seconds:.1f} % of one core, {100 * share:.2f} % of samples")


if __name__ == "__main__":
    record(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
