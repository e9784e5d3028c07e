"""A gallery of wrong inputs: each ends in an error or in a verdict that names the cause; good ones give none."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from dynident import estimation
from dynident.benchmarks import invented
from dynident.benchmarks.coverage import good
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.diagnosis.causes import likely_causes
from dynident.estimation.diagnosis.engine import states_of
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.payload.by_joints import WITHOUT_BLOCKS, payload_by_joints
from dynident.estimation.payload.long_motion import Source
from dynident.estimation.payload.short_motion import difference_weighing
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, load_robot
from dynident.model.stand_in import rehearsed
from dynident.tests.estimation.conftest import LIFT, Change, counted_backwards, on_torque, scaled
from dynident.tests.selection import every
from dynident.trajectories import Simulator, ViaPoints


@cache
def good_pair(name: str, kind: str = "cube") -> tuple[Motion, Recording, Recording, InertialParameters]:
    """A motion, good recordings without and with payload, and the payload."""
    body = invented.payload(name, kind, np.random.default_rng(4))
    motion = invented.motion(name, 3, points=9 if name == "ur10e" else 11)
    return motion, invented.recorded(name, motion, None, 5), invented.recorded(name, motion, body, 6), body


def on_position(change: Callable[[Array], Array]) -> Change:
    return lambda r: replace(r, q=change(np.array(r.q)))


def read_at(times: Callable[[Array], Array]) -> Change:
    """The torque that belongs to another time."""

    def change(r: Recording) -> Recording:
        torque = np.column_stack([np.interp(times(r.t), r.t, channel) for channel in r.torque.T])
        return replace(r, torque=torque)

    return change


def reordered(*order: int) -> Change:
    places = [joint - 1 for joint in order]
    return lambda r: replace(r, q=r.q[:, places], torque=r.torque[:, places])


def without_gravity(name: str) -> Change:
    """Torques as a gravity-compensated controller shows them, by load."""
    motion, bare, _, body = good_pair(name)
    robot = invented.robot(name)
    still = Motion(motion.t, motion.q, 0.0 * motion.qd, 0.0 * motion.qdd)
    with_g, without = (Simulator(arm) for arm in (robot, replace(robot, gravity=(0.0, 0.0, 0.0))))

    def change(r: Recording) -> Recording:
        load = None if r is bare else body
        return replace(
            r, torque=r.torque - (with_g.measure(still, load).torque - without.measure(still, load).torque)
        )

    return change


def compensated(name: str, part: float) -> Change:
    """A part of the payload's weight taken off, as a controller does in which a payload is entered."""
    motion, _, _, body = good_pair(name)
    still = Motion(motion.t, motion.q, 0.0 * motion.qd, 0.0 * motion.qdd)
    arm = Simulator(invented.robot(name))
    carried = arm.measure(still, body).torque - arm.measure(still, None).torque
    return on_torque(lambda torque: torque - part * carried)


def late_half(name: str, body: InertialParameters | None) -> Change:
    """In the second half another load."""
    motion, *_ = good_pair(name)
    second = invented.recorded(name, motion, body, 6)

    def change(r: Recording) -> Recording:
        late = (r.t > 0.5 * r.t[-1])[:, None]
        return replace(r, torque=np.where(late, second.torque, r.torque))

    return change


