"""Motion files read back give the motion that was designed, and say what it is."""

from typing import Any

import numpy as np
import pytest
from dynident import trajectories
from dynident.apps.export import motions
from dynident.apps.export.motions import FORMATS, WrittenMotion, design_head, val3_replay
from dynident.apps.report.documents import NearResult, near_document
from dynident.common.errors import InputError
from dynident.model import InertialParameters, load_robot
from dynident.model.frames import frames_at
from dynident.model.inertia import PayloadSpread
from dynident.tests.conftest import SCARA
from dynident.tests.report.motions import motion_parsers as read
from dynident.trajectories.design.goal import Shape

DIGITS = 6e-10
"""Half of the last decimal, and the rounding of the sum."""


@pytest.fixture(scope="module")
def designs() -> dict[str, trajectories.Design]:
    """Through via points, passing or resting, a Fourier series, and held in poses: of a payload's goal, quick."""
    robot = load_robot("rx90")
    bounds = trajectories.JointBounds.of(robot, override=0.5)
    goal = trajectories.Goal("cond-scaled", payload_only=True)
    shapes: dict[str, Shape] = {
        "passing": trajectories.ViaPointShape(5),
        "rest": trajectories.ViaPointShape(5, passing=False),
        "trapezoid": trajectories.ViaPointShape(5, passing=False, segment=trajectories.Trapezoid(0.2)),
        "fourier": trajectories.FourierShape(2, 3.1234567),
    }
    approach, expected = np.full(2, 0.05), InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], [0.01] * 3)
    problems = {
        name: trajectories.build_design(robot, shape, goal, bounds=bounds) for name, shape in shapes.items()
    }
    held = trajectories.StaticShape(np.full(6, 0.1), (2, 5), np.full(2, -0.5), np.full(2, 0.5), approach, 6)
    resting = trajectories.NearGoal(0.005 * bounds.torque, 1.0 / held.hold, expected)
    problems["held"] = trajectories.build_design(robot, held, resting, bounds=bounds)
    return {name: trajectories.solve_design(problem, seed=3, starts=1) for name, problem in problems.items()}


@pytest.fixture(params=["passing", "rest", "trapezoid", "fourier", "held"])
def design(request: pytest.FixtureRequest, designs: dict[str, trajectories.Design]) -> trajectories.Design:
    return designs[request.param]


def written(design: trajectories.Design, rate: float = 250.0, names: tuple[str, ...] = ()) -> WrittenMotion:
    head = design_head(design, design.learnt)
    return WrittenMotion(design.problem.robot, design.plan, design.problem.bounds, head, rate, names, "excite")


def val3_files(motion: WrittenMotion) -> dict[str, str]:
    form = FORMATS["val3"]
    return {f"{motion.name}.dtx": form.text(motion), **form.beside(motion)}


def same(samples: read.Read, design: trajectories.Design) -> None:
    """At the times of the file, to its digits."""
    # A time is rounded to a nanosecond: that much faster joints move on, and a trapezoid's acceleration may step.
    around = [design.plan.at(np.clip(samples.t + late, 0.0, design.plan.duration)) for late in (-1e-9, 0.0, 1e-9)]
    for values, *expected in zip(samples[1:], *around, strict=True):
        if values is not None:
            missed = np.min([np.abs(values - sample).max(axis=1) for sample in expected], axis=0)
            assert missed.max() <= DIGITS + 2e-9 * 60.0


def test_csv(design: trajectories.Design) -> None:
    samples = read.csv_samples(FORMATS["csv"].text(written(design, 100.0)))
    same(samples, design)
    assert samples.t[-1] == pytest.approx(design.plan.duration, abs=1e-9)
    assert np.allclose(np.diff(samples.t)[:-1], 0.01)
    assert samples.qd is not None
    assert np.abs(samples.qd[[0, -1]]).max() < 1e-7, "rests at both ends"


def test_ros2(design: trajectories.Design) -> None:
    names, samples = read.ros2(FORMATS["ros2"].text(written(design, 50.0)))
    assert names == [f"joint_{j}" for j in range(1, 7)]
    same(samples, design)
    assert samples.t[-1] == pytest.approx(design.plan.duration, abs=1e-9)


@pytest.mark.parametrize("rate", [500.0, 125.0])
def test_urscript(design: trajectories.Design, rate: float) -> None:
    program = read.urscript(FORMATS["urscript"].text(written(design, rate)))
    same(program.motion, design)
    assert program.motion.t[1] == pytest.approx(1.0 / rate)
    assert 0.0 <= program.motion.t[-1] - design.plan.duration < 1.0 / rate
    assert np.array_equal(program.first, program.motion.q[0])
    assert [name for name, _ in program.moves] == ["movej", "stopj"]
    assert program.moves[0][1]["v"] <= 0.3, "slowly to the first pose"
    assert program.limits[0] <= 1.0
    assert program.limits[1] <= 0.02


