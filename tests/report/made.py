"""Answers made of numbers that all differ, so that a number under another key is seen. No estimation."""

from types import SimpleNamespace
from typing import Any, Literal
from unittest.mock import NonCallableMock

import msgspec
import numpy as np
from dynident.common.schema import Document, json_text
from dynident.estimation import PAYLOAD, Estimate, Gains, GainsResult, LongMotion, ShortMotion, SigmaRatio, Verdict
from dynident.estimation.diagnosis.evidence import Agreement, Evidence
from dynident.estimation.diagnosis.finding import note, warning
from dynident.estimation.diagnosis.verdict import judge
from dynident.estimation.fit.covariance import RobustCovariance
from dynident.estimation.fit.drive_gains import Fingerprints
from dynident.estimation.fit.essential import Elimination
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.own_equations import TermChoice
from dynident.estimation.gains.problem import known_mass, known_values
from dynident.estimation.payload.by_joints import ByJoints, JointsMass
from dynident.estimation.payload.nuisance import Wave
from dynident.estimation.payload.repeats import Repeats
from dynident.estimation.payload.result import PayloadEstimate
from dynident.estimation.possible.payload import Weighing
from dynident.estimation.possible.robot import PossibleRobot, PriorRobot
from dynident.estimation.results.parts import ProcessingDocument, ResidualDocument, RobustDocument
from dynident.estimation.results.payload import named
from dynident.estimation.results.robot import GainsTable, LoadDocument, MountingDocument
from dynident.model import InertialParameters, Pose, Processing
from dynident.model.friction import Friction

RNG = np.random.default_rng(17)
PROCESSING = Processing(101.0, 11.0, 7, still_speed=0.003, slow_fraction=0.04, slow_speed=0.06, max_mismatch=0.05)
FIT = Fit(np.array([1.1, 1.2, 1.3]), np.array([21.0, 22.0, 23.0]), (31, 32, 33))
CHECK = Fit(np.array([1.4, 1.5, 1.6]), np.array([24.0, 25.0, 26.0]), (34, 35, 36))
CHOICES = (TermChoice("FL2", True, 0.75, 0.125), TermChoice("FR1", False, 0.25, 0.5, "explains no more"))
DRIVES = SimpleNamespace(offsets=True, friction=(Friction("FL", 2),), side="link")
ROBOT = SimpleNamespace(
    n=2,
    name="arm",
    title="An arm",
    joints=(SimpleNamespace(kind="revolute", revolute=True), SimpleNamespace(kind="prismatic", revolute=False)),
    fingerprint="f00",
    mass=None,
    payload_frame="flange: plain",
    drives=DRIVES,
    coupling=SimpleNamespace(coulomb="paper"),
    flange_pose=Pose.from_rpy((0.125, 0.25, 0.375), (0.0, 0.0, 0.5 * np.pi)),
    sources={"flange": "told there"},
    rated_payload=12.25,
    assumed=lambda *parts: {name: "told" for name in parts if name in ("speed", "torque")},
)
SEEN: Fingerprints = {"unloaded": ("u",), "loaded": ("l",)}
ANY_ROBOT: Any = SimpleNamespace(
    **{**vars(ROBOT), "joints": (*ROBOT.joints, ROBOT.joints[0])}
)  # three, as fits have
GAINS = Gains((0.01, 0.02, 0.03), 0.004, np.diag([1e-4, 2e-4, 3e-4]).tolist(), SEEN, 6.5, ("said",))


def source(rate: float = 100.0) -> Any:
    """Recordings that were read with drive gains, processed at a rate [Hz]."""
    recording = SimpleNamespace(gains=(2.5, 3.5), rate=rate)
    return SimpleNamespace(
        processing=PROCESSING, loaded=(recording,), unloaded=(recording,), rate=rate, choices=CHOICES, pairs=pairs()
    )


def numbers(*shape: int) -> Any:
    """Numbers that occur nowhere else."""
    return RNG.uniform(1.0, 9.0, shape)


def made(kind: type, **values: Any) -> Any:
    """A value of a kind whose attributes are given, whatever they would be computed from."""
    return object.__new__(type(kind.__name__, (kind,), values))


def covariance(n: int) -> Any:
    """A covariance without equal entries."""
    A = numbers(n, n)
    return 1e-4 * (A @ A.T + np.diag(numbers(n)))


def estimate(names: tuple[str, ...], values: Any = None, n: int = 3) -> Estimate:
    """An estimate with robust covariance and errors of the gains."""
    c = len(names)
    robust = RobustCovariance(covariance(c), 8, 6, 1.75)
    values = numbers(c) if values is None else values
    gains = 0.1 * numbers(c, n), 1e-4 * np.diag(numbers(n))
    return Estimate(names, values, covariance(c), 301.5, FIT, numbers(n), robust, *gains)


def base() -> Any:
    """Two base parameters."""
    return SimpleNamespace(names=("AR", "BR"), columns=("A", "B"), groupings=lambda: ("AR = A + C", "BR = B - D"))