def static_poses(name: str) -> Change:
    """Held poses one after another, without the motion between them."""
    motion, *_ = good_pair(name)
    moving = invented.simulator(name)

    def change(r: Recording) -> Recording:
        poses = motion.q[np.linspace(0, len(motion.t) - 1, 12).astype(int)]
        q = np.repeat(poses, len(motion.t) // 12, axis=0)
        t = motion.t[: len(q)]
        still = moving.measure(Motion(t, q, 0.0 * q, 0.0 * q)).torque
        return replace(r, t=t, q=q, torque=still + 0.1 * np.random.default_rng(3).standard_normal(q.shape))

    return change


def only_joint(name: str, joint: int) -> Change:
    motion, *_ = good_pair(name)
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    others = [j for j in range(6) if j != joint - 1]
    q[:, others], qd[:, others], qdd[:, others] = q[0, others], 0.0, 0.0
    single = Motion(motion.t, q, qd, qdd)
    return lambda r: invented.recorded(name, single, None, len(r.source))


def stuck(joint: int, begin: float, end: float = 1.0) -> Change:
    """The encoder holds its value from a share of the recording to another, then follows again."""

    def change(q: Array) -> Array:
        a, b = int(begin * len(q)), int(end * len(q))
        q[a:b, joint - 1] = q[a, joint - 1]
        return q

    return on_position(change)


def drifting(joint: int, size: float) -> Change:
    """An offset that grows from nothing to ``size`` of the joint's torque."""

    def change(torque: Array) -> Array:
        column = torque[:, joint - 1]
        torque[:, joint - 1] += size * np.sqrt(np.mean(column**2)) * np.linspace(0.0, 1.0, len(torque))
        return torque

    return on_torque(change)


def speeds(factor: float) -> Change:
    def change(r: Recording) -> Recording:
        return replace(r, qd=factor * np.gradient(r.q, r.t, axis=0))

    return change


def lengthened(robot: Robot, joint: int, name: str, factor: float) -> Robot:
    joints = list(robot.joints)
    old = joints[joint - 1]
    joints[joint - 1] = replace(old, **{name: factor * getattr(old, name)})
    return replace(robot, joints=tuple(joints))


def same(r: Recording) -> Recording:
    return r


@dataclass(frozen=True)
class Wrong:
    """One wrong input: what is given, and words that the answer must hold."""

    name: str
    words: str
    robot: Robot
    loaded: tuple[Recording, ...]
    unloaded: tuple[Recording, ...]
    mass: float
    options: dict[str, Any] = field(default_factory=dict)
    processing: Processing | None = None


@dataclass(frozen=True)
class Ending:
    """The end of an input: "error" or a level, the words, and the recommended mass [kg]."""

    level: str
    text: str
    mass: float = float("nan")


def ending(case: Wrong) -> Ending:
    """Run one case as the command does."""
    try:
        settings = estimation.Settings(case.processing)
        problem = estimation.payload_problem(case.robot, case.loaded, case.unloaded, settings=settings)
        answer = estimation.answer_payload(problem, **case.options)
    except (InputError, estimation.SolverError) as error:
        return Ending("error", str(error))
    return Ending(answer.verdict.level, " | ".join(answer.verdict.reasons), answer.recommended.mass)


def both(name: str, label: str, words: str, change: Change, **more: Any) -> Wrong:
    """One mistake made in both recordings."""
    _, bare, loaded, body = good_pair(name)
    robot = more.pop("robot", invented.robot(name))
    return Wrong(f"{name}: {label}", words, robot, (change(loaded),), (change(bare),), body.mass, **more)


def loaded_only(name: str, label: str, words: str, change: Change, **more: Any) -> Wrong:
    """A mistake in the loaded recording alone."""
    _, bare, loaded, body = good_pair(name)
    return Wrong(f"{name}: {label}", words, invented.robot(name), (change(loaded),), (bare,), body.mass, **more)


def swapped(name: str) -> Wrong:
    _, bare, loaded, body = good_pair(name)
    return Wrong(f"{name}: swapped pair", "swapped", invented.robot(name), (bare,), (loaded,), body.mass)


def of_another(name: str, another: str) -> Wrong:
    words = f"the robot is '{name}'|outside the range"
    return both(name, f"described as {another}", words, same, robot=load_robot(another))


def cases() -> Iterator[Wrong]:
    """All wrong inputs."""
    yield from _one_sided()
    yield from _of_channels()
    yield from _of_description()
    yield from _of_knowledge()


def _one_sided() -> Iterator[Wrong]:
    """The wrong recordings, or the payload not what it was."""
    motion, _, loaded, body = good_pair("rx90")
    yield both("rx90", "static poses", r"q\d jumps by -?\d\.\d+ .* at \d", static_poses("rx90"))
    yield both("ur10e", "only joint 6 moves", "joint 1, 2, 3, 4, 5 does not move", only_joint("ur10e", 6))
    yield from (swapped(name) for name in invented.NAMES)
    words, again = "cannot be told from zero.*payload really on", invented.recorded("rx90", motion, body, 99)
    robot = invented.robot("rx90")
    yield Wrong("rx90: payload in both recordings", words, robot, (loaded,), (again,), body.mass)
    yield loaded_only("rx90", "payload put down halfway", "mass (grows|shrinks)", late_half("rx90", None))
    slipped = body.moved(np.eye(3), [0.08, 0.0, 0.0])
    yield loaded_only("rx90", "payload slips by 80 mm", "centre of mass moves", late_half("rx90", slipped))
    yield loaded_only("tx40", "torque drifts", "torque of joint 2 drifts by", drifting(2, 1.0))
    for name in invented.NAMES:
        words = "payload's inertia but lack (4[5-9]|5[0-5]) % of its weight"
        yield loaded_only(name, "half of the payload compensated", words, compensated(name, 0.5))
    yield both("rx90", "cut-off below the motion", "of the motion of joint", same, processing=_slow("rx90"))
    yield loaded_only("ur10e", "torques of another sign", "negative mass|sign", on_torque(lambda x: -x))


def _slow(name: str) -> Processing:
    return replace(invented.robot(name).processing, cutoff=0.6)


def _of_channels() -> Iterator[Wrong]:
    """Units, signs, order and time of the columns."""
    yield both("rx90", "degrees", "degrees", on_position(np.degrees))
    yield both("tx40", "mN·m", "mN·m|N·m", on_torque(lambda x: 1000.0 * x))
    yield both("rx90", "kN·m", "kN·m", on_torque(lambda x: 1e-3 * x))
    percent = np.array([3.1, 2.9, 8.3, 25.0, 50.0, 83.0]) / 10.0
    yield both("rx90", "percent of each drive", "has its own unit|drive gain", on_torque(lambda x: percent * x))
    gears = np.array([32.0, 32.0, 45.0, 48.0, 45.0, 32.0])
    yield both("rx90", "motor-side torque", "look like motor-side torques", on_torque(lambda x: 2.0 * x / gears))
    signs = on_torque(lambda x: x * [1, -1, 1, -1, 1, 1])
    yield both("ur10e", "gains 2 and 4 of wrong sign", "joint 2(, 4)? has the wrong sign for gravity", signs)
    for joint in (2, 4, 6):
        words = f"joint {joint} (measures|is about) [12]"
        yield both("rx90", f"gain {joint} twice too large", words, scaled(2.0, joint))
    for joint in (1, 3):
        words = f"joint {joint} (measures 0|is about 2 times too small)"
        yield both("ur10e", f"gain {joint} halved", words, scaled(0.5, joint))
    for joint in (2, 5):
        words = f"friction of joint {joint} comes out negative"
        yield both("tx40", f"sign of torque {joint}", words, scaled(-1.0, joint))
    yield both("ur10e", "sign of torque 6", "friction of joint 6 comes out negative", scaled(-1.0, 6))
    yield both("rx90", "joint 2 counted backwards", "joint 2 has the opposite sign", counted_backwards(2))
    yield both("rx90", "joints 2 and 3 exchanged", "joints 2 and 3 are exchanged", reordered(1, 3, 2, 4, 5, 6))
    yield both("ur10e", "joints 4 and 5 exchanged", "joints 4 and 5 are exchanged", reordered(1, 2, 3, 5, 4, 6))
    yield both("rx90", "torque 0.2 s late", "torque lags position by about 0.20 s", read_at(lambda t: t - 0.2))
    yield loaded_only("ur10e", "torque 0.2 s late", "lags position by about 0.(19|2)", read_at(lambda t: t - 0.2))
    yield both("rx90", "two clocks", "two clocks", read_at(lambda t: 0.985 * t))
    noise = np.random.default_rng(8).standard_normal
    noisy = on_torque(lambda x: np.where(np.arange(6) == 2, 0.05 * noise((len(x), 1)), x))
    yield both("tx40", "torque channel of noise", "joint 3", noisy)
    clipped = on_torque(lambda x: np.clip(x, -0.5 * np.abs(x).max(axis=0), 0.5 * np.abs(x).max(axis=0)))
    yield both("rx90", "saturated torque", "saturated", clipped)
    yield both("rx90", "speeds in degrees per second", "degrees per second", speeds(np.degrees(1.0)))
    yield both(
        "rx90", "encoder 3 sticks for a while", "stuck encoder|encoder of joint 3 is stuck", stuck(3, 0.4, 0.6)
    )
    yield both("ur10e", "encoder 2 stuck from half way", "encoder of joint 2 is stuck", stuck(2, 0.5))


def _of_description() -> Iterator[Wrong]:
    """The robot is not the one described."""
    rx90 = invented.robot("rx90")
    for name in ("rx90", "ur10e"):
        yield both(name, "gravity-compensated torques", "lack gravity", without_gravity(name))
    yield of_another("rx90", "ur10e")
    yield of_another("ur10e", "rx90")
    single = replace(rx90, drives=replace(rx90.drives, coupling=None))
    yield both("rx90", "coupling left out", "drives of joints 5 and 6 are coupled", same, robot=single)
    longer = lengthened(rx90, 3, "d", 1.1)
    yield both("rx90", "a length 10 % too long", "the robot is 'rx90'|length d3", same, robot=longer)
    quarter = np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0])
    yield both("ur10e", "zero of q3 off by 90 degrees", "zero of q3 is off", on_position(lambda q: q + quarter))