@pytest.mark.parametrize("kind", ["passing", "rest", "trapezoid"])
def test_val3(designs: dict[str, trajectories.Design], kind: str) -> None:
    design = designs[kind]
    plan, robot = design.plan, design.problem.robot
    assert isinstance(plan, trajectories.ViaPoints)
    program = read.val3(val3_files(written(design)))
    assert np.abs(np.radians(program.points) - plan.points).max() < np.radians(6e-7)
    first, move = (f"movej(jPoint[{k}], tFlange, mMotion[{k}])" for k in ("0", "nIndex"))
    start = ["begin", first, "waitEndMove()", "for nIndex = 1 to 4", move, "endFor", "waitEndMove()", "end"]
    assert program.code["start"].splitlines() == start
    limits = [joint.limits for joint in robot.joints]
    V, A = np.array([x.speed for x in limits]), np.array([x.acceleration for x in limits])
    flange = np.array([frames_at(robot, q)[-1].p for q in plan.points])
    gaps = 1000.0 * np.linalg.norm(np.diff(flange, axis=0), axis=1)
    assert float(program.motions[0]["vel"]) <= 10
    for k, motion in enumerate(program.motions[1:]):
        accel, vel = float(motion["accel"]) / 100.0, float(motion["vel"]) / 100.0
        assert motion["decel"] == motion["accel"]
        assert 0.01 <= vel <= 0.5, "within the speed override"
        distance = np.abs(np.diff(plan.points, axis=0))[k]
        last = k == len(program.motions) - 2
        blends = kind == "passing" and not last
        assert motion["blend"] == ("joint" if blends else "off")
        assert not blends or float(motion["leave"]) == pytest.approx(gaps[k : k + 2].min() / 3.0, abs=1.0)
        if kind == "rest":
            time = read.trapezoid_time(distance, vel * V, accel * A)
            quicker = read.trapezoid_time(distance, (vel + 0.01) * V, accel * A)
            assert time > 0.999 * plan.durations[k]
            assert quicker < 1.001 * plan.durations[k] or vel + 0.01 > 0.5, "no slower than a percent's rounding"
        if kind == "trapezoid":  # its ramp is a fifth of each move's time
            T = plan.durations[k]
            assert 100.0 * accel == pytest.approx(100.0 * (distance / A).max() / (0.2 * 0.8 * T**2), abs=0.51)
            assert read.trapezoid_time(distance, vel * V, accel * A) == pytest.approx(T, rel=0.006 / vel)


def test_val3_holds_poses(designs: dict[str, trajectories.Design]) -> None:
    """A move to where it stands already takes no time: the program waits instead."""
    motion, plan = written(designs["held"]), designs["held"].plan
    assert isinstance(plan, trajectories.ViaPoints)
    program, goes = read.val3(val3_files(motion)), np.diff(plan.points, axis=0).any(axis=1)
    assert np.abs(np.radians(program.points) - plan.points[np.append(True, goes)]).max() < np.radians(6e-7)
    assert program.holds.tolist() == [0.0, *[0.0, 1.5] * 12, 0.0]
    loop = program.code["start"].split("for nIndex = 1 to 25\n")[1].splitlines()
    assert loop[1:4] == ["waitEndMove()", "delay(nHold[nIndex])", "endFor"]
    moved = val3_replay(motion).duration + program.holds.sum()
    assert 0.7 * plan.duration < moved < 1.3 * plan.duration
    family, spread = designs["held"].problem.family, PayloadSpread(0.1, np.ones(3), np.eye(3))
    shape: trajectories.StaticShape = vars(family)["shape"]
    told: Any = near_document(NearResult(designs["held"], shape, shape.visibility(motion.robot), spread))
    assert np.array_equal(told.static.poses, plan.held[::2]), "the document tells every pose"


@pytest.mark.parametrize("kind", ["passing", "rest"])
def test_val3_replay_is_what_the_descriptors_ask_for(designs: dict[str, trajectories.Design], kind: str) -> None:
    """It passes or rests as they say, no faster than their percentages, in about the designed time."""
    design = designs[kind]
    assert isinstance(design.plan, trajectories.ViaPoints)
    limits = [joint.limits for joint in design.problem.robot.joints]
    program = read.val3(val3_files(written(design)))
    replay = val3_replay(written(design))
    motion = replay.motion(500.0)
    fastest = max(float(entry["vel"]) for entry in program.motions[1:]) / 100.0
    assert (np.abs(motion.qd) <= fastest * np.array([x.speed for x in limits]) + 1e-9).all()
    accel = float(program.motions[1]["accel"]) / 100.0
    assert (np.abs(motion.qdd) <= accel * np.array([x.acceleration for x in limits]) * (1 + 1e-9)).all()
    assert 0.7 * design.plan.duration < replay.duration < 1.3 * design.plan.duration
    nearest = [np.abs(motion.q - point).max(axis=1).min() for point in design.plan.points]
    assert max(nearest[0], nearest[-1]) < 1e-2
    assert (max(nearest) < 1e-2) == (kind == "rest"), "blending passes the inner points at a distance"


def test_what_has_no_place_is_refused(designs: dict[str, trajectories.Design]) -> None:
    rx90 = designs["rest"].problem.robot
    for name in ("", "9lives", "two words", "longer_than_fifteen_letters", "_x"):
        with pytest.raises(InputError, match="not a VAL3 application name"):
            motions.check_val3(rx90, True, name)
    with pytest.raises(InputError, match="six joints that turn"):
        motions.check_urscript(SCARA, 500.0)
    with pytest.raises(InputError, match="six joints that turn"):
        motions.check_val3(SCARA, True, "x")
