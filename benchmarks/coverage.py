"""Coverage of nominal 95 % intervals, case by case; each case says what it draws and what is asked.

Run: python benchmarks/coverage.py [CASE ...] [--runs N] [--first 0] [--jobs 2] [--trajectories 18]

Each run draws anew by its number. Seen is how often 95 % intervals hold the truth, over runs and parameters; then
the lowest and highest over parameters, that of the mass alone, errors (rms) and half widths (median).
Of white, ar (noise of 20 samples) and late (20 decimated ones) ``--trajectories`` is the number of motions.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from dynident import estimation, model
from dynident.apps.commands.simulate import ASSUMED_SPRING
from dynident.apps.commands.simulate import PAYLOAD as PAPER_PAYLOAD
from dynident.apps.logs.read import read_recording
from dynident.benchmarks import invented, shared
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.answers.gains import gain_problem, known_mass
from dynident.estimation.diagnosis.scales import disagreement
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.covariance import student95
from dynident.estimation.fit.estimate import error_model
from dynident.estimation.fit.linear_problem import LinearProblem, weighted
from dynident.estimation.fit.own_equations import payload_observer
from dynident.estimation.payload.by_joints import payload_by_joints
from dynident.estimation.payload.long_motion import PairedMeasurement, long_motion
from dynident.estimation.payload.methods import (
    METHODS,
    constrain_payload,
    moved,
    recommended_method,
    usable_methods,
)
from dynident.estimation.possible.intervals import Intervals, profile_intervals
from dynident.estimation.signals.filtering import measurement
from dynident.model.drives import parameter_kind
from dynident.model.inertia import payload_spread
from dynident.model.motion import Measurement
from dynident.trajectories import RX90_NOISE, Simulator, ViaPoints, random_via_points

NOTHING: Mapping[str, float] = {}


class Stated(NamedTuple):
    """Part of what a run stated: its row, which intervals hold, other numbers by their column.

    ``beside``: by another way than the package's answer, so that nothing is asked of it; ``text``: to be printed.
    """

    row: str
    held: Array
    more: Mapping[str, float] = NOTHING
    beside: bool = False
    text: str = ""


COLUMNS: dict[str, Callable[[Array], str]] = {
    **dict.fromkeys(("mass", "com", "active %"), lambda x: f"{100 * x.mean():.1f}"),
    "rms error %": lambda x: f"{100 * shared.rms(x):.2f}",
    "half width %": lambda x: f"{100 * np.median(x):.2f}",
    "over unguarded": lambda x: f"{np.median(x):.2f}",
    **dict.fromkeys(("widened", "use", "do not use"), lambda x: f"{x.sum():.0f}"),
    "worst mass error %": lambda x: f"{100 * np.nanmax(np.abs(x), initial=0.0):.2f}",
    "worst inertia error % in use": lambda x: f"{100 * np.nanmax(x, initial=0.0):.0f}",
    "mass interval kg": lambda x: f"{x.mean():.3f}",
    **dict.fromkeys(("rms XX", "rms YY"), lambda x: f"{shared.rms(x):.4g}"),
}
"""Columns of the runs' other numbers, and how they are made."""


# The paper's experiment: motions of a simulated RX90, the same in every run; torque noise is drawn.

PLACE, TURN = (0.0, 0.0, 0.143), np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
BODIES = {
    "point": invented.box(7.025, PLACE, (0.0, 0.0, 0.0)),
    "rod": invented.box(7.025, PLACE, (0.0, 0.0, 0.3)),
    "oblique rod": invented.box(7.025, (0.0, 0.0, 0.0), (0.0, 0.0, 0.3)).moved(TURN, PLACE),
    "plate": invented.box(7.025, (0.0, 0.0, 0.0), (0.3, 0.2, 0.0)).moved(TURN, PLACE),
    "disc": PAPER_PAYLOAD,
    "cube of 4 cm": invented.box(7.025, PLACE, (0.04, 0.04, 0.04)),
    "cube of 10 cm": invented.box(7.025, PLACE, (0.1, 0.1, 0.1)),
    "cube": invented.box(7.025, PLACE, (0.2, 0.2, 0.2)),
}
"""At the estimate of a thin disc the constraint is active in half of the runs."""
SHAPES = tuple(BODIES)[:-1]


@cache
def clean_measurements(trajectories: int) -> dict[str, list[Measurement]]:
    """Measurements without noise, without payload and with each of the bodies."""
    robot = model.load_robot("rx90")
    simulator = Simulator(robot)
    motions = [random_via_points(robot, 14, seed).motion(250.0) for seed in range(trajectories)]
    return {
        name: [measurement(simulator.record(motion, BODIES.get(name)), robot.processing) for motion in motions]
        for name in ("bare", *BODIES)
    }