def _of_knowledge() -> Iterator[Wrong]:
    """Inputs that say of the payload what is not true."""
    mass = good_pair("rx90")[3].mass

    def known(label: str, words: str, constraint: Any) -> Wrong:
        return both("rx90", label, words, same, options={"constraints": (constraint,)})

    bounds = estimation.MassBounds(0.0, 0.6 * mass)
    yield known("mass bound excludes the truth", "contradict a constraint: mass", bounds)
    yield known("weighed mass is another's", "the scale shows", estimation.KnownMass(1.5 * mass, 0.01))
    ellipsoid = estimation.InEllipsoid((0.0, 0.0, -0.3), (0.1, 0.1, 0.1))
    yield known("ellipsoid in the wrong place", "contradict a constraint: .*ellipsoid", ellipsoid)
    box = estimation.CentreOfMassInBox((-0.02, -0.02, -0.3), (0.02, 0.02, -0.1))
    yield known("centre of mass in the wrong box", "contradict a constraint: centre of mass", box)


@cache
def any_pair(name: str) -> tuple[Robot, Recording, Recording]:
    """An arm, and good recordings without and with payload."""
    robot = rehearsed(LIFT if name == "lift" else load_robot(name))
    ranges = np.clip([joint.limits.position for joint in robot.joints], -1.2, 1.2)
    draw = np.random.default_rng(1)
    path = draw.uniform(ranges[:, 0], ranges[:, 1], (20, robot.n))
    motion = ViaPoints(path, draw.uniform(0.7, 1.2, 19)).motion(100.0)
    body = invented.box(0.5 * (robot.rated_payload or 4.0), (0.02, -0.01, 0.08), (0.12, 0.12, 0.12))
    arm, noise = Simulator(robot), [0.002 * joint.limits.torque for joint in robot.joints]
    bare, loaded = (arm.record(motion, load, noise, seed) for seed, load in enumerate((None, body), 1))
    return robot, replace(bare, source="unloaded.csv"), replace(loaded, source="loaded.csv")


