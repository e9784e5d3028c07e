"""Weighing by short motions: designed sigma, coverage on simulated noise, time.

Run: python benchmarks/weigh.py [design] [coverage] [changing] [lasting] [time] [--seeds 100]

The payload of all but the last is 3 kg at 100 mm, motions are of 30 s and +-30 degrees. Asked of designs is the
sigma with the best of 60 random motions. coverage: white noise; changing: constant torques change with the payload
as well; lasting: and ripple comes with it. time: of real recordings, found through DYNIDENT_DATA.
"""

import argparse
import functools
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from dynident import estimation, trajectories
from dynident.apps.logs.read import read_recording
from dynident.benchmarks.shared import UR10E_GAINS, UR10E_MASS, options, recordings_folder, rms, show, window
from dynident.common.arrays import Array
from dynident.estimation.payload.short_motion import OFFSET_SHARE
from dynident.model import InertialParameters, Recording, Robot, load_robot
from dynident.model.inertia import PayloadSpread
from dynident.trajectories.design.goal import second_pose

BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], np.diag([0.01, 0.01, 0.005]))
WAVES, RIPPLE = (8, 36), 0.04  # per turn; of a joint's torque, each wave: as ``dynident simulate`` has by default
LEVELS = {"ur10e": ((1.73, 3.01, 1.10, 0.37, 0.38, 0.31), 10.0), "rx90": ((7.6, 9.5, 3.4, 1.6, 2.1, 0.73), 25.0)}
POSES = {"ur10e": (0.0, -60.0, 90.0, -120.0, -90.0, 0.0), "rx90": (0.0, -45.0, 90.0, 0.0, 45.0, 0.0)}
RATES = {"ur10e": 100.0, "rx90": 250.0}  # Hz, of recordings; decimated by 10


class Case(NamedTuple):
    """A motion's joints and poses, and the sigma asked for: mass [kg], com z [mm]; ``scale``: weighed to [kg]."""

    robot: str
    joints: tuple[int, ...]
    poses: int
    mass: float
    com: float
    scale: float | None = None

    def __str__(self) -> str:
        """Its row of a table."""
        weighed = f", weighed to {1e3 * self.scale:.0f} g" if self.scale else ""
        return f"{self.robot} joints {','.join(map(str, self.joints))}, {self.poses} wrist pose(s){weighed}"


CASES = (
    Case("ur10e", (3, 5, 6), 2, 0.075, 6.5),
    Case("ur10e", (2, 3, 5, 6), 1, 0.045, 4.1),
    Case("rx90", (3, 5, 6), 2, 0.36, 21.0),
    Case("rx90", (2, 3, 5, 6), 1, 0.13, 8.4),
)
WEIGHED_CASES = (Case("ur10e", (3, 5, 6), 2, 0.02, 3.2, 0.02), Case("rx90", (3, 5, 6), 2, 0.02, 13.8, 0.02))


@functools.cache
def solved(case: Case) -> tuple[trajectories.Design, PayloadSpread]:
    """A motion near a pose and what it will tell; RX90 at half of its speed."""
    robot = load_robot(case.robot)
    noise, rate = LEVELS[case.robot]
    override, free = 0.5 if case.robot == "rx90" else 1.0, [np.inf] * robot.n
    bounds = trajectories.JointBounds.of(robot, override=override, torque=free)
    pose = np.radians(POSES[case.robot])
    shape = trajectories.NearShape(pose[None], case.joints, np.full(len(case.joints), np.radians(30.0)), 30.0)
    goal = trajectories.NearGoal(np.array(noise), rate, BODY, case.scale)
    second = second_pose(robot, shape, goal, bounds) if case.poses == 2 else None
    if second is not None:
        shape = replace(shape, poses=np.array([pose, second]))
    problem = trajectories.build_design(robot, shape, goal, bounds=bounds)
    design = trajectories.solve_design(problem, seed=0, starts=1)
    return design, goal.predicted(robot, design.plan, case.joints)