def repeated_problem(
    body: str, memory: float, trajectories: int, seed: int
) -> tuple[estimation.LongMotion, list[model.Recording]]:
    """One run: the payload's problem, and the recordings without payload.

    Noise as behind the paper's Table 2; with a memory [samples] a third as large, for decimation leaves it whole.
    """
    robot, draw = model.load_robot("rx90"), np.random.default_rng(seed)
    clean = clean_measurements(trajectories)
    sizes = np.array(RX90_NOISE) / (3.0 if memory else 1.0)
    sides = [
        [
            Measurement(one.motion, one.torque + sizes * shared.lasting(noise, memory))
            for one in clean[name]
            for noise in (draw.standard_normal(one.torque.shape),)
        ]
        for name in ("bare", body)
    ]
    pairs = [PairedMeasurement(*pair) for pair in zip(*sides, strict=True)]
    settings = estimation.Settings(robot.processing, friction_change=0.0)
    bares = [model.Recording(one.motion.t, one.motion.q, one.torque, one.motion.qd) for one in sides[0]]
    return long_motion(payload_observer(robot), sides[1], sides[0], pairs, settings), bares


def repeated(memory: float, trajectories: int, name: str, seed: int) -> Iterator[Stated]:
    """Methods 1 to 4 by the formula (17) to (19), the jackknife, and with a body that must exist; or the robot."""
    if name == "robot":
        problem, bares = repeated_problem("disc", memory, trajectories, seed)
        estimate = estimation.identify(problem.robot, bares, estimation.Settings(friction=model.PAPER)).estimate
        truth = problem.base.value(problem.robot.parameters)
        for kind, ends in (("formula", estimate.interval95), ("jackknife", estimate.robust_interval95)):
            assert ends is not None
            yield Stated(f"robot's 54, {kind}", shared.held(ends, truth), beside=kind == "formula")
        return
    body, (problem, _) = BODIES[name], repeated_problem(name, memory, trajectories, seed)
    for method in (1, 2, 3, 4):
        free = estimation.payload_estimate(problem, method).estimate
        nearest = estimation.solve_constrained(error_model(free))
        profile = profile_intervals(nearest)
        assert free.robust_interval95 is not None
        for kind, ends, values in (
            ("formula", free.interval95, free.values),
            ("jackknife", free.robust_interval95, free.values),
            ("recommended", profile.parameters, nearest.values),
        ):
            inside, off = shared.held(ends, body.vector), values - body.vector
            more = {"mass": float(inside[9]), "rms XX": float(off[0]), "rms YY": float(off[3])}
            more |= {"active %": float(bool(nearest.active))} if kind == "recommended" else {}
            yield Stated(f"{name}, method {method}, {kind}", inside, more, kind == "formula")
        yield from following(f"{name}, method {method}", profile, body)


def following(row: str, intervals: Intervals, body: model.InertialParameters) -> Iterator[Stated]:
    """Tell which intervals of what follows from the ten hold; rounding may leave a moment of zero below zero."""
    upper, moments = np.triu_indices(3), np.abs(np.linalg.eigvalsh(body.inertia_com))
    com, inertia = (
        shared.held(intervals.com, body.com),
        shared.held(intervals.inertia_com[upper], body.inertia_com[upper]),
    )
    yield Stated(f"{row}, com and inertia about it", np.append(com, inertia))
    yield Stated(f"{row}, principal moments", shared.held(intervals.principal_moments, moments))


@cache
def compressed_problem(trajectories: int) -> tuple[Equations, Array, Array]:
    """Equations of method 4, the robot's parameters, and the standard deviation of each joint's noise."""
    problem, _ = repeated_problem("disc", 0.0, trajectories, 0)
    equations, estimate = problem.both.whole, weighted(problem.both)
    sizes = equations.error_norms(estimate.values) / np.sqrt(equations.rows)
    return equations, problem.base.value(problem.robot.parameters), sizes


def shapes(trajectories: int, name: str, run: int) -> Iterator[Stated]:
    """Recommended intervals of method 4 for bodies of all shapes, white noise drawn on compressed equations."""
    equations, robot, sizes = compressed_problem(trajectories)
    draw, body, c = np.random.default_rng([run, 41]), BODIES[name], len(equations.columns)
    factors = []
    for factor, size, rows in zip(equations.factors, sizes, equations.rows, strict=True):
        noise = size * np.append(draw.standard_normal(c), np.sqrt(draw.chisquare(rows - c)))  # as QR leaves it
        factors.append(np.column_stack([factor[:, :-1], factor[:, :-1] @ np.append(robot, body.vector) + noise]))
    effective = tuple(map(float, equations.rows))
    drawn = replace(equations, factors=tuple(factors), effective_rows=effective, shared={})
    nearest = estimation.solve_constrained(LinearProblem(drawn, estimation.PAYLOAD).solved())
    intervals = profile_intervals(nearest)
    more = {"active %": float(bool(nearest.active))}
    yield Stated(f"{name}, the ten", shared.held(intervals.parameters, body.vector), more)
    yield from following(name, intervals, body)