def described(*gravity: float) -> Callable[[Robot], Robot]:
    x, y, z = gravity
    return lambda robot: replace(robot, gravity=(x, y, z))


AGAINST = "wrong sign for gravity"
MISTAKES: dict[str, tuple[str, Callable[[Robot], Robot], Change]] = {
    "currents": ("look like motor-side torques, currents", lambda robot: robot, on_torque(lambda x: 0.1 * x)),
    "all signs": (AGAINST, lambda robot: robot, on_torque(lambda x: -x)),
    "sign of joint 2": ("joint 2 has the wrong sign for gravity", lambda robot: robot, scaled(-1.0, 2)),
    "ceiling": (AGAINST, described(0.0, 0.0, 9.81), same),
    "wall": ("degrees away from the described gravity", described(9.81, 0.0, 0.0), same),
    "gravity 9": (r"gravity of 9(\.[6-9]| m)", described(0.0, 0.0, -9.0), same),
    "gain 2 doubled": ("joint 2 is about 2|joint 2's is [12]", lambda robot: robot, scaled(2.0, 2)),
}
"""Mistakes in all recordings of any arm: words of the answer, how the robot is described, and what is recorded."""
GALLERY = ("ur5e", "rx90", "panda", "lift", "panda", "gp7", "gp7")  # an arm for each; a slide does not show a wall


@pytest.mark.parametrize(("name", "mistake"), list(zip(GALLERY, MISTAKES, strict=True)))
def test_every_command_says_the_same_of_any_arm(name: str, mistake: str) -> None:
    robot, bare, loaded = any_pair(name)
    words, describe, change = MISTAKES[mistake]
    arm, without, with_payload = describe(robot), change(bare), change(loaded)
    verdicts = [
        estimation.identify(arm, [without]).verdict,
        estimation.answer_payload(estimation.payload_problem(arm, [with_payload], [without])).verdict,
        estimation.answer_payload(difference_weighing(arm, [with_payload], [without])).verdict,
    ]
    for verdict in verdicts:
        assert verdict.level == "do_not_use"
        assert re.search(words, verdict.reasons[0]), verdict.reasons


CASES = {case.name: case for case in cases()}
_UNSEEN = {("rx90", 1), ("tx40", 1), ("tx40", 4), ("ur10e", 6)}
"""Joints whose sense the recordings without payload hardly show: chi2 falls by 3 % at most."""


