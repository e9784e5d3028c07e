"""Reading one hour at 1 kHz: peak memory against the size of the arrays, and time.

Run: python benchmarks/long_log.py [--minutes 60]

Writes a CSV of six joints to a temporary folder first; reads it in a process of its own, so that the peak is that
of reading alone.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.model import load_robot

RATE = 1000


def write(path: Path, rows: int) -> None:
    """A log of six joints in blocks."""
    draw = np.random.default_rng(0)
    with path.open("w") as stream:
        stream.write("t," + ",".join(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)) + "\n")
        for start in range(0, rows, 50_000):
            count = min(50_000, rows - start)
            table = draw.uniform(-1.0, 1.0, (count, 13))
            table[:, 0] = (start + np.arange(count)) / RATE
            np.savetxt(stream, table, delimiter=",", fmt="%.5f")


def read(path: Path) -> None:
    """Print rows, seconds of processor time, and the growth of the peak over what is loaded before [MiB]."""
    robot = load_robot("ur10e")
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    recording = read_recording(path, robot)
    seconds = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    arrays = (recording.t.nbytes + recording.q.nbytes + recording.torque.nbytes) / 2**20
    print(f"{len(recording.t)} rows in {seconds:.1f} s of processor time")
    print(
        f"arrays {arrays:.0f} MiB, peak while reading {peak / 1024:.0f} MiB, {peak / 1024 / arrays:.2f} times as "
        "much"
    )


def main() -> None:
    """Write, then read in another process."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--read", type=Path)
    arguments = parser.parse_args()
    if arguments.read:
        read(arguments.read)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.csv"
        write(path, int(arguments.minutes * 60 * RATE))
        print(f"{path.stat().st_size / 2**20:.0f} MiB of text", flush=True)
        subprocess.run([sys.executable, __file__, "--read", str(path)], check=True)


if __name__ == "__main__":
    main()