# Invented arms, payloads and motions: what the whole answer states, guards included.


def answered(gain: float, name: str, run: int) -> Iterator[Stated]:
    """Draw one or two motions of 20 s together, noise of 2 to 20 %, and answer; beside it without guards.

    ``gain``: relative error of the gain of joint 2 or 3 in all recordings.
    """
    seed = len(ARMS) * run + ARMS.index(name)
    draw, robot = np.random.default_rng([seed, 15]), invented.robot(name)
    body = invented.payload(name, invented.PAYLOADS[run % 5], draw)
    noise, memory = float(draw.uniform(0.02, 0.2)), 20.0 * int(draw.integers(2))
    pairs, seeds = int(draw.integers(1, 3)), [int(number) for number in draw.integers(1_000_000, size=8)]
    motions = [invented.long_motion(name, number, 20.0 / pairs) for number in seeds[:pairs]]
    scale = np.ones(robot.n)
    scale[int(draw.integers(1, 3))] += gain * float(draw.choice([-1.0, 1.0]))
    unloaded, loaded = (
        [
            replace(one, torque=one.torque * scale)
            for motion, number in zip(motions, seeds[first:], strict=False)
            for one in (invented.recorded(name, motion, load, number, noise, memory),)
        ]
        for load, first in ((None, 4), (body, 6))
    )
    settings = estimation.Settings(methods=(4,))
    problem = estimation.payload_problem(robot, loaded, unloaded, settings=settings)
    answer = estimation.answer_payload(problem)
    unguarded = replace(problem, settings=replace(problem.settings, friction_change=0.0))
    narrow = constrain_payload(estimation.payload_estimate(unguarded, 4)).intervals.parameters[9]
    intervals, by_joints = answer.recommended.intervals, answer.evidence.by_joints
    ten = shared.held(intervals.parameters, body.vector)
    half = 0.5 * float(np.ptp(intervals.parameters[9])) / body.mass
    for row in (name, "all arms"):
        yield Stated(
            row,
            ten,
            {
                "mass": float(ten[9]),
                "com": float(shared.held(intervals.com, body.com).mean()),
                "rms error %": answer.mass / body.mass - 1.0,
                "half width %": half,
                "over unguarded": 2.0 * half * body.mass / float(np.ptp(narrow)),
                "widened": float(disagreement(by_joints, np.zeros((robot.n, robot.n))) > 1.0),
                "do not use": float(answer.verdict.level == "do_not_use"),
            },
        )