def elimination() -> Elimination:
    """One parameter left out of two."""
    path = np.array([[1.0, 0.9], [1.01, 0.05], [2.5, 0.0]])
    return Elimination(("A", "B"), path, SigmaRatio(), estimate(("B",)))


def identification() -> Any:
    """A robot of two base parameters."""
    problem = SimpleNamespace(
        equations=96, rows=(31, 32, 33), condition_numbers=lambda: (41.5, 4.25), independent=0.5
    )
    return SimpleNamespace(
        robot=ROBOT, base=base(), problem=problem, estimate=estimate(("A", "B")), essential=("B",),
        elimination=elimination(), without_robust="", choices=CHOICES, gains=GAINS, validation=CHECK,
        warnings=("warned",), recordings=source().unloaded, processing=PROCESSING,
        verdict=judge(Evidence(ANY_ROBOT, parameters=estimate(("A", "B")))),
    )  # fmt: skip


def holding() -> Any:
    """Something that holds an estimate back."""
    return SimpleNamespace(description="link 2", multiplier=0.125)


def possible_base(free: Estimate) -> Any:
    """The nearest robot that can exist."""
    return made(
        PossibleRobot, free=free, values=numbers(2), chi2_rise=3.25, active=(holding(),), status="Solved",
        min_eigenvalues=(0.01, 0.02), unidentifiable=("M1",), p_value=0.375,
    )  # fmt: skip


def possible_robot(free: Estimate) -> Any:
    """The robot nearest to a prior."""

    class Origin(SimpleNamespace):
        def _asdict(self) -> dict[str, Any]:
            return {"kind": self.kind, "base": self.base, "share": self.share}

        def decided_by(self) -> str:
            return f"by {self.kind}"

    prior, data = ("prior", (), 0.0), ("identified", ("AR",), 1.0)
    keys = ("kind", "base", "share")
    origins = {
        name: Origin(**dict(zip(keys, values, strict=True))) for name, values in (("M1", prior), ("A", data))
    }
    return made(
        PriorRobot, free=free, unidentifiable=("M1",), values=numbers(2), chi2_rise=5.25,
        active=(holding(),), status="prior", nearest=SimpleNamespace(chi2_rise=4.5),
        min_eigenvalues=(0.03, 0.04), p_value=0.625, budget=2.75, weight=0.875,
        distances=(0.5, 0.75), prior=SimpleNamespace(source="data sheet", bodies=(body(7.5),)),
        parameters={"M1": 4.5, "A": 5.5}, origins=origins,
    )  # fmt: skip


def body(mass: float = 3.0) -> InertialParameters:
    """A body that can exist."""
    return InertialParameters.from_com(
        mass, [0.01, 0.02, 0.1], [[0.03, 0.001, 0.002], [0.001, 0.04, 0.003], [0.002, 0.003, 0.05]]
    )


def free_payload(method: int = 3) -> PayloadEstimate:
    """A method's own estimate."""
    return PayloadEstimate(method, estimate(PAYLOAD, body().vector), "flange: plain", "too short")


def possible_payload(free: PayloadEstimate) -> Any:
    """The nearest payload that can exist, held back by one constraint, weighed once."""
    constraint = SimpleNamespace(description="mass from 1 kg")
    result = SimpleNamespace(
        values=numbers(10), min_pseudo_inertia_eigenvalue=0.0021, constraints=(constraint,), chi2_rise=2.125,
        p_value=0.4375, status="Solved", free=SimpleNamespace(sigma=numbers(10)),
        weighings=(Weighing(3.1, 0.05, 3.2, 0.06, 7.5, z=1.28, p_value=0.21),),
    )  # fmt: skip
    intervals = SimpleNamespace(
        parameters=numbers(10, 2), com=numbers(3, 2), inertia_com=numbers(3, 3, 2), principal_moments=numbers(3, 2)
    )
    tested = SimpleNamespace(description="mass from 1 kg", multiplier=0.33, p_value=0.0625)
    return SimpleNamespace(
        method=free.method, free=free, result=result, body=body(3.4), intervals=intervals, gains=GAINS, robust=True,
        principal_moments=numbers(3), tested=(tested,), conflict=False,
    )  # fmt: skip


def by_joints() -> ByJoints:
    """A joint that sees the mass, one that does not, both together."""
    return ByJoints(
        (
            JointsMass((1,), True, 3.01, 0.11, (2.8, 3.3), 0.98, 0.015),
            JointsMass((2,), False, None, float("nan"), None, None, float("nan")),
            JointsMass((1, 2), True, 3.02, 0.12, (2.7, 3.4)),
        )
    )


def pairs() -> tuple[Any, ...]:
    """Two pairs of recordings."""
    return tuple(
        SimpleNamespace(lag=lag, max_mismatch=far, rms_mismatch=0.5 * far)
        for lag, far in ((0.011, 0.0071), (0.012, 0.0072))
    )


