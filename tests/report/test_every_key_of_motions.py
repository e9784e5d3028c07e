"""Every key of the documents on designed and weighed motions is the value that it comes from."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dynident import __version__
from dynident.apps.report import documents
from dynident.tests.report import made
from dynident.tests.report.every_key import same
from dynident.trajectories import Fourier, PayloadSet, Trapezoid, ViaPoints
from dynident.trajectories.design.full_trajectory import Rung

FLANGE = {"xyz": [0.125, 0.25, 0.375], "rpy_deg": [0.0, 0.0, 90.0], "source": "told there"}
LIMIT = SimpleNamespace(
    name="speed", worst="joint 2", value=1.5, limit=2.0, violation=0.25, relative=0.125, room=0.5
)
HELD = SimpleNamespace(
    kind="torque", values=lambda state: np.array([[0.25, 0.75, -0.5, 0.5]]), unit=np.array([20.0, 20.0, 20.0, 20.0])
)


def score(value: float) -> Any:
    """A motion judged."""
    sigma = {"A": 0.1 + value, "B": 0.2 + value}
    learnt = SimpleNamespace(
        condition_number=51.0 + value, condition_number_scaled=5.5 + value, log_det=33.0 + value, sigma=sigma
    )
    return SimpleNamespace(
        value=value, learnt=learnt, duration=12.0 + value, limits=(LIMIT,), max_violation=0.125 + value,
        feasible=False, violations=(f"too fast by {value}",), relative_sigma=lambda reference: {"A": 0.75},
        samples=SimpleNamespace(q=np.zeros((1, 2))),
    )  # fmt: skip


SEARCH = {"seed": 7, "starts": 8, "solver": "augmented", "evaluations": 900, "cpu_s": 6.5, "interrupted": True}
POINTS, TIMES, SPEEDS, STEEP = (made.numbers(*shape) for shape in ((3, 2), (2,), (3, 2), (3, 2)))
A, B = (made.numbers(*shape) for shape in ((2, 4), (2, 4)))
VIA = {"kind": "via points", "points": POINTS, "durations": TIMES}
PLANS = [
    (
        made.made(
            ViaPoints, points=POINTS, durations=TIMES, speeds=SPEEDS, accelerations=STEEP, segment=Trapezoid(0.3)
        ),
        VIA | {"speeds": SPEEDS, "accelerations": STEEP, "segments": Trapezoid(0.3).name, "ramp": 0.3},
    ),
    (
        made.made(Fourier, offset=TIMES, a=A, b=B, period=8.5),
        {"kind": "fourier", "offset": TIMES, "a": A, "b": B, "period": 8.5},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("plan", "motion"), [*PLANS, (None, {})])
def test_design(plan: Any, motion: dict[str, Any]) -> None:
    goal = SimpleNamespace(rate=14.0, data_length=60.0)
    problem: Any = SimpleNamespace(
        robot=SimpleNamespace(**vars(made.ROBOT)), criterion=SimpleNamespace(kind="a"), goal=goal,
        noise=np.array([1.5, 2.5]),
        torque_limited=False, payloads=PayloadSet.within(3.5, (0.1, 0.2, 0.3), (0.4, 0.5, 0.6), box=True),
        limits=(HELD,), of_kind=lambda *kinds: (HELD,), at_rest=lambda poses: None,
    )  # fmt: skip
    design: Any = SimpleNamespace(plan=plan, **SEARCH) if plan is not None else None
    floor: Any = SimpleNamespace(value=0.04, gap=0.06, states=300)
    judged, replayed = score(0.03), score(0.05)
    judged.problem = problem
    motion_of: Any = SimpleNamespace()
    document = documents.design_document(
        documents.JudgedMotion(
            "Motion", judged, motion_of, {"A": 2.0}, design=design, floor=floor, source="log.csv", replay=replayed
        )
    )
    same(
        document,
        {
            "robot": "arm", "robot_fingerprint": "f00", "criterion": "a", "criterion_value": 0.03,
            "condition_number": 51.03, "condition_number_scaled": 5.53, "log_det": 33.03,
            "predicted_sigma": {"A": 0.13, "B": 0.23}, "predicted_sigma_percent": {"A": 75.0, "B": None},
            "torque_noise": [1.5, 2.5], "independent_rate_hz": 14.0, "data_length_s": 60.0, "duration_s": 12.03,
            "limits": {"max_violation": 0.155, "met": False, "nearest": [vars(LIMIT)]},
            "payload_bounds": {
                "mass": 3.5, "region": "cube", "centre": [0.4, 0.5, 0.6], "axes": np.diag([0.1, 0.2, 0.3]),
                "holding_torque": [10.0, 15.0],
            },
            "floor": {"criterion_value": 0.04, "gap": 0.06, "states": 300},
            "evaluated": "log.csv",
            "val3_replay": {
                "criterion_value": 0.05, "condition_number": 51.05, "condition_number_scaled": 5.55,
                "duration_s": 12.05, "limits_met": False, "violations": ["too fast by 0.05"],
            },
            "assumed": {"speed": "told"},
            "version": __version__,
            **(SEARCH | {"motion": motion} if motion else {}),
        },
    )  # fmt: skip


def test_near() -> None:
    poses, ranges = made.numbers(2, 3), made.numbers(3)
    shape: Any = SimpleNamespace(joints=(2, 3), poses=poses, ranges=ranges)
    motion: Any = SimpleNamespace(
        period=2.5, repeats=4, transfer=1.25, duration=23.0,
        slowed=lambda speed: SimpleNamespace(duration=1.0 / speed),
    )  # fmt: skip
    visibility: Any = SimpleNamespace(joints=(2, 3), rank=5, parameters={"M": "alone"}, combinations=())
    spread: Any = SimpleNamespace(mass=0.011, com=made.numbers(3), inertia_com=made.numbers(3, 3))
    problem = SimpleNamespace(
        robot=made.ROBOT, criterion=SimpleNamespace(kind="a"), torque_limited=True, payloads=None
    )
    design: Any = SimpleNamespace(problem=problem, score=score(0.07), cpu_s=3.5, seed=9)
    ladder = [Rung(0.25, 6.5, 4.5, motion)]
    result: Any = SimpleNamespace(
        design=design, motion=motion, shape=shape, visibility=visibility, spread=spread, ladder=ladder
    )
    same(
        documents.near_document(result),
        {
            "robot": "arm", "criterion": "a",
            "near": {"poses": poses, "joints": [2, 3], "ranges": ranges, "period_s": 2.5, "repeats": 4,
                     "transfer_s": 1.25},
            "visibility": {"joints": [2, 3], "rank": 5, "parameters": {"M": "alone"}, "combinations": []},
            "predicted_sigma": {"mass": 0.011, "com": spread.com, "inertia_com": spread.inertia_com},
            "condition_number": 51.07, "condition_number_scaled": 5.57, "duration_s": 23.0, "rehearsal_s": 10.0,
            "ladder": [{"speed": 0.25, "bears_kg": 6.5, "bound_kg": 4.5, "duration_s": 23.0}],
            "cpu_s": 3.5, "seed": 9, "payload_bounds": None,
            "limits": {"max_violation": 0.195, "torque_checked": True, "nearest": [vars(LIMIT)]},
            "assumed": {"speed": "told", "torque": "told"},
        },
    )  # fmt: skip