def design(_: argparse.Namespace) -> None:
    """Sigma of designed motions beside the figures asked for."""
    rows = []
    for case in (*CASES, *WEIGHED_CASES):
        begun = time.process_time()
        near, spread = solved(case)
        cpu = time.process_time() - begun
        assert isinstance(near.plan, trajectories.Fourier)
        com = (f"{case.com:g}", f"{1e3 * spread.com[2]:.1f}", f"{1e3 * spread.com.max():.1f}")
        kept = "kept" if near.feasible else "MISSED"
        moments = f"{spread.moments.max():.3f}"
        rows.append([str(case), f"{case.mass:g}", f"{spread.mass:.3f}", *com, moments, f"{cpu:.2f}", kept])
    headings = ("com z, asked", "seen", "largest com [mm]", "inertia [kg m2]", "CPU s, asked 3", "limits")
    show("Designed motions: sigma of the mass [kg]", rows, *headings)


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
) -> estimation.PayloadAnswer:
    """With white noise on both recordings; with ``ripple``, that and changed constant torques on the loaded one."""
    draw = np.random.default_rng(seed)
    bare, loaded = (
        replace(recording, torque=recording.torque + noise * draw.standard_normal(recording.torque.shape))
        for recording in clean
    )
    if ripple is not None:
        friction = np.array([robot.parameters[f"FS{joint}"] for joint in range(1, robot.n + 1)])
        change = OFFSET_SHARE * friction * draw.standard_normal(robot.n)
        amplitude, phases = ripple * rms(clean[0].torque), draw.uniform(-np.pi, np.pi, (len(WAVES), robot.n))
        waves = sum(amplitude * np.sin(w * loaded.q + phase) for w, phase in zip(WAVES, phases, strict=True))
        loaded = replace(loaded, torque=loaded.torque + change + waves)
    return estimation.answer_payload(estimation.difference_weighing(robot, [loaded], [bare]))


def coverage(seeds: int, title: str, ripple: float | None) -> None:
    """Percentage of 95 % intervals of the mass that hold the truth."""
    rows = []
    for case in CASES:
        robot, noise = simulated_robot(case.robot), np.array(LEVELS[case.robot][0]) * np.sqrt(10.0)
        simulator, motion = trajectories.Simulator(robot), solved(case)[0].motion(RATES[case.robot])
        clean = [simulator.record(motion, load, None, source=str(k)) for k, load in enumerate((None, BODY))]
        answers = [weighed_once(robot, clean, noise, seed, ripple) for seed in range(seeds)]
        hits = [low <= BODY.mass <= high for low, high in (answer.intervals[0] for answer in answers)]
        errors = [answer.free.ten[9] - BODY.mass for answer in answers]
        sigma = f"{np.mean([answer.model.sigma[9] for answer in answers]):.3f}"
        error = f"{np.mean(errors):+.3f} +- {np.std(errors):.3f}"
        rows.append([str(case), "92 to 99 %", f"{100 * np.mean(hits):.0f} %", error, sigma])
    show(f"The mass by 95 % intervals, {title}, {seeds} seeds", rows, "error [kg]", "sigma as told [kg]")


def timing(_: argparse.Namespace) -> None:
    """Reading, weighing and judging 30 s of the real UR10e, once warm."""
    folder, robot = recordings_folder("time"), load_robot("ur10e")
    for _warm in range(2 if folder is not None else 0):
        begun, cpu = time.perf_counter(), time.process_time()
        bare, loaded = (
            window(read_recording(f"{folder}/ur10e/{name}.csv.gz", robot, UR10E_GAINS), 5.0, length)
            for name, length in (("unloaded", 30.0), ("loaded_2.805kg", 33.0))
        )
        rules = (estimation.PossibleBody(), estimation.KnownMass(UR10E_MASS, 0.01))
        settings = estimation.Settings(gains=estimation.Gains((0.02,)))
        problem = estimation.difference_weighing(robot, [loaded], [bare], settings)
        estimation.answer_payload(problem, constraints=rules)
        seen = f"{time.perf_counter() - begun:.2f} ({time.process_time() - cpu:.2f})"
    if folder is not None:
        show("weigh on 30 s, warm", [["s by the clock (CPU)", "<= 3", seen]])


NOISES = {
    "coverage": ("white noise", None),
    "changing": (f"constant torques change by {100 * OFFSET_SHARE:.1f} % of Coulomb friction", 0.0),
    "lasting": (f"constant torques change, ripple of {100 * RIPPLE:g} % of the torque", RIPPLE),
}


def main() -> None:
    parts = {"design": design, "time": timing}
    arguments = options(__doc__, parts=("design", *NOISES, "time"), seeds=100)
    for name in arguments.parts:
        if name in NOISES:
            coverage(arguments.seeds, *NOISES[name])
        else:
            parts[name](arguments)


if __name__ == "__main__":
    main()