def payload() -> Any:
    """The answer of ``payload``."""
    free = free_payload()
    best = possible_payload(free)
    problem = NonCallableMock(
        torque_noise=(np.array([0.31, 0.32, 0.33]), 7.5),
        spec=LongMotion,
        robot=ROBOT,
        source=source(99.5),
        friction={},
        base=base(),
        robot_estimate=SimpleNamespace(fit=FIT),
        unloaded=SimpleNamespace(equations=120, condition_numbers=lambda: (42.5, 4.5)),
        loaded=SimpleNamespace(equations=130),
    )
    return SimpleNamespace(
        problem=problem, evidence=evidence(validation=CHECK, repeats=None),
        estimates=(free,), constrained=(best,), possible=best,
        recommended=SimpleNamespace(method=3), free=SimpleNamespace(method=3), gains=GAINS, scale=None,
        recommendation=(3, "one path"),
        **quantities(),
        elimination=elimination(), left_out={2: "no pair"}, warnings=("warned",),
        verdict=Verdict("mass_and_com_only", ("why",)),
    )  # fmt: skip


def evidence(**more: Any) -> Any:
    """What the verdict looks at, the payload by joints among it."""
    return SimpleNamespace(diagnosis=SimpleNamespace(by_joints=by_joints()), **more)


def quantities() -> dict[str, Any]:
    """Mass, centre of mass and their spread."""
    return {
        "mass": 3.05, "com": numbers(3), "intervals": np.vstack([[2.9, 3.2], numbers(3, 2)]),
        "spread": SimpleNamespace(mass=0.07, com=numbers(3), inertia_com=numbers(3, 3)),
    }  # fmt: skip


def weighing(possible: bool) -> Any:
    """The answer of ``weigh``, with all ten visible or the mass and two first moments alone."""
    free = free_payload(1)
    determined = free.estimate if possible else estimate(("MX_L", "MY_L", "M_L"))
    payload = PayloadEstimate(1, determined, "flange: plain", "too short", not possible)
    visibility = SimpleNamespace(joints=(1, 2), rank=3, parameters={"M": "alone"}, combinations=("MZ + M",))
    wave = Wave("a.csv", 2, 36.0, 0.75)
    problem = NonCallableMock(
        spec=ShortMotion,
        joints=(1, 2), torque_rms=np.array([11.0, 12.0, 13.0]), visibility=visibility,
        held=SimpleNamespace(held={}, joints=(0, 1), sigma=np.array([0.21, 0.22])),
        ripple=(wave,),
        robot=ROBOT, source=source(98.5), known=None,
        loaded=SimpleNamespace(
            equations=140, select=lambda names: SimpleNamespace(condition_numbers=lambda: (43.5, 4.75))
        ),
    )  # fmt: skip
    best = possible_payload(free) if possible else None
    repeats = Repeats(("a.csv", "b.csv"), (3.03, 3.04), (0.13, 0.14), 0.05, 1.5, 0.001, 0.002, False)
    ten = np.full(10, np.nan)
    ten[[6, 7, 9]] = 0.03, 0.06, 3.05
    names, agreement = ("mass", "centre of mass", "inertia"), (Agreement("difference", 3.06, numbers(3)),)
    judged = {name: SimpleNamespace(use=f"use {name}", why=f"why {name}") for name in names}
    return SimpleNamespace(
        problem=problem, free=payload, estimates=(payload,), possible=best,
        constrained=(best,) if possible else (), ten=ten, **quantities(),
        gains=None, scale=SimpleNamespace(mass=3.1, sigma=0.05), model=None,
        evidence=evidence(agreement=agreement, repeats=repeats if possible else None, judged=judged),
        verdict=Verdict("use", ()),
        recommendation=(1, ""),
    )  # fmt: skip


MOTORS = np.array([10.0, 21.0, 32.0])
"""N·m/A."""


def logarithms() -> Estimate:
    """ln K of three motors, the last one hardly known."""
    robust = RobustCovariance(1e-4 * np.diag([1.0, 4.0, 2500.0]), 9, 8, 1.25)
    return Estimate(
        ("K1", "K2", "K3"), np.log(MOTORS), 1e-4 * np.diag([4.0, 1.0, 900.0]), 301.5, FIT, numbers(3), robust
    )


def drive_gains(level: Literal["identified_only", "do_not_use"] = "identified_only") -> GainsResult:
    """The answer of ``gains``."""
    own = logarithms()
    first, second = (named(body(mass).vector) for mass in (6.0, 6.5))
    return GainsResult(
        robot="arm",
        robot_title="An arm",
        processing=ProcessingDocument.made(ANY_ROBOT, source().processing, ()),
        load=LoadDocument(
            known_values((known_mass(6.1, 0.015), known_mass(6.2, 0.012))),
            0.015,
            first,
            (MountingDocument(1, first), MountingDocument(3, second)),
        ),
        drive_gains=GainsTable.made(own, 1.25, MOTORS + 0.5, ("gravity", "speed", "nothing")),
        fingerprints={"unloaded": ("u0", "u1"), "loaded": ("l0",)},
        robust=RobustDocument.made(own.robust, ""),
        relative_residual=ResidualDocument.of(FIT),
        disagreement=1.25,
        verdict=Verdict.made(level, warning("motor 3"), note("a note")),
    )


def written(document: Document) -> dict[str, Any]:
    """Plain values, as in the file."""
    read: dict[str, Any] = msgspec.json.decode(json_text(document))
    return read
