"""A robot under its controller: laws of mechanics, the same alone and in lockstep, near its reference."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import (
    INERTIAL,
    InertialParameters,
    Robot,
    forward_kinematics,
    load_robot,
    mass_matrix,
    standard_columns,
)
from dynident.model.dynamics import dry_friction_names, smooth_dry_friction
from dynident.model.integration import SMOOTHING
from dynident.model.motion import Measurement
from dynident.trajectories import Controller, PointToPoint, SampledTrajectory, Simulator, plan_point_to_point
from dynident.trajectories.motions.via_points import random_points
from dynident.trajectories.simulation.closed_loop import CONTROLLERS, ClosedLoop, Task
from dynident.trajectories.simulation.disturbances import Disturbances, no_disturbances

WAVES = (8, 36)  # as in the demo: the code is compiled once for all tests


def motion(robot: Robot, seed: int, count: int = 4) -> PointToPoint:
    return plan_point_to_point(robot, random_points(robot, count, seed), 0.42, 0.5, 0.2)


def friction(robot: Robot) -> Array:
    return np.array([[robot.parameters[name] for name in dry_friction_names(robot)]])


def ripple(robot: Robot, amplitude: float) -> tuple[Disturbances, Array]:
    phases = np.linspace(-3.0, 3.0, 2 * robot.n).reshape(robot.n, 2)
    levels = replace(no_disturbances(robot.n), ripple=(amplitude,) * robot.n, waves=WAVES)
    return levels, phases


@pytest.fixture(scope="module")
def loop(rx90: Robot) -> ClosedLoop:
    return ClosedLoop(rx90, None, *ripple(rx90, 0.0))


@pytest.fixture(scope="module")
def pair(rx90: Robot, loop: ClosedLoop) -> list[tuple[Measurement, Array]]:
    """A trajectory of the paper's kind without and with the paper's payload."""
    reference = motion(rx90, 0, 8)
    return loop.run([Task("", reference), Task("", reference, PAYLOAD)])


def without_dry_friction(robot: Robot) -> Robot:
    return replace(robot, parameters=dict(robot.parameters) | dict.fromkeys(dry_friction_names(robot), 0.0))


def test_torques_are_those_of_the_inverse_model(rx90: Robot, loop: ClosedLoop) -> None:
    """Forward dynamics by base parameters against Newton-Euler by standard ones, friction and ripple added."""
    shaken = ClosedLoop(rx90, None, *ripple(rx90, 2.0))
    payload = PAYLOAD
    ((data, _),) = shaken.run([Task("", motion(rx90, 1), payload)])
    expected = Simulator(without_dry_friction(rx90)).measure(data.motion, payload).torque.copy()
    dry = smooth_dry_friction(rx90, SMOOTHING)
    expected += [np.array(dry(qd, friction(rx90)[0]))[:, 0] for qd in data.motion.qd]
    phases = ripple(rx90, 2.0)[1]
    for k, wave in enumerate(WAVES):
        expected -= 2.0 * np.sin(wave * data.motion.q + phases[:, k])
    assert np.abs(data.torque - expected).max() < 1e-9 * np.abs(expected).max()


def test_power_balance(rx90: Robot, pair: list[tuple[Measurement, Array]]) -> None:
    """What the motors give goes into height, speed and friction; energies from kinematics alone."""
    data = pair[1][0]
    payload = PAYLOAD
    some = slice(None, None, 20)
    energy = stored_energy(rx90, payload, data.motion.q[some], data.motion.qd[some])
    dry = smooth_dry_friction(rx90, SMOOTHING)
    viscous = np.array([rx90.parameters[f"FV{j}"] for j in range(1, 7)]) * data.motion.qd**2
    coupled = 2.0 * rx90.parameters["FVM6"] * data.motion.qd[:, 4] * data.motion.qd[:, 5]
    lost = viscous.sum(axis=1) + coupled
    lost += [float(qd @ np.array(dry(qd, friction(rx90)[0]))[:, 0]) for qd in data.motion.qd]
    power = (data.torque * data.motion.qd).sum(axis=1) - lost
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(data.motion.t))])
    assert np.abs(energy - energy[0] - work[some]).max() < 2e-3 * np.abs(energy - energy[0]).max()


def stored_energy(robot: Robot, payload: InertialParameters, q: Array, qd: Array) -> Array:
    """Energy stored in speed and height, one number a sample [J]."""
    values = dict(robot.parameters)
    for name, value in payload.named("6").items():
        values[name] += value
    A, chi = mass_matrix(robot), [values[name] for name in standard_columns(robot)]
    energy = np.array([0.5 * speed @ np.array(A(place, chi)) @ speed for place, speed in zip(q, qd, strict=True)])
    for link in range(1, robot.n + 1):
        part = replace(
            robot, joints=robot.joints[:link], joint_names=(), drives=replace(robot.drives, coupling=None)
        )
        frame = forward_kinematics(part)
        moment = np.array([values[f"M{axis}{link}"] for axis in "XYZ"])
        for k, place in enumerate(q):
            R, p = (np.array(value) for value in frame(place[:link]))
            energy[k] += 9.81 * (values[f"M{link}"] * p[2, 0] + R[2] @ moment)
    return energy


def test_alone_as_in_lockstep(rx90: Robot, loop: ClosedLoop) -> None:
    """Runs of different length and load do not know of each other."""
    runs = [
        Task("", motion(rx90, 1)),
        Task("", motion(rx90, 2, 3), PAYLOAD, 0.9 * friction(rx90)),
        Task("", motion(rx90, 3, 2), friction=1.1 * friction(rx90)),
    ]
    together = loop.run(runs)
    for run, (data, reference) in zip(runs, together, strict=True):
        ((alone, same),) = loop.run([run])
        assert np.array_equal(data.torque, alone.torque)
        assert np.array_equal(data.motion.q, alone.motion.q)
        assert np.array_equal(reference, same)


def test_tracking_differs_by_a_milliradian_under_load(pair: list[tuple[Measurement, Array]]) -> None:
    """The paper's largest error of position due to the load is 1e-3 rad."""
    difference = np.abs(pair[0][0].motion.q - pair[1][0].motion.q).max()
    assert 0.4e-3 < difference < 2e-3
    for data, reference in pair:
        assert np.abs(data.motion.q - reference).max() < 3e-3


