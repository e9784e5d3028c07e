"""Weighing by short motions: designed sigma, coverage on simulated noise, windows of real recordings, time.

Run: python benchmarks/weigh.py [--seeds 100] [--only design|coverage|changing|lasting|windows|time]. The real
recordings are found through the environment variable DYNIDENT_DATA and left out with a line where it is not set.
Figures in brackets are those asked for: sigma of the mass and of the centre of mass along z with the best of 60
random motions.
"""

import argparse
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Gains, KnownMass, PayloadAnswer, PossibleBody, answer_payload
from dynident.estimation.payload.constant_torques import OFFSET_SHARE
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.alignment import aligned
from dynident.model import InertialParameters, Recording, Robot, load_robot
from dynident.model.inertia import PayloadSpread
from dynident.trajectories import (
    Design,
    JointBounds,
    NearGoal,
    NearMotion,
    NearShape,
    Simulator,
    build_design,
    solve_design,
)
from dynident.trajectories.design.goal import second_pose

BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], np.diag([0.01, 0.01, 0.005]))
GAINS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)
WEIGHED = 2.805  # kg, of the real recordings
WAVES, RIPPLE = (8, 36), 0.04  # per turn; of a joint's torque, each wave: as ``dynident simulate`` has by default
LEVELS = {"ur10e": ((1.73, 3.01, 1.10, 0.37, 0.38, 0.31), 10.0), "rx90": ((7.6, 9.5, 3.4, 1.6, 2.1, 0.73), 25.0)}
POSES = {"ur10e": (0.0, -60.0, 90.0, -120.0, -90.0, 0.0), "rx90": (0.0, -45.0, 90.0, 0.0, 45.0, 0.0)}
RATES = {"ur10e": 100.0, "rx90": 250.0}  # Hz, of recordings; decimated by 10


@dataclass(frozen=True)
class Case:
    """What is designed, and the figures asked for: sigma of mass [kg] and of com z [mm]."""

    robot: str
    joints: tuple[int, ...]
    poses: int
    mass: float
    com: float
    scale: float | None = None


CASES = (
    Case("ur10e", (3, 5, 6), 2, 0.075, 6.5),
    Case("ur10e", (2, 3, 5, 6), 1, 0.045, 4.1),
    Case("rx90", (3, 5, 6), 2, 0.36, 21.0),
    Case("rx90", (2, 3, 5, 6), 1, 0.13, 8.4),
)
WEIGHED_CASES = (
    Case("ur10e", (3, 5, 6), 2, 0.02, 3.2, 0.02),
    Case("rx90", (3, 5, 6), 2, 0.02, 13.8, 0.02),
)


class Near(NamedTuple):
    """A motion near a pose, and what it will tell."""

    design: Design
    spread: PayloadSpread


def solved(case: Case) -> Near:
    """30 s, +-30 degrees; RX90 at half of its speed."""
    robot = load_robot(case.robot)
    noise, rate = LEVELS[case.robot]
    override, free = 0.5 if case.robot == "rx90" else 1.0, [np.inf] * robot.n
    bounds = JointBounds.of(robot, override=override, torque=free)
    ranges = np.full(len(case.joints), np.radians(30.0))
    pose = np.radians(POSES[case.robot])
    shape, goal = (
        NearShape(pose[None], case.joints, ranges, 30.0),
        NearGoal(np.array(noise), rate, BODY, case.scale),
    )
    second = second_pose(robot, shape, goal, bounds) if case.poses == 2 else None
    if second is not None:
        shape = replace(shape, poses=np.array([pose, second]))
    design = solve_design(build_design(robot, shape, goal, bounds=bounds), seed=0, starts=1)
    return Near(design, goal.predicted(robot, design.plan, case.joints))


