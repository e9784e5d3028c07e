"""Mistakes of unit and joints that stand still are named."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import Settings, identify
from dynident.estimation.fit.own_equations import hidden_by
from dynident.estimation.signals.plausibility import check_apart, check_recordings, still_joints
from dynident.model import Motion, Recording, Robot, base_parameters, load_robot
from dynident.trajectories import Simulator

Wander = Callable[..., Motion]


def recording(motion: Motion, q_scale: float = 1.0, qd_scale: float | None = None) -> Recording:
    qd = None if qd_scale is None else qd_scale * motion.qd
    return Recording(motion.t, q_scale * motion.q, np.array(motion.q), qd, "log.csv")


def test_good_units_pass(rx90: Robot, wander: Wander) -> None:
    check_recordings(rx90, [recording(wander(6, 0))])
    check_recordings(rx90, [recording(wander(6, 0), qd_scale=1.0)])


@pytest.mark.parametrize("name", ["rx90", "tx40", "ur10e"])
def test_degrees_are_recognised(name: str, wander: Wander) -> None:
    with pytest.raises(InputError, match=r"log.csv: q\d reaches .* degrees"):
        check_recordings(load_robot(name), [recording(wander(6, 0), q_scale=np.degrees(1.0))])


def test_degrees_are_recognised_without_limits(wander: Wander) -> None:
    from dataclasses import replace

    from dynident.model import Limits

    robot = load_robot("rx90")
    free = replace(robot, joints=tuple(replace(joint, limits=Limits()) for joint in robot.joints))
    with pytest.raises(InputError, match="degrees"):
        check_recordings(free, [recording(wander(6, 0), q_scale=np.degrees(1.0))])


@pytest.mark.parametrize(
    ("factor", "words"), [(57.3, "degrees per second"), (0.5, "qd1 is 0.499 times"), (-1.0, "qd1 is -0.997 times")]
)
def test_speeds_in_another_unit(rx90: Robot, wander: Wander, factor: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        check_recordings(rx90, [recording(wander(6, 0), qd_scale=factor)])


def held(motion: Motion, joint: int) -> Motion:
    q, qd, qdd = np.array(motion.q), np.array(motion.qd), np.array(motion.qdd)
    q[:, joint - 1], qd[:, joint - 1], qdd[:, joint - 1] = 0.4, 0.0, 0.0
    return Motion(motion.t, q, qd, qdd)


def test_a_joint_that_never_moves_is_named_with_its_parameters(rx90: Robot, wander: Wander) -> None:
    motion = held(wander(6, 0), 4)
    assert still_joints([recording(motion)]) == (4,)
    assert still_joints([recording(motion), recording(wander(6, 1))]) == ()
    with pytest.raises(InputError) as caught:
        identify(rx90, [Simulator(rx90).record(motion)], Settings(robust=False))
    for word in ("joint 4 never moves", "FS4", "FV4", "IA4"):
        assert word in str(caught.value)
    assert "FS3" not in str(caught.value)


def test_what_a_still_joint_hides_is_what_data_do_not_determine(rx90: Robot) -> None:
    """On the RX90 joint 1 alone shows ZZ1R and its own friction."""
    base = base_parameters(rx90)
    hidden = hidden_by(rx90, base, (1,))
    assert {"ZZ1R", "FS1", "FV1"} <= set(hidden)
    assert not {"MX2R", "FS2", "IA3", "MX6"} & set(hidden)


def test_torques_that_no_joint_gives(wander: Wander) -> None:
    motion = wander(6, 0)
    for factor, words in ((1e6, "N·m"), (300.0, "more than a joint of ur10e can give")):
        strong = Recording(motion.t, motion.q, factor * motion.q, source="log.csv")
        with pytest.raises(InputError, match=words):
            check_recordings(load_robot("ur10e" if factor < 1e6 else "rx90"), [strong])


def test_a_dead_torque_channel_is_named(rx90: Robot, wander: Wander) -> None:
    motion = wander(6, 0)
    torque = np.array(motion.q)
    torque[:, 3] = 0.0
    with pytest.raises(InputError, match="torque of joint 4 is 0 throughout"):
        check_recordings(rx90, [Recording(motion.t, motion.q, torque)])


def test_the_same_recording_twice(rx90: Robot, wander: Wander) -> None:
    with pytest.raises(InputError, match="holds the same numbers"):
        check_recordings(rx90, [recording(wander(6, 0)), recording(wander(6, 1)), recording(wander(6, 0))])
    with pytest.raises(InputError, match="no recordings"):
        check_recordings(rx90, [])


def test_jumps_saturation_and_torques_out_of_an_arms_reach(rx90: Robot, wander: Wander) -> None:
    motion = wander(6, 0)
    q = np.array(motion.q)
    q[300:, 2] += 0.9
    strong = 50.0 * motion.q
    with pytest.raises(InputError, match=r"q3 jumps by 0\.\d+ .* at \d"):
        check_recordings(rx90, [Recording(motion.t, q, strong)])
    clipped = np.clip(strong, -20.0, 20.0)
    with pytest.raises(InputError, match=r"torque of joint 1 stays at its extreme -?20"):
        check_recordings(rx90, [Recording(motion.t, motion.q, clipped)])
    for factor, words in ((1e-3, "kN·m"), (1000.0, "mN·m")):
        with pytest.raises(InputError, match=words):
            check_recordings(rx90, [Recording(motion.t, motion.q, factor * strong)])
    coarse = np.round(strong / 5.0) * 5.0
    check_recordings(rx90, [Recording(motion.t, motion.q, coarse)])


def test_one_recording_with_and_without_payload(wander: Wander) -> None:
    single = recording(wander(6, 0))
    with pytest.raises(InputError, match="with payload holds the same numbers as"):
        check_apart([single], [recording(wander(6, 1)), single])