def good(_: str, run: int) -> Iterator[Stated]:
    """Levels of verdicts on good recordings: thresholds were set with runs from 10,000 on.

    A robot, a payload, one or two motions (the same or others with payload), noise of 5 to 25 %. Asked is "use"
    where the robust standard deviation of the inertia at the centre of mass is under 30 %, else mass and com.
    """
    draw = np.random.default_rng([run, 2026])
    name, kind = invented.NAMES[run % 3], invented.PAYLOADS[run // 3 % 5]
    body = invented.payload(name, kind, draw)
    noise, memory = float(draw.uniform(0.05, 0.25)), 20.0 * int(draw.integers(2))
    pairs, apart = int(draw.integers(1, 3)), bool(draw.random() < 0.25)
    motions = [invented.motion(name, int(seed)) for seed in draw.integers(1_000_000, size=2 * pairs)]
    unloaded, loaded = (
        [invented.recorded(name, motion, load, first + k, noise, memory) for k, motion in enumerate(some)]
        for some, load, first in (
            (motions[:pairs], None, 2 * run),
            (motions[pairs:] if apart else motions[:pairs], body, 2 * run + 10**6),
        )
    )
    answer = estimation.answer_payload(estimation.payload_problem(invented.robot(name), loaded, unloaded))
    payload, level = answer.recommended, answer.verdict.level
    robust, inertia = payload.free.estimate.robust, np.diag(payload.body.inertia_com)
    assert robust is not None
    spread = payload_spread(payload.free.ten, robust.covariance, range(10))
    sure = (spread.moments / np.maximum(inertia, 1e-12)).max() < 0.30
    off = float(np.abs(inertia / np.diag(body.inertia_com) - 1.0).max())
    right = level == ("use" if sure else "mass_and_com_only")
    more = {
        "use": float(level == "use"),
        "do not use": float(level == "do_not_use"),
        "worst mass error %": payload.body.mass / body.mass - 1.0 if level != "do_not_use" else np.nan,
        "worst inertia error % in use": off if level == "use" else np.nan,
    }
    text = "" if right else f"run {run}, {name}, {kind}: {level}: {'; '.join(answer.verdict.reasons)}"
    yield Stated(f"{name}, {kind}", np.array([float(right)]), more)
    yield Stated("all", np.array([float(right)]), more, text=text)


def lacking(other_path: bool, name: str, run: int) -> Iterator[Stated]:
    """Each method where the arm has something that its model lacks, in both recordings of at least 24 s.

    Stribeck friction, 30 to 80 % of FS more about rest; friction of 3 to 9 % of the torque that the gear carries,
    payload included; or ripple of 1 to 4 % of the torque at two wavelengths, half of it growing with the load.
    Intervals without what joints that disagree add to them, gains exact; noise of 1 to 5 %.
    """
    robot = invented.robot(name)
    rigid = {key: 0.0 if model.friction.is_friction(key) else value for key, value in robot.parameters.items()}
    static = [robot.parameters.get(f"FS{j}", robot.parameters.get(f"FSM{j}", 0.0)) for j in range(1, robot.n + 1)]
    for kind in ("Stribeck", "load", "ripple"):
        draw, n = np.random.default_rng([run, 33]), robot.n
        payload = invented.payload(name, invented.PAYLOADS[run % 5], draw)
        first, second = (invented.long_motion(name, int(seed), 24.0) for seed in draw.integers(1_000_000, size=2))
        own, top = (
            shared.rms(invented.simulator(name).measure(first, None, rigid).torque),
            np.abs(first.qd).max(axis=0),
        )
        slow_friction, slow = draw.uniform(0.3, 0.8, n) * np.array(static), draw.uniform(0.05, 0.2, n) * top
        by_load, ripple = draw.uniform(0.03, 0.09, n), 0.35 * draw.uniform(0.01, 0.04) * own
        turns, phases = draw.integers(4, 40, 2).astype(float), draw.uniform(-np.pi, np.pi, (2, n))
        noise, memory, recordings = float(draw.uniform(0.01, 0.05)), 20.0 * int(draw.integers(2)), []
        for motion, load in ((first, None), (second if other_path else first, payload)):
            exact = invented.recorded(name, motion, load, int(draw.integers(1_000_000)), noise, memory)
            carried = invented.simulator(name).measure(motion, load, rigid).torque
            waves = np.sin(motion.q * turns[:, None, None] + phases[:, None]).sum(axis=0)
            more = {
                "Stribeck": slow_friction * np.exp(-((motion.qd / slow) ** 2)) * np.sign(motion.qd),
                "load": by_load * np.abs(carried) * np.sign(motion.qd),
                "ripple": (1.0 + np.abs(carried) / np.maximum(shared.rms(carried), 1e-9)) * ripple * waves,
            }
            recordings.append(replace(exact, torque=exact.torque + more[kind]))
        problem = estimation.payload_problem(robot, recordings[1:], recordings[:1])
        methods = usable_methods(problem)
        recommended = recommended_method(problem, methods)[0]
        for method in methods:
            found = constrain_payload(estimation.payload_estimate(problem, method))
            ends = np.vstack([found.intervals.parameters[9:], found.intervals.com])
            inside = shared.held(ends, np.append(payload.mass, payload.com))
            told = {"mass": float(inside[0]), "com": float(inside[1:].mean())}
            told["rms error %"] = found.mass / payload.mass - 1.0
            for group in (kind, name, "all"):
                yield Stated(f"{group}, method {method}", inside, told, beside=True)
                if method == recommended:
                    yield Stated(f"{group}, recommended", inside, told)


# A robot that was stored earlier and ten seconds of load.

TEN, STEP, JOG = 10.0, 5.0, 3.0
"""s: length of a piece, from one to the next; before the last the real arm jogs to its start and rests."""
HANDLED = model.InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))


@cache
def real(name: str) -> model.Recording:
    """A recording of the real UR10e."""
    folder = shared.recordings_folder(name)
    assert folder is not None
    return read_recording(folder / f"ur10e/{name}.csv.gz", model.load_robot("ur10e"), shared.UR10E_GAINS)