def designs() -> list[Near]:
    """Sigma of designed motions beside the figures asked for."""
    print("Designed motions, 30 s, +-30 deg, 3 kg at 100 mm; sigma asked for in brackets")
    motions = []
    for case in (*CASES, *WEIGHED_CASES):
        begun = time.process_time()
        near = solved(case)
        cpu = time.process_time() - begun
        spread, good, plan = near.spread, near.design.feasible, near.design.plan
        assert isinstance(plan, NearMotion)
        joints = ",".join(map(str, case.joints))
        poses = len(plan.poses)
        weighed = f", weighed to {1e3 * case.scale:.0f} g" if case.scale else ""
        print(
            f"  {case.robot} joints {joints}, {poses} wrist pose{'s' * (poses > 1)}{weighed}: mass "
            f"{spread.mass:.3f} kg [{case.mass:g}], com z {1e3 * spread.com[2]:.1f} mm [{case.com:g}], largest com "
            f"{1e3 * spread.com.max():.1f} mm, inertia {spread.moments.max():.3f} kg m2, {cpu:.2f} CPU s [3], "
            f"limits {'kept' if good else 'MISSED'}"
        )
        motions.append(near)
    return motions[: len(CASES)]


def refusals() -> None:
    """Joints whose torques do not hold the mass."""
    for robot, joints in (("rx90", (4, 5, 6)), ("ur10e", (5, 6))):
        try:
            solved(Case(robot, joints, 1, 0.0, 0.0))
            print(f"  {robot} joints {joints}: NOT refused")
        except InputError as error:
            print(f"  {robot} joints {joints}: {error}")


def simulated_robot(name: str) -> Robot:
    """The robot with parameters to simulate it: the description's, or plain ones."""
    robot = load_robot(name)
    if robot.parameters:
        return robot
    values: dict[str, float] = {}
    for link, mass in enumerate((7.4, 13.0, 5.0, 2.1, 2.0, 0.6), 1):
        body = InertialParameters.from_com(mass, [0.0, 0.0, 0.05], 0.01 * mass * np.eye(3))
        values |= body.named(str(link)) | {f"IA{link}": 0.5, f"FS{link}": 5.0, f"FV{link}": 5.0, f"OFF{link}": 0.0}
    return replace(robot, parameters=values)


def weighed_once(
    robot: Robot, clean: list[Recording], noise: Array, seed: int, ripple: float | None
) -> PayloadAnswer:
    """With white noise on both recordings; with ``ripple``, that and changed constant torques on the loaded one."""
    draw = np.random.default_rng(seed)
    noisy = [
        replace(recording, torque=recording.torque + noise * draw.standard_normal(recording.torque.shape))
        for recording in clean
    ]
    if ripple is not None:
        friction = np.array([robot.parameters[f"FS{joint}"] for joint in range(1, robot.n + 1)])
        change = OFFSET_SHARE * friction * draw.standard_normal(robot.n)
        loaded = replace(noisy[1], torque=noisy[1].torque + change)
        amplitude = ripple * np.sqrt(np.mean(clean[0].torque ** 2, axis=0))
        phases = draw.uniform(-np.pi, np.pi, (len(WAVES), robot.n))
        waves = sum(amplitude * np.sin(w * loaded.q + phase) for w, phase in zip(WAVES, phases, strict=True))
        noisy[1] = replace(loaded, torque=loaded.torque + waves)
    return answer_payload(difference_weighing(robot, noisy[1:], noisy[:1]))


def coverage(motions: list[Near], seeds: int, ripple: float | None) -> None:
    """Share of 95 % intervals of the mass that hold the truth."""
    words = ""
    if ripple is not None:
        words = f"; with the payload constant torques change by {100 * OFFSET_SHARE:.1f} % of Coulomb friction"
    if ripple:
        words += f" and ripple of {100 * ripple:g} % of the torque comes"
    print(f"Coverage of the mass by 95 % intervals, white noise{words}, {seeds} seeds [92 to 99 %]")
    for case, near in zip(CASES, motions, strict=True):
        robot = simulated_robot(case.robot)
        simulator, motion = Simulator(robot), near.design.motion(RATES[case.robot])
        clean = [simulator.record(motion, load, None, source=str(k)) for k, load in enumerate((None, BODY))]
        noise = np.array(LEVELS[case.robot][0]) * np.sqrt(10.0)
        hits, errors, sigmas = 0, [], []
        for seed in range(seeds):
            answer = weighed_once(robot, clean, noise, seed, ripple)
            low, high = answer.mass_interval
            hits += low <= BODY.mass <= high
            errors.append(answer.free.ten[9] - BODY.mass)
            sigmas.append(answer.model.sigma[9])
        print(
            f"  {case.robot} joints {','.join(map(str, case.joints))}: {100 * hits / seeds:.0f} %; error of mass "
            f"{np.mean(errors):+.3f} +- {np.std(errors):.3f} kg, sigma as told {np.mean(sigmas):.3f} kg"
        )


