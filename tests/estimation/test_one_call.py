"""One call from recordings to a result: what the steps behind it give, for every question."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from dynident import Recording, Simulator, identify, identify_gains, identify_payload, load_robot, weigh
from dynident.common.errors import InputError
from dynident.estimation import (
    Gains,
    InEllipsoid,
    PayloadResult,
    Settings,
    answer_payload,
    known_mass,
    payload_problem,
)
from dynident.model import InertialParameters, Motion, Processing, robot_names

SETTINGS = Settings(Processing(cutoff=10.0, rate=100.0, decimate=2))
Pair = tuple[list[Recording], list[Recording]]


@pytest.fixture(scope="module")
def pair(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> Callable[[str], Pair]:
    """Recordings of an arm with a payload, and without."""

    def recordings(name: str) -> Pair:
        simulator = simulated(name)
        n = simulator.robot.n
        motion = wander(n, 4, points=20)
        return [simulator.record(motion, payload, [0.3] * n, 2)], [simulator.record(motion, None, [0.3] * n, 1)]

    return recordings


@pytest.mark.parametrize("name", ["rx90", "ur10e", "irb120"])
def test_a_payload_is_that_of_the_steps(name: str, pair: Callable[[str], Pair]) -> None:
    robot, (loaded, unloaded) = load_robot(name), pair(name)
    known, gains = [InEllipsoid((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))], Gains((0.01,))
    settings = Settings(SETTINGS.processing, methods=(3, 4), gains=gains)
    result = identify_payload(robot, loaded, unloaded, constraints=known, settings=settings)
    steps = answer_payload(
        payload_problem(robot, loaded, unloaded, settings=settings), (3, 4), constraints=known, gains=gains
    )
    assert result.to_dict() == steps.result.to_dict()
    assert {estimate.method for estimate in result.estimates} == {3, 4}
    assert result.working.problem.robot == robot


def test_a_payload_needs_no_recording_beside_a_robot_that_is_known(pair: Callable[[str], Pair]) -> None:
    robot, (loaded, unloaded) = load_robot("rx90"), pair("rx90")
    stored = identify(robot, unloaded, SETTINGS)
    asks: tuple[Callable[..., PayloadResult], ...] = (identify_payload, weigh)
    for ask in asks:
        plain, whole = (
            ask(robot, loaded, known=known, settings=SETTINGS) for known in (stored.estimate, stored.result)
        )
        assert plain.mass.low > 0.0
        assert plain.to_dict() == whole.to_dict()
        with pytest.raises(InputError, match="of robot 'rx90', not 'ur10e'"):
            ask(load_robot("ur10e"), loaded, known=stored.result, settings=SETTINGS)
        with pytest.raises(InputError, match="not Identification"):
            ask(robot, loaded, known=stored)
        with pytest.raises(InputError, match="list of recordings"):
            ask(robot, loaded[0], unloaded)


def test_a_weighing_takes_the_joints_asked_for(pair: Callable[[str], Pair]) -> None:
    robot, (loaded, unloaded) = load_robot("rx90"), pair("rx90")
    settings = Settings(SETTINGS.processing, joints=(2, 3, 5))
    assert weigh(robot, loaded, unloaded, settings=settings).joints == (2, 3, 5)


@pytest.mark.parametrize("ask", [identify_payload, weigh])
def test_nothing_to_compare_with_is_refused(ask: Callable[..., object], pair: Callable[[str], Pair]) -> None:
    loaded, _ = pair("rx90")
    with pytest.raises(InputError, match="without payload"):
        ask(load_robot("rx90"), loaded)


def test_gains_are_those_that_made_the_currents(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> None:
    simulator, K = simulated("ur10e"), np.array([12.0, 12.0, 10.0, 11.0, 11.0, 11.0])
    motion = wander(6, 5, points=24)

    def currents(body: InertialParameters | None) -> Sequence[Recording]:
        recording = simulator.record(motion, body, [0.1] * 6, int(body is None))
        return [Recording(recording.t, recording.q, recording.torque / K)]

    result = identify_gains(simulator.robot, currents(payload), currents(None), known_mass(payload.mass))
    assert result.drive_gains.values == pytest.approx(K, rel=0.05)


def test_a_result_of_every_arm_says_itself_in_ten_lines() -> None:
    assert {name: len(repr(load_robot(name)).splitlines()) <= 10 for name in robot_names()} == dict.fromkeys(
        robot_names(), True
    )
