"""Recordings that contradict the robot's description: exit status 1, and why."""

import pytest
from dynident.tests.commands.runs import Run


@pytest.mark.long
def test_a_model_that_does_not_describe_the_robot_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run(
        "payload", "--robot", "rx90", "--unloaded", logs["flipped"], "--loaded", logs["loaded2"], "--method", "4"
    )
    assert status == 1
    assert "do not use" in out
    assert "signs" in out


@pytest.mark.long
def test_a_joint_counted_backwards_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    """The other joints still fit; the verdict looks at each."""
    pair = ("--unloaded", logs["mirrored_bare"], "--loaded", logs["mirrored_loaded"])
    status, out, _ = run("payload", "--robot", "rx90", *pair)
    assert status == 1
    assert "joint 5" in out


def test_a_robot_that_is_not_described_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run("identify", "--robot", "rx90", "--data", logs["constant"])
    assert status == 1
    assert "Do not use these parameters" in out