@pytest.mark.parametrize("kind", ["proportional", "gravity"])
@pytest.mark.parametrize("sag", [2e-3, 4e-3, 9e-3])
def test_without_integral_action_the_payload_pulls_the_arm_off_its_path(rx90: Robot, kind: str, sag: float) -> None:
    """The worst joint sags by what was asked for: a controller with an integral keeps within a hundredth of it."""
    reference, payload = motion(rx90, 0), PAYLOAD
    soft = CONTROLLERS[kind].sagging(rx90, payload, [reference], sag)
    runs = [Task("", reference), Task("", reference, payload)]
    (bare, _), (loaded, _) = ClosedLoop(rx90, soft, *ripple(rx90, 0.0)).run(runs)
    apart = np.sqrt(np.mean((loaded.motion.q - bare.motion.q) ** 2, axis=0))
    assert apart.max() == pytest.approx(sag, rel=0.2)


def test_without_a_compiler(rx90: Robot, loop: ClosedLoop, monkeypatch: pytest.MonkeyPatch) -> None:
    run = Task("", motion(rx90, 3, 2))
    ((compiled, _),) = loop.run([run])
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    ((plain, _),) = ClosedLoop(rx90, None, *ripple(rx90, 0.0)).run([run])
    assert np.abs(plain.torque - compiled.torque).max() < 1e-8 * np.abs(compiled.torque).max()


def filled(robot: Robot) -> Robot:
    """A robot with links that can exist and drives that resist."""
    values = dict.fromkeys(standard_columns(robot), 0.0)
    for link in range(1, robot.n + 1):
        body = InertialParameters.from_com(3.0 / link, [0.02 * link, -0.03, 0.05], 0.05 * np.eye(3))
        values |= {f"{kind}{link}": float(x) for kind, x in zip(INERTIAL, body.vector, strict=True)}
        values |= {f"IA{link}": 0.3, f"FS{link}": 2.0, f"FV{link}": 3.0}
    values |= dict.fromkeys(robot.drives.coupling_names(), 0.5)
    values |= {name: 1.0 for name in values if name.startswith("OFF")}
    return replace(robot, parameters=values)


@pytest.mark.long
def test_a_robot_of_every_kind(prismatic: dict[str, Robot]) -> None:
    """Sliding joints, oblique gravity, offsets, coupling, spring: the motor torques are the inverse model's."""
    robot = filled(prismatic["crooked"])
    t = np.linspace(0.0, 1.0, 101)
    bump = (1.0 - np.cos(2.0 * np.pi * t)) ** 2
    reference = SampledTrajectory(t, 0.1 * np.outer(bump, np.linspace(1.0, -1.0, robot.n)))
    ((data, target),) = ClosedLoop(robot).run([Task("", reference)])
    expected = Simulator(without_dry_friction(robot)).measure(data.motion).torque.copy()
    dry = smooth_dry_friction(robot, SMOOTHING)
    expected += [np.array(dry(qd, friction(robot)[0]))[:, 0] for qd in data.motion.qd]
    assert np.abs(data.torque - expected).max() < 1e-8 * np.abs(expected).max()
    assert np.abs(data.motion.q - target).max() < 5e-3


def test_what_cannot_be_simulated_is_told(rx90: Robot) -> None:
    with pytest.raises(InputError, match="'ur10e' cannot be simulated: its description lacks XX1"):
        ClosedLoop(load_robot("ur10e"))
    massless = replace(rx90, parameters=dict.fromkeys(rx90.parameters, 0.0))
    with pytest.raises(InputError, match="not positive definite"):
        ClosedLoop(massless)
    limp = ClosedLoop(rx90, Controller(0.1, 0.1, 0.0, feed_forward=0.0))
    with pytest.raises(InputError, match="controller loses joint"):
        limp.run([Task("", motion(rx90, 1))])
    with pytest.raises(ValueError, match="gains must be positive"):
        Controller(position=0.0)
    with pytest.raises(ValueError, match="'motion' or 'gravity'"):
        replace(Controller(), compensates="nothing")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="does not sag"):
        Controller().sagging(rx90, PAYLOAD, [motion(rx90, 1)], 1e-3)