def stored_real(source: str, run: int) -> Iterator[Stated]:
    """A piece of a real UR10e's loaded recording, robot stored from one of its recordings without payload."""
    robot, loaded = model.load_robot("ur10e"), real("loaded_2.805kg")
    assert loaded.qd is not None
    moving = loaded.t[(np.abs(loaded.qd).max(axis=1) > 5e-3) & (loaded.t > JOG)]
    starts = np.arange(moving[0], moving[-1] - TEN, STEP)
    if run < len(starts):
        piece = shared.window(loaded, float(starts[run]), TEN)
        known = estimation.identify(robot, [real(source)]).estimate
        yield from weighed(f"robot from {source}", robot, known, piece, shared.UR10E_MASS)
        yield from weighed(f"robot from {source}, gains to 2 %", robot, known, piece, shared.UR10E_MASS, 0.02)


def stored_simulated(name: str, run: int) -> Iterator[Stated]:
    """A robot stored from 25 s, ten seconds of another motion; frictions other by 6 %, noise of 2 %, 0.2 s."""
    robot, draw = invented.robot(name), np.random.default_rng([run, 11])
    first, second = (random_via_points(robot, 12, 2 * run + k).motion(100.0) for k in range(2))
    changed = {
        name: value * (1.0 + 0.06 * float(draw.standard_normal()))
        for name, value in robot.parameters.items()
        if name.startswith(("FS", "FV"))
    }
    heavy = replace(robot, parameters={**robot.parameters, **changed})

    def noisy(arm: model.Robot, motion: model.Motion, load: model.InertialParameters | None) -> model.Recording:
        exact = Simulator(arm).record(motion, load)
        noise = shared.lasting(draw.standard_normal(exact.torque.shape), 20.0, warm=False)
        return replace(exact, torque=exact.torque + 0.02 * shared.rms(exact.torque) * noise)

    known = estimation.identify(robot, [noisy(robot, first, None)]).estimate
    piece = shared.window(noisy(heavy, second, HANDLED), 5.0, TEN)
    yield from weighed("simulated", robot, known, piece, HANDLED.mass)


def weighed(
    row: str, arm: model.Robot, known: estimation.Estimate, loaded: model.Recording, mass: float, sigma: float = 0.0
) -> Iterator[Stated]:
    """Interval of the mass by ``payload`` and by ``weigh``; ``sigma``: of the drive gains, relative."""
    gains = estimation.Gains((sigma,) * arm.n) if sigma else None
    for command, make in (("payload", estimation.payload_problem), ("weigh", estimation.known_robot_weighing)):
        problem = make(arm, [loaded], known=known)
        estimate = estimation.payload_estimate(problem, 1)
        covariance = gains.covariance(arm.n) if gains is not None else np.zeros((arm.n, arm.n))
        by_joints = payload_by_joints(problem, estimate.estimate.weights)
        factor = disagreement(by_joints, covariance, few=command == "weigh")
        payload = constrain_payload(moved(estimate, factor=factor), gains=gains)
        ends = payload.intervals.parameters[9]
        half = 0.5 * float(np.ptp(ends)) / mass
        more = {"rms error %": payload.mass / mass - 1.0, "half width %": half}
        yield Stated(f"{row}, {command}", shared.held(ends[None], np.array([mass])), more)


def whole_robot(_: str, run: int) -> Iterator[Stated]:
    """Base parameters from three motions of a shipped arm, its nominal numbers times .7 to 1.3; noise 5 to 25 %."""
    names, draw = model.robot_names(), np.random.default_rng([run, 17])
    name = names[run % len(names)]
    robot = invented.robot(name)
    factors = draw.uniform(0.7, 1.3, (robot.n + 1, 2))  # a body times a factor can exist as the body can
    values = {}
    for parameter, value in robot.parameters.items():
        kind = parameter_kind(parameter)
        values[parameter] = value * float(factors[int(parameter[len(kind) :]), 0 if kind in model.INERTIAL else 1])
    robot = replace(robot, parameters=values)
    simulator, base = Simulator(robot), model.base_parameters(robot)
    truth = base.grouping @ np.array([robot.parameters.get(column, 0.0) for column in base.standard])
    kinds = np.array([parameter_kind(column).removesuffix("R") for column in base.columns])
    for k in range(3):
        noise, memory = float(draw.uniform(0.05, 0.25)), 20.0 * (k % 2)
        span = 0.3 if name.startswith("ur") else 0.8  # where ranges are several turns, less of them
        motion = random_via_points(robot, 14, int(draw.integers(1_000_000)), 0.6, span).motion(200.0)
        recording = invented.recorded(name, motion, None, 100 * run + k, noise, memory, simulator)
        own = estimation.Settings(friction=robot.drives.friction)
        estimate = estimation.identify(robot, [recording], own).estimate
        ends = estimate.interval95 if estimate.robust_interval95 is None else estimate.robust_interval95
        inside = shared.held(ends, truth)
        yield Stated("all", inside)
        for kind in dict.fromkeys(kinds):
            yield Stated(f"every {kind}", inside[kinds == kind])
        yield Stated(f"{run} {name}", inside)