def part(recording: Recording, start: float, length: float) -> Recording:
    """A window that starts ``start`` after the recording [s]."""
    t = recording.t - recording.t[0]
    keep = (t >= start) & (t < start + length)
    qd = recording.qd[keep] if recording.qd is not None else None
    return replace(recording, t=recording.t[keep], q=recording.q[keep], torque=recording.torque[keep], qd=qd)


def windows(folder: Path) -> None:
    """Windows of the real pair, within its motion; drive gains uncertain by 2 %."""
    print(f"Real UR10e windows, {WEIGHED} kg, gains uncertain by 2 % [10 s within 6 %, 20 s within 3 %, 90 % held]")
    robot = load_robot("ur10e")
    bare = read_recording(folder / "ur10e/unloaded.csv.gz", robot, GAINS)
    loaded = read_recording(folder / "ur10e/loaded_2.805kg.csv.gz", robot, GAINS)
    pair = aligned(bare, loaded, 100.0, 0.02)
    lag = pair.lag - (loaded.t[0] - bare.t[0])
    assert bare.qd is not None
    moving = np.flatnonzero(np.abs(bare.qd).max(axis=1) > 5e-3)
    moving = moving[bare.t[moving] > 2.0]  # before that it jogs to the start
    first, last = bare.t[moving[[0, -1]]] - bare.t[0]
    for length, step in ((10.0, 0.5), (20.0, 0.5), (30.0, 1.0)):
        masses, hits = [], 0
        for start in np.arange(first, last - length + 1e-9, step):
            both = part(bare, start, length), part(loaded, start + lag, length)
            answer = answer_payload(difference_weighing(robot, [both[1]], [both[0]]), gains=Gains((0.02,)))
            low, high = answer.mass_interval
            masses.append(answer.mass)
            hits += low <= WEIGHED <= high
        off = np.array(masses) / WEIGHED - 1.0
        print(
            f"  {length:.0f} s, {len(off)} windows: worst {100 * np.abs(off).max():.1f} %, mean "
            f"{100 * off.mean():+.2f} %, scatter {100 * off.std():.2f} %; held {100 * hits / len(off):.0f} %"
        )


def timing(folder: Path) -> None:
    """Reading, weighing and judging 30 s, once warm."""
    robot = load_robot("ur10e")
    for warm in (False, True):
        begun, cpu = time.perf_counter(), time.process_time()
        bare = part(read_recording(folder / "ur10e/unloaded.csv.gz", robot, GAINS), 5.0, 30.0)
        loaded = part(read_recording(folder / "ur10e/loaded_2.805kg.csv.gz", robot, GAINS), 5.0, 33.0)
        rules = (PossibleBody(), KnownMass(WEIGHED, 0.01))
        answer_payload(difference_weighing(robot, [loaded], [bare]), constraints=rules, gains=Gains((0.02,)))
        if warm:
            print(
                f"weigh on 30 s, warm: {time.perf_counter() - begun:.2f} s wall, {time.process_time() - cpu:.2f} "
                "CPU s [3 s wall]"
            )


def main() -> None:
    """Print all figures."""
    coverages = {"coverage": None, "changing": 0.0, "lasting": RIPPLE}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--only", choices=("design", *coverages, "windows", "time"))
    arguments = parser.parse_args()
    data = os.environ.get("DYNIDENT_DATA")
    if arguments.only in (None, "design", *coverages):
        cases = designs()
        refusals()
        for name, ripple in coverages.items():
            if arguments.only in (None, name):
                coverage(cases, arguments.seeds, ripple)
    for name, figures in (("windows", windows), ("time", timing)):
        if arguments.only in (None, name):
            if data:
                figures(Path(data))
            else:
                print(f"{name}: left out, DYNIDENT_DATA is not set")


if __name__ == "__main__":
    main()
