"""Wrong inputs, made from simulated recordings; what each of them ends in must name its cause."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from dynident.apps.logs.read import read_recording
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import (
    CentreOfMassInBox,
    InEllipsoid,
    KnownMass,
    MassBounds,
    Settings,
    SolverError,
    answer_payload,
    payload_problem,
)
from dynident.model import Processing, Recording, Robot, load_robot
from dynident.tests.estimation.mistakes import (
    Change,
    clipped,
    counted_backwards,
    drifting,
    good,
    late_half,
    lengthened,
    on_position,
    on_torque,
    only_joint,
    read_at,
    reordered,
    same,
    scaled,
    slipped,
    speeds,
    static_poses,
    stuck,
    stuck_to_the_end,
    uncoupled,
    with_noise,
    without_gravity,
)


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
    """What an input ends in: "error" or a level, the words, and the recommended mass [kg]."""

    level: str
    text: str
    mass: float = float("nan")


def ending(case: Wrong) -> Ending:
    """Run one case as the command does."""
    try:
        problem = payload_problem(case.robot, case.loaded, case.unloaded, settings=Settings(case.processing))
        answer = answer_payload(problem, **case.options)
    except (InputError, SolverError) as error:
        return Ending("error", str(error))
    return Ending(answer.verdict.level, " | ".join(answer.verdict.reasons), answer.recommended.mass)


def both(name: str, label: str, words: str, change: Change, **more: Any) -> Wrong:
    """One mistake made in both recordings."""
    _, bare, loaded, body = good(name)
    robot = more.pop("robot", invented.robot(name))
    return Wrong(f"{name}: {label}", words, robot, (change(loaded),), (change(bare),), body.mass, **more)


def loaded_only(name: str, label: str, words: str, change: Change, **more: Any) -> Wrong:
    """A mistake in the loaded recording alone."""
    _, bare, loaded, body = good(name)
    return Wrong(f"{name}: {label}", words, invented.robot(name), (change(loaded),), (bare,), body.mass, **more)


def swapped(name: str) -> Wrong:
    _, bare, loaded, body = good(name)
    return Wrong(f"{name}: swapped pair", "swapped", invented.robot(name), (bare,), (loaded,), body.mass)


def nothing_new(name: str) -> Wrong:
    motion, _, loaded, body = good(name)
    again = invented.recorded(name, motion, body, 99)
    words = "does not differ from zero.*same load"
    return Wrong(f"{name}: payload in both recordings", words, invented.robot(name), (loaded,), (again,), body.mass)


def of_another(name: str, another: str) -> Wrong:
    words = f"it is a recording of robot '{name}'|outside the range"
    return both(name, f"described as {another}", words, same, robot=load_robot(another))


def two_motions(name: str) -> Wrong:
    _, bare, _, body = good(name)
    loaded = invented.recorded(name, invented.motion(name, 9, points=11), body, 6)
    return Wrong(
        f"{name}: two trajectories for method 3", "not the same trajectory", invented.robot(name), (loaded,),
        (bare,), body.mass, {"methods": (3,)},
    )  # fmt: skip


def given_twice(name: str) -> Wrong:
    _, bare, loaded, body = good(name)
    copy = replace(loaded, source="again.csv")
    return Wrong(
        f"{name}: one recording twice", "given twice", invented.robot(name), (loaded, copy), (bare,), body.mass
    )


def one_file_for_both(name: str) -> Wrong:
    _, bare, _, body = good(name)
    return Wrong(f"{name}: one file for both", "same numbers", invented.robot(name), (bare,), (bare,), body.mass)


def cases() -> Iterator[Wrong]:
    """All wrong inputs."""
    yield from _one_sided()
    yield from _of_channels()
    yield from _of_description()
    yield from _of_knowledge()


def _one_sided() -> Iterator[Wrong]:
    """The wrong recordings, or the payload not what it was."""
    body = good("rx90")[3]
    yield both("rx90", "static poses", "jumps", static_poses("rx90"))
    yield both("ur10e", "only joint 6 moves", "joint 1, 2, 3, 4, 5 never moves", only_joint("ur10e", 6))
    yield from (swapped(name) for name in invented.NAMES)
    yield from (nothing_new("rx90"), two_motions("rx90"), given_twice("tx40"), one_file_for_both("rx90"))
    yield loaded_only("rx90", "payload put down halfway", "mass changes", late_half("rx90", None))
    yield loaded_only("rx90", "payload slips by 80 mm", "centre of mass moves", late_half("rx90", slipped(body)))
    yield loaded_only("tx40", "torque drifts", "torque of joint 2 drifts by", drifting(2, 1.0))
    yield both("rx90", "cut-off below the motion", "below the motion", same, processing=_slow("rx90"))
    yield loaded_only("ur10e", "torques of another sign", "negative mass|sign", on_torque(lambda x: -x))


def _slow(name: str) -> Processing:
    return replace(invented.robot(name).processing, cutoff=0.6)


def _of_channels() -> Iterator[Wrong]:
    """Units, signs, order and time of the columns."""
    yield both("rx90", "degrees", "degrees", on_position(np.degrees))
    yield both("tx40", "mN·m", "mN·m|N·m", on_torque(lambda x: 1000.0 * x))
    yield both("ur10e", "milliampere", "N·m/A", on_torque(lambda x: 1000.0 * x / 10.0))
    yield both("rx90", "kN·m", "kN·m", on_torque(lambda x: 1e-3 * x))
    percent = np.array([3.1, 2.9, 8.3, 25.0, 50.0, 83.0]) / 10.0
    yield both("rx90", "percent of each drive", "share no unit|drive gain", on_torque(lambda x: percent * x))
    yield both("rx90", "motor-side torque", "share no unit|drive gain", on_torque(_motor_side))
    for joint in (2, 3, 4, 5, 6):
        yield both(
            "rx90", f"gain {joint} twice too large", f"joint {joint} (shows|is about) [12]", scaled(joint, 2.0)
        )
    for joint in (1, 3, 4):
        yield both(
            "ur10e",
            f"gain {joint} halved",
            f"joint {joint} (shows 0|is about 2 times too small)",
            scaled(joint, 0.5),
        )
    for joint in (2, 5):
        words = f"friction of joint {joint} comes out negative"
        yield both("tx40", f"sign of torque {joint}", words, scaled(joint, -1.0))
    yield both("ur10e", "sign of torque 6", "friction of joint 6 comes out negative", scaled(6, -1.0))
    yield both("rx90", "joint 2 counted backwards", "joint 2 is counted the other way", counted_backwards(2))
    yield both("rx90", "joints 2 and 3 exchanged", "joints 2 and 3 are exchanged", reordered(1, 3, 2, 4, 5, 6))
    yield both("ur10e", "joints 4 and 5 exchanged", "joints 4 and 5 are exchanged", reordered(1, 2, 3, 5, 4, 6))
    yield both("rx90", "torque 0.2 s late", "torque lags position by about 0.20 s", read_at(lambda t: t - 0.2))
    yield loaded_only("ur10e", "torque 0.2 s late", "lags position by about 0.(19|2)", read_at(lambda t: t - 0.2))
    yield both("rx90", "two clocks", "two clocks", read_at(lambda t: 0.985 * t))
    yield both("rx90", "dead torque channel", "dead", on_torque(lambda x: x * [1, 1, 1, 0, 1, 1]))
    yield both("tx40", "torque channel of noise", "joint 3", on_torque(lambda x: with_noise(x, 3)))
    yield both("rx90", "saturated torque", "saturated", clipped(0.5))
    yield both("rx90", "speeds in degrees per second", "degrees per second", speeds(np.degrees(1.0)))
    yield both("rx90", "encoder 3 sticks for a while", "stuck encoder|encoder of joint 3 is stuck", stuck(3))
    yield both("ur10e", "encoder 2 stuck from half way", "encoder of joint 2 is stuck", stuck_to_the_end(2))


def _motor_side(torque: Array) -> Array:
    return np.asarray(torque / np.array([32.0, 32.0, 45.0, 48.0, 45.0, 32.0]) * 2.0)


def _of_description() -> Iterator[Wrong]:
    """The robot is not the one described."""
    rx90, ur10e = invented.robot("rx90"), invented.robot("ur10e")
    turned = replace(rx90, gravity=(0.0, 0.0, 9.81))
    yield both("rx90", "gravity reversed", "gravity points the other way", same, robot=turned)
    turned = replace(ur10e, gravity=(0.0, 0.0, 9.81))
    yield both("ur10e", "gravity reversed", "gravity points the other way", same, robot=turned)
    wall = replace(rx90, gravity=(9.81, 0.0, 0.0))
    yield both("rx90", "on the floor, described as on a wall", "gravity points along -z", same, robot=wall)
    yield both("rx90", "gravity-compensated torques", "hold no gravity", without_gravity("rx90"))
    yield both("ur10e", "gravity-compensated torques", "hold no gravity", without_gravity("ur10e"))
    yield of_another("rx90", "ur10e")
    yield of_another("ur10e", "rx90")
    yield both("rx90", "coupling left out", "drives of joints 5 and 6 are coupled", same, robot=uncoupled(rx90))
    longer = lengthened(rx90, 3, "d", 1.1)
    yield both("rx90", "a length 10 % too long", "a recording of robot 'rx90'|length d3", same, robot=longer)
    quarter = np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0])
    yield both("ur10e", "zero of q3 off by 90 degrees", "zero of q3 is off", on_position(lambda q: q + quarter))


def _of_knowledge() -> Iterator[Wrong]:
    """What is said of the payload is not true."""
    mass = good("rx90")[3].mass

    def known(label: str, words: str, constraint: Any) -> Wrong:
        return both("rx90", label, words, same, options={"constraints": (constraint,)})

    yield known("mass bound excludes the truth", "contradict the constraint: mass", MassBounds(0.0, 0.6 * mass))
    yield known("weighed mass is another's", "the scale shows", KnownMass(1.5 * mass, 0.01))
    ellipsoid = InEllipsoid((0.0, 0.0, -0.3), (0.1, 0.1, 0.1))
    yield known("ellipsoid in the wrong place", "contradict the constraint: .*ellipsoid", ellipsoid)
    box = CentreOfMassInBox((-0.02, -0.02, -0.3), (0.02, 0.02, -0.1))
    yield known("centre of mass in the wrong box", "contradict the constraint: centre of mass", box)


def written(path: Path, recording: Recording, t: Array) -> Path:
    """A CSV file with another column of time."""
    n = recording.q.shape[1]
    header = ["t", *(f"q{j}" for j in range(1, n + 1)), *(f"tau{j}" for j in range(1, n + 1))]
    table = np.column_stack([t, recording.q, recording.torque])
    np.savetxt(path, table, delimiter=",", header="# gain_sigma = 0\n" + ",".join(header), comments="", fmt="%.9g")
    return path


def reading(path: Path, t: Callable[[Array], Array]) -> Ending:
    """What reading a file with another column of time ends in."""
    recording = good("rx90")[1]
    try:
        read = read_recording(written(path, recording, t(recording.t)), invented.robot("rx90"))
    except InputError as error:
        return Ending("error", str(error))
    return Ending("read", "; ".join(read.notes))