# Drive gains: found from currents and a known mass, wrong in all recordings, used on their own recordings.

TRUE_GAINS = {
    "ur10e": np.array([11.5, 12.4, 9.9, 10.4, 10.3, 10.1]),
    "rx90": np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0]),
    "rx90-spring": np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0]),
    "tx40": np.array([11.5, 12.4, 9.9, 6.4, 5.3, 4.1]),
}
"""N·m/A, of the motors on the joint side."""
CURRENT_NOISE = np.array([0.5, 0.5, 0.3, 0.15, 0.15, 0.1])
"""A, of the UR10e; the others' is .06 of each motor's current."""
TORQUE_NOISE = np.array([5.0, 5.0, 3.0, 1.5, 1.5, 1.0])
"""N·m, white."""
WEIGHT = model.InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
OTHER = model.InertialParameters.from_com(4.0, [-0.05, 0.08, 0.09], np.diag([0.02, 0.025, 0.015]))
LOADS = {"none": None, "weight": WEIGHT, "other": OTHER}
BY_FOUR = estimation.Settings(model.Processing(decimate=4), friction=model.PAPER)


def described(name: str) -> model.Robot:
    """An arm; the RX90 perhaps with the spring that is assumed elsewhere."""
    robot = model.load_robot(name.split("-")[0])
    return replace(robot, drives=replace(robot.drives, spring=ASSUMED_SPRING)) if "spring" in name else robot


def with_rx90_parameters(name: str) -> Simulator:
    """A simulator of an arm with the RX90's parameters."""
    known = {**model.load_robot("rx90").parameters, **{f"OFF{joint}": 0.3 * joint for joint in range(1, 7)}}
    return Simulator(replace(described(name), parameters=known))


@cache
def exact_currents(name: str) -> tuple[model.Motion, dict[str, Array]]:
    """One motion of an arm, and its motor currents by load."""
    robot, draw, source = described(name), np.random.default_rng(3), with_rx90_parameters(name)
    middle = np.mean([joint.limits.position for joint in robot.joints], axis=1) if name == "tx40" else np.zeros(6)
    path = middle + draw.uniform(-1.2, 1.2, (40, 6))
    motion = ViaPoints(path, draw.uniform(0.6, 1.2, 39)).motion(100.0)
    torques = {key: source.measure(motion, load).torque for key, load in LOADS.items()}
    coupling = robot.coupling
    motors = {key: coupling.motor_torques(t) if coupling else t for key, t in torques.items()}
    return motion, {key: t / TRUE_GAINS[name] for key, t in motors.items()}


def gains_found(name: str, run: int) -> Iterator[Stated]:
    """Gains by currents without and with a weight of 6 kg."""
    motion, exact = exact_currents(name)
    truth = TRUE_GAINS[name]
    level = CURRENT_NOISE if name == "ur10e" else 0.06 * shared.rms(exact["none"])
    for words, memory in (("white noise", 0.0), ("AR(1) noise of 20 samples", 20.0)):
        draw, load = np.random.default_rng([7, run]), known_mass(6.0)
        pair = [
            model.Recording(motion.t, motion.q, i + level * noise, motion.qd)
            for i in (exact["none"], exact["weight"])
            for noise in (shared.lasting(draw.standard_normal(i.shape), memory, warm=False),)
        ]
        problem = gain_problem(described(name), pair[:1], pair[1:], load, settings=BY_FOUR)
        found = estimation.answer_gains(problem)
        gains, robust = found.drive_gains, found.robust
        error, row = np.abs(np.log(gains.values / truth)), f"{name}, {words}"
        formula = np.array(gains.relative_sigma_formula)
        yield Stated(f"{row}, formula", (error < 1.96 * formula).astype(float), beside=True)
        if robust and robust.degrees_of_freedom:
            half = student95(robust.degrees_of_freedom) * np.array(gains.relative_sigma_robust)
            yield Stated(f"{row}, jackknife", (error < half).astype(float))


@cache
def exact_torques(name: str, load: str, seed: int) -> tuple[model.Motion, Array]:
    """A motion of an arm, and its torques with a load."""
    draw = np.random.default_rng(seed)
    motion = ViaPoints(draw.uniform(-1.2, 1.2, (40, 6)), draw.uniform(0.6, 1.2, 39)).motion(100.0)
    return motion, with_rx90_parameters(name).measure(motion, LOADS[load]).torque


