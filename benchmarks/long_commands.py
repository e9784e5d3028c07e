"""Commands on long logs: peak memory and processor time of ``identify`` and ``payload`` as the recordings grow.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/long_commands.py [--minutes 3,15,60] [--command identify|payload]

A Panda with the cylinders that stand for its links, seven joints at 1 kHz, motion that never repeats, noise on the
torques; CSV files of positions and torques in a temporary folder. Every command runs in a process of its own.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from dynident.common.arrays import Array
from dynident.estimation.possible.prior import cylinder_prior
from dynident.model import InertialParameters, Motion, Robot, load_robot
from dynident.trajectories import Simulator

RATE = 1000.0
PIECE = 20_000
NOISE = np.array([0.4, 0.4, 0.3, 0.3, 0.15, 0.15, 0.1])
"""N·m."""
PAYLOAD = InertialParameters.from_com(1.5, [0.01, -0.02, 0.05], np.diag([0.004, 0.005, 0.003]))


def panda() -> Robot:
    """A Panda whose links are cylinders of 17 kg in all, its joints rubbing a little."""
    robot = load_robot("panda").with_offsets(True)
    values = {f"OFF{j}": 0.1 * j for j in range(1, 8)}
    values |= {f"{kind}{j}": 0.3 for j in range(1, 8) for kind in ("FS", "FV")}
    for link, body in enumerate(cylinder_prior(robot, 17.0).bodies, 1):
        values |= body.named(str(link))
    return replace(robot, parameters=values)


def motion(robot: Robot, start: int, stop: int, seed: int) -> Motion:
    """Sines around the middle of the range, of frequencies that do not fit together."""
    draw, t = np.random.default_rng(seed), np.arange(start, stop) / RATE
    w, phase = 2 * np.pi * draw.uniform(0.05, 0.45, (5, 7)), draw.uniform(0.0, 6.0, (5, 7))
    a = draw.uniform(0.5, 1.0, (5, 7)) * 0.07 / w**0.5
    low, high = np.array([joint.limits.position for joint in robot.joints]).T
    angle = w * t[:, None, None] + phase
    a = a * (high - low)
    q = 0.5 * (low + high) + (a * np.sin(angle)).sum(1)
    return Motion(t, q, (a * w * np.cos(angle)).sum(1), -(a * w**2 * np.sin(angle)).sum(1))


def write(path: Path, minutes: float, load: InertialParameters | None, seed: int) -> None:
    """One log, a piece at a time."""
    robot = panda()
    simulator, rows = Simulator(robot), int(minutes * 60 * RATE)
    with path.open("w") as stream:
        stream.write("t," + ",".join(f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 8)) + "\n")
        for start in range(0, rows, PIECE):
            exact = simulator.measure(motion(robot, start, min(start + PIECE, rows), 0), load)
            noise = NOISE * np.random.default_rng([seed, start]).standard_normal(exact.torque.shape)
            np.savetxt(stream, _table(exact.motion, exact.torque + noise), delimiter=",", fmt="%.5f")


def _table(moved: Motion, torque: Array) -> Array:
    return np.column_stack([moved.t, moved.q, torque])


def run(command: list[str]) -> tuple[float, float]:
    """Processor seconds and peak memory [MiB] of one command."""
    code = "import sys; from dynident.cli import main; sys.exit(main())"
    process = subprocess.Popen([sys.executable, "-c", code, *command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        raise SystemExit(f"failed: {' '.join(command)}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def main() -> None:
    """Write logs, run the command, print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", default="3,15,60")
    parser.add_argument("--command", choices=("identify", "payload"), default="identify")
    parser.add_argument("--keep", type=Path, help="folder for the logs and the answers instead of a temporary one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        for minutes in map(float, arguments.minutes.split(",")):
            logs = [folder / f"{kind}_{minutes:g}.csv" for kind in ("unloaded", "loaded")]
            needed = logs[:1] if arguments.command == "identify" else logs
            for seed, log in enumerate(needed):
                if not log.exists():
                    write(log, minutes, PAYLOAD if seed else None, seed)
            answer = folder / f"{arguments.command}_{minutes:g}.json"
            options = [f"--{name}={log}" for name, log in zip(("unloaded", "loaded"), needed, strict=False)]
            options = [f"--data={logs[0]}"] if arguments.command == "identify" else options
            seconds, peak = run(
                [arguments.command, "--robot", "panda", "--offsets", *options, "--json", str(answer)]
            )
            size = sum(log.stat().st_size for log in needed) / 2**20
            count = json.loads(answer.read_text())["data"]["equations"]
            title = f"{arguments.command}, {minutes:g} min ({size:.0f} MiB of text, {count} equations)"
            each = f"{seconds:.1f} s of processor time, {seconds / minutes:.2f} s a minute"
            print(f"{title}: {each}, peak {peak:.0f} MiB", flush=True)


if __name__ == "__main__":
    main()