@pytest.mark.parametrize("name", every(16, CASES))
def test_a_wrong_input_ends_in_words_that_name_its_cause(name: str) -> None:
    case = CASES[name]
    end = ending(case)
    assert re.search(case.words, end.text), end.text
    assert end.level != "use"
    if end.level == "mass_and_com_only":
        assert abs(end.mass / case.mass - 1.0) < 0.03


@pytest.mark.parametrize(
    "turned", every(9, product(invented.NAMES, range(1, 7))), ids=lambda turned: "-".join(map(str, turned))
)
def test_a_joint_counted_the_other_way_is_named_first(turned: tuple[str, int]) -> None:
    """By the payload, and by the robot's parameters wherever the recording without payload tells it.

    Turned joints whose motion leaves the other parameters free to follow (joint 1, and some of a wrist) are not
    seen without payload; where they are, no other robot is named.
    """
    name, joint = turned
    case = both(name, "", "", counted_backwards(joint))
    end = ending(case)
    words = f"joint {joint} has the opposite sign"
    if end.level == "error":  # a joint whose range is not the same to both sides
        assert f"q{joint} reaches" in end.text
        return
    assert end.level == "do_not_use"
    assert words in end.text.split(" | ")[0]
    reasons = estimation.identify(case.robot, case.unloaded).verdict.reasons
    assert bool(reasons) == (turned not in _UNSEEN)
    assert all(re.search(f"joint (. or )?{joint}( or .)? has the opposite sign", text) for text in reasons[:1])
    assert not any("of robot" in text for text in reasons)


@pytest.mark.parametrize("seed", every(5, range(20, 30)))
def test_good_recordings_are_answered_as_far_as_they_determine(seed: int) -> None:
    """Ten of the benchmark's two hundred; more would take too long here."""
    *_, stated = good("", seed)
    assert stated.held.all(), stated.text
    assert abs(stated.more["worst mass error %"]) < 0.06


def causes_of(name: str, change: Change, contradicted: bool = True) -> str:
    _, bare, loaded, _ = good_pair(name)
    robot = invented.robot(name)
    states = states_of(Source((change(loaded),), (change(bare),), robot.processing))
    return " ".join(finding.text for finding in likely_causes(robot, states, contradicted))


@pytest.mark.parametrize("delay", [-0.1, 0.05, 0.3])
def test_a_delay_is_found_with_its_sign_and_size(delay: float) -> None:
    words = causes_of("rx90", read_at(lambda t: t - delay))
    assert f"torque {'lags' if delay > 0 else 'leads'} position by about {abs(delay):.2f} s" in words


def good_problem() -> estimation.LongMotion:
    """The gallery's good recordings of the RX90, without blocks."""
    _, bare, loaded, _ = good_pair("rx90")
    settings = estimation.Settings(robust=False)
    return estimation.payload_problem(invented.robot("rx90"), [loaded], [bare], settings=settings)


def rows_of(part: Equations | None, keep: tuple[int, ...]) -> Equations:
    """The equations of some joints, from 0, alone."""
    assert part is not None
    factors = tuple(f if j in keep else 0.0 * f[:0] for j, f in enumerate(part.factors))
    rows = tuple(r if j in keep else 0 for j, r in enumerate(part.rows))
    return replace(part, factors=factors, rows=rows, effective_rows=tuple(map(float, rows)), shared={})


def test_a_group_sees_what_method_3_sees_in_its_rows() -> None:
    """Mass and standard deviation are those of method 3 by these joints alone; without blocks so much larger."""
    problem = good_problem()
    assert problem.difference is not None
    effective = problem.difference.effective_rows
    arm = replace(rows_of(problem.difference, (0, 1, 2)), effective_rows=(*effective[:3], 0.0, 0.0, 0.0))
    weights = estimation.payload_estimate(problem, 3).estimate.weights
    expected = weighted(arm.select(estimation.PAYLOAD), weights)
    group = payload_by_joints(problem, weights).masses[6]
    assert group.joints == (1, 2, 3)
    assert group.mass == pytest.approx(expected["M_L"], rel=1e-9)
    assert group.sigma == pytest.approx(WITHOUT_BLOCKS * expected.sigma[-1], rel=1e-6)


def test_rows_that_hide_a_parameter_give_an_error_and_no_minimum_norm_answer() -> None:
    """Only the wrist's rows left: the mass is in no equation."""
    problem = good_problem()
    loaded, difference = (rows_of(part, (3, 4, 5)) for part in (problem.loaded, problem.difference))
    blind = replace(problem, loaded=loaded, difference=difference)
    for method in (1, 3):
        with pytest.raises(InputError, match=r"undetermined, in .*M_L"):
            estimation.payload_estimate(blind, method)