def gains_wrong(name: str, run: int) -> Iterator[Stated]:
    """Every gain off by its own 2 % in all recordings: a robot stored from one, a payload by method 1 from another.

    The gains' error is counted once, as robot and payload share it; as if each had errors of its own; not at all.
    """
    robot, gains = model.load_robot(name), estimation.Gains((0.02,))
    errors = 0.02 * np.random.default_rng([9, run]).standard_normal(6)

    def record(load: str, seed: int) -> model.Recording:
        motion, exact = exact_torques(name, load, seed)
        torque = exact + TORQUE_NOISE * np.random.default_rng([seed, run]).standard_normal(exact.shape)
        coupling = robot.coupling  # a motor's error is in two joints' torques where drives are coupled
        motors = (1.0 + errors) * (coupling.motor_torques(torque) if coupling else torque)
        torque = coupling.joint_torques(motors) if coupling else motors
        return model.Recording(motion.t, motion.q, torque, motion.qd)

    identification = estimation.identify(robot, [record("none", 3)], replace(BY_FOUR, gains=gains))
    stored, truth = identification.estimate, identification.base.value(with_rx90_parameters(name).robot.parameters)
    for row, ends in (("with gains", stored.interval95_with_gains), ("gains as exact", stored.robust_interval95)):
        assert ends is not None
        yield Stated(f"{name}, robot, {row}", shared.held(ends, truth), beside=row != "with gains")
    problem = estimation.payload_problem(robot, [record("weight", 4)], [], stored, BY_FOUR)
    assert problem.known is not None
    estimate = estimation.payload_estimate(problem, 1).estimate
    alone = replace(problem, known=replace(problem.known, gain_sensitivity=np.zeros((len(problem.known.names), 6))))
    J, J_own = (METHODS[1](p).solved(estimate.weights).gain_sensitivity for p in (problem, alone))
    assert estimate.robust is not None
    assert J is not None
    assert J_own is not None
    C = gains.covariance(6)
    for row, extra in (
        ("once, shared", J @ C @ J.T),
        ("as if apart", J_own @ C @ J_own.T + (J - J_own) @ C @ (J - J_own).T),
        ("not at all", np.zeros((10, 10))),
    ):
        half = student95(estimate.robust.degrees_of_freedom) * np.sqrt(np.diag(estimate.robust.covariance + extra))
        inside = (np.abs(estimate.values - WEIGHT.vector) <= half).astype(float)
        more = {"mass": float(inside[9]), "mass interval kg": 2.0 * float(half[9])}
        yield Stated(f"{name}, payload, gains counted {row}", inside, more, row != "once, shared")


def gains_again(name: str, run: int) -> Iterator[Stated]:
    """Recordings that gains were found from used again: intervals take gains and recordings for unrelated."""
    robot, (motion, exact) = model.load_robot(name), exact_currents(name)

    def record(load: str, seed: int) -> model.Recording:
        noise = np.random.default_rng((run, seed)).standard_normal(exact[load].shape)
        return model.Recording(motion.t, motion.q, exact[load] + CURRENT_NOISE * noise, motion.qd)

    first, weight, fresh, second = record("none", 0), record("weight", 1), record("none", 2), record("other", 3)
    problem = gain_problem(robot, [first], [weight], known_mass(6.0), settings=BY_FOUR)
    found = estimation.answer_gains(problem).drive_gains
    gains = estimation.Gains(identified=found.relative_covariance.tolist())
    recorded = (replace(one, torque=one.torque * found.values) for one in (first, weight, fresh, second))
    first, weight, fresh, second = recorded
    for row, bare, heavy, body in (
        ("recordings of its own", fresh, second, OTHER),
        ("the gains' recording without payload", first, second, OTHER),
        ("the gains' own pair", first, weight, WEIGHT),
    ):
        settings = replace(BY_FOUR, methods=(4,), gains=gains)
        answer = estimation.answer_payload(estimation.payload_problem(robot, [heavy], [bare], settings=settings))
        ends = answer.recommended.intervals.parameters[6:]
        inside = shared.held(ends, body.vector[6:])
        more = {"mass": float(inside[3]), "mass interval kg": float(np.ptp(ends[3]))}
        yield Stated(f"payload's MX MY MZ M, {row}", inside, more)
    for row, bare in (("a recording of its own", fresh), ("the gains' recording", first)):
        result = estimation.identify(robot, [bare], replace(BY_FOUR, gains=gains))
        within = result.estimate.interval95_with_gains
        assert within is not None
        truth = result.base.value(with_rx90_parameters(name).robot.parameters)
        yield Stated(f"robot, {row}", shared.held(within, truth))


class Case(NamedTuple):
    """Arms, runs of each, what is drawn, and the mean coverage that is asked, in percent."""

    states: Callable[[str, int], Iterator[Stated]]
    arms: tuple[str, ...]
    runs: int
    drawn: str
    asked: str = "92 to 99"
    real: bool = False


