"""Every key of the documents on checks of logs, rollouts and poses is the value that it comes from."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from dynident.apps.logs.following import Change, FollowingChange
from dynident.apps.logs.log_check import Excited, JointFacts, LogReport, Remark, RobotFit, RobotFits, TimeFacts
from dynident.apps.report import documents
from dynident.estimation.diagnosis.kinematics import PoseCheck, Reading, Readings
from dynident.model import Pose
from dynident.tests.report import made
from dynident.tests.report.every_key import same
from msgspec.structs import asdict


def test_check() -> None:
    time = TimeFacts(1000, 9.9, 101.0, (0.009, 0.011), 0.002, (0.5, 9.5))
    facts: list[Any] = [True, (-1.0, 1.1), 2.2, (-30.0, 31.0), 0.001, 0.05, 0.01]
    joint = JointFacts(*facts)
    look = LogReport(
        source="a.csv", notes=("resampled",), currents=True, usable=False, time=time,
        findings=(Remark("warning", "saturates"),), joints=(joint,), relative_residual=0.0125,
        excitation=(Excited("AR", 1.25, 3.5),), condition_number_scaled=12.5,
    )  # fmt: skip
    robot: Any = made.ROBOT
    fits = RobotFits("a.csv", ("t", "q1"), (RobotFit("arm", 0.25),), ("other",), None)
    expected = {
        "source": "a.csv", "columns": ["t", "q1"], "fitting": [{"robot": "arm", "residual": 0.25}],
        "others": ["other"], "fault": None,
    }  # fmt: skip
    same(
        documents.check_document(None, [documents.Look("a.csv", None, fits)]),
        {"robot": None, "logs": [], "fits": [expected]},
    )
    same(
        documents.check_document(robot, [documents.Look("a.csv", look)]),
        {
            "robot": "arm",
            "logs": [{
                "source": "a.csv", "notes": ["resampled"], "currents": True, "usable": False,
                "findings": [{"severity": "warning", "words": "saturates"}], "time": asdict(time),
                "joints": [asdict(joint)],
                "excitation": [{"name": "AR", "value": 1.25, "relative_sigma_percent": 3.5}],
                "relative_residual": 0.0125, "condition_number_scaled": 12.5,
            }],
        },
    )  # fmt: skip


def test_rollout() -> None:
    spread = {"identified": (0.01, 0.02), "constant speed": (0.03, 0.04)}
    rollout: Any = SimpleNamespace(
        source="a.csv", resting=np.array([False, True, False]), diverged=1, horizons=(0.5,), growth=1.25,
        errors=spread, spread=lambda by, seconds, resting: None if resting else spread[by],
        replay=SimpleNamespace(relative=0.045, joints=made.numbers(3), strayed=0.002),
    )  # fmt: skip
    expected = {
        "source": "a.csv", "starts_in_motion": 2, "starts_at_rest": 1, "diverged": 1,
        "horizons": [{"seconds": 0.5, "in_motion": spread, "at_rest": None}], "growth": 1.25,
        "replay_relative": 0.045, "replay_joints": rollout.replay.joints, "replay_strayed": 0.002,
    }  # fmt: skip
    same(documents.rollouts_document("arm", [rollout]), {"robot": "arm", "rollouts": [expected]})


def test_verify() -> None:
    change = Change("joint 2", 0.5, 0.25, 0.51, (0.4, 0.6), "fell")
    total = Change("all", 0.7, 0.35, 0.52, (0.3, 0.7), "fell")
    same(
        FollowingChange("following error", True, 0.015, (change,), total),
        {
            "compared": "following error", "tells": True, "lag_s": 0.015, "joints": [asdict(change)],
            "all": asdict(total),
        },
    )  # fmt: skip


def test_robot_check() -> None:
    reading = Reading((1, 0), (1, -1), (0, 3), (-1, 1))
    readings = Readings("share", 0.45, {reading: 0.035}, reading, ())
    rows = {
        "unit": "share", "as_recorded": 0.45, "suggested": reading.described(),
        "ranked": [{"residual": 0.035, "order": [2, 1], "sign": [1, -1], "zero_deg": [0, 270],
                    "torque_sign": [-1, 1]}],
    }  # fmt: skip
    base, tool = Pose.from_rpy((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)), Pose.from_rpy((0.7, 0.8, 0.9), (1.0, 1.1, 1.2))
    pose = PoseCheck("a.csv", 2, 0.006, 0.008, None, 0.9, base, tool, True, 1.0, readings)
    robot: Any = made.ROBOT
    log = {
        "log": "a.csv", "reproduced": False, "rms_m": 0.006, "largest_m": 0.008, "rms_angle_rad": None,
        "as_is_m": 0.9, "base": {"xyz_m": [0.1, 0.2, 0.3], "rpy_rad": list(base.rpy)},
        "tool": {"xyz_m": [0.7, 0.8, 0.9], "rpy_rad": None}, "base_and_tool_determined": True,
    }  # fmt: skip
    poses = [pose, replace(pose, readings=None)]
    expected = [log | {"readings": rows}, log | {"readings": None}]
    same(documents.robot_check_document(robot, poses, readings), {"robot": "arm", "poses": expected, **rows})
    same(documents.robot_check_document(robot, poses[1:], None), {"robot": "arm", "poses": expected[1:]})