ARMS, STORED_FROM = (*invented.NAMES, "panda"), ("unloaded", "validation_unloaded")


def cases(trajectories: int) -> dict[str, Case]:
    """All of them by name."""
    paper = f"RX90 with a thin disc and a cube, {trajectories} random motions, torque noise as behind Table 2"
    answer = "invented arms and payloads, motions of 20 s and more, noise 2 to 20 %, white or with memory"
    thin = "RX90 with bodies thin and compact"
    lack = "invented arms with friction or ripple that the model lacks"
    memories = {"white": 0.0, "ar": 20.0, "late": 200.0}  # samples; decimation is by 10
    return {
        name: Case(
            partial(repeated, memory, trajectories), ("robot", "disc", "cube"), 30, f"{paper}, {name}", "93 to 98"
        )
        for name, memory in memories.items()
    } | {
        "shapes": Case(partial(shapes, trajectories), SHAPES, 300, f"{thin}, white noise"),
        "shapes-ar": Case(partial(repeated, 20.0, trajectories), SHAPES, 30, f"{thin}, noise of 20 samples"),
        "answer": Case(partial(answered, 0.0), ARMS, 15, answer),
        "gain-off": Case(partial(answered, 0.05), ARMS, 15, f"{answer}; joint 2 or 3's gain 5 % off"),
        "good": Case(good, ("",), 200, "levels as the inertia's robust deviation says, of good recordings", "100"),
        "lacking": Case(partial(lacking, False), ARMS, 15, f"{lack}, on one path", "92 to 98"),
        "lacking-other": Case(partial(lacking, True), ARMS, 5, f"{lack}, on two paths", "92 to 98"),
        "stored-real": Case(stored_real, STORED_FROM, 9, "10 s of a real UR10e's load", real=True),
        "stored": Case(stored_simulated, ("ur10e",), 100, "10 s of load on another day, noise 2 %, a stored UR10e"),
        "robots": Case(whole_robot, ("",), 20, "base parameters, 3 recordings of each robot; no row below 85"),
        "gains": Case(gains_found, tuple(TRUE_GAINS), 20, "gains by currents and a known mass"),
        "gains-wrong": Case(gains_wrong, ("ur10e", "rx90"), 60, "every gain off by 2 %"),
        "gains-again": Case(gains_again, ("ur10e",), 40, "4 kg by method 4, gains from a weight of 6 kg"),
    }


def run_of(case: Case, asked: tuple[str, int]) -> list[Stated]:
    """Answers of one run; none, and a line, where there is an error."""
    try:
        return list(case.states(*asked))
    except (InputError, estimation.SolverError) as error:
        print(f"{asked[0]} {asked[1]}: {error}", flush=True)
        return []


def coverage(case: Case, runs: Sequence[int], jobs: int = 1) -> dict[str, list[Stated]]:
    """By row what the runs stated."""
    rows = defaultdict[str, list[Stated]](list)
    for told in shared.each(partial(run_of, case), [(arm, run) for arm in case.arms for run in runs], jobs):
        for stated in told:
            rows[stated.row].append(stated)
            if stated.text:
                print(stated.text)
    return rows


def report(name: str, case: Case, rows: dict[str, list[Stated]]) -> None:
    """Print a case's table."""
    columns = [column for column in COLUMNS if any(column in own[0].more for own in rows.values())]
    lines = []
    for row, own in sorted(rows.items()):
        hits = [stated.held for stated in own]
        every, alike = np.concatenate(hits), len({len(hit) for hit in hits}) == 1
        means = np.mean(hits, axis=0) if alike else every.mean(keepdims=True)
        seen = [f"{100 * x:.1f}" for x in (every.mean(), means.min(), means.max())]
        numbers = {column: np.array([stated.more[column] for stated in own]) for column in own[0].more}
        more = [COLUMNS[column](numbers[column]) if column in numbers else "" for column in columns]
        lines.append([row, "" if own[0].beside else case.asked, seen[0], str(len(own)), *seen[1:], *more])
    shared.show(f"{name}: {case.drawn}; asked and seen in percent", lines, "runs", "lowest", "highest", *columns)


def main() -> None:
    arguments = shared.options(__doc__, cases=tuple(cases(0)), runs=0, first=0, jobs=2, trajectories=18)
    for name in arguments.cases:
        case = cases(arguments.trajectories)[name]
        if case.real and shared.recordings_folder(name) is None:
            continue
        runs = range(arguments.first, arguments.first + (arguments.runs or case.runs))
        report(name, case, coverage(case, runs, arguments.jobs))


if __name__ == "__main__":
    main()
