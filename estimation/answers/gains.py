"""Drive gains of a problem: free, of possible bodies, with covariances, and what to think of them."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters, Robot
from ..diagnosis.checks.joints import disagreement
from ..diagnosis.evidence import Evidence, Gained, KnownWeight
from ..diagnosis.loaded_rows import Bursts, bursts, scales
from ..diagnosis.rivals import rivals
from ..diagnosis.search import likely_causes
from ..diagnosis.verdict import judge
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import Estimate, Fit
from ..fit.robust import RobustCovariance, jackknife, student95
from ..gains.known_load import KnownLoad
from ..gains.possible import possible_gains
from ..gains.problem import GainProblem, free_gains
from ..gains.rests_on import gravity_acts, rests_on
from ..payload.by_joints import ByJoints, payload_by_joints, payload_over_time
from ..payload.methods import identify_payload
from ..payload.problem import PayloadProblem
from ..payload.result import PayloadEstimate
from .drive_gains import DriveGains


def identify_gains(problem: GainProblem, load: KnownLoad | Sequence[KnownLoad]) -> DriveGains:
    """Identify the drive gains on the current side, with bodies that can exist, and judge them.

    Args:
        problem: the reduced currents.
        load: what is known of the payload, in all mountings or in each.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    loads = problem.mountings.loads(load)
    with _explained(problem):
        free = free_gains(problem.equations, problem.weights, loads)
        held = int(np.argmin(np.diag(free.covariance)))
        best = possible_gains(problem, problem.equations, loads, free, held)
    # An error of the mass scales all gains alike.
    scale = max(one.mass_sigma / one.mass for one in loads) ** 2
    robust: RobustCovariance | None = None
    reason = problem.without_blocks

    def solve(part: Equations) -> Array:
        return -np.log(possible_gains(problem, part, loads, best, held).k)

    if problem.deletions:
        try:
            robust = jackknife(solve, problem.deletions, -np.log(best.k), problem.block_length)
        except InputError as error:
            reason = str(error)
    seen = [_Mounting.of(posed) for posed in problem.posed_by(1.0 / best.k)]
    reach = max((one.reach for one in seen), default=0.0)
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    logarithms = Estimate(
        names=tuple(f"K{j}" for j in range(1, problem.robot.n + 1)),
        values=-np.log(best.k),
        covariance=free.covariance + scale + reach**2,
        degrees_of_freedom=free.degrees_of_freedom,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        weights=problem.weights,
        robust=robust and replace(robust, covariance=robust.covariance + scale + reach**2),
    )
    tens = best.x[len(problem.base.columns) :].reshape(-1, len(PAYLOAD))
    gains = DriveGains(
        robot=problem.description,
        logarithms=logarithms,
        free_values=1.0 / free.k,
        gravity=gravity_acts(problem.robot),
        rests_on=rests_on(problem.robot),
        loads=loads,
        payloads=tuple(InertialParameters(ten) for ten in tens),
        without_robust=reason,
        recordings=problem.recordings,
        mountings=problem.mountings,
        disagreement=max((one.disagreement for one in seen), default=1.0),
        posed=tuple(one.problem for one in seen),
        by_joints=tuple(one.by_joints for one in seen),
        source=problem.source,
    )
    return replace(gains, verdict=judge(*_evidence(problem.description, gains, seen))) if seen else gains


@contextmanager
def _explained(problem: GainProblem) -> Iterator[None]:
    """Names what the recordings look like where they give no gains."""
    try:
        yield
    except InputError as error:
        source = problem.source
        likely = likely_causes(problem.description, source, apart=True) if source is not None else ()
        raise InputError("; ".join([str(error), *(cause.finding(cause.source).text for cause in likely)])) from None


class _Mounting(NamedTuple):
    """The weight in one mounting as the torques show it that the gains give."""

    problem: PayloadProblem
    free: PayloadEstimate
    by_joints: ByJoints
    outside: Bursts | None

    @staticmethod
    def of(problem: PayloadProblem) -> "_Mounting":
        free = identify_payload(problem, 4)
        weights = free.estimate.weights
        return _Mounting(problem, free, payload_by_joints(problem, weights), bursts(problem, weights))

    @property
    def disagreement(self) -> float:
        """Factor by which the joints disagree: the gains' own errors are those of these recordings."""
        n = self.problem.robot.n
        return disagreement(self.by_joints, np.zeros((n, n)))

    @property
    def reach(self) -> float:
        """Standard deviation, relative, that lets intervals reach what is found without bursts."""
        return abs(float(self.outside.change[9]) / self.free.mass) / student95(1e9) if self.outside else 0.0


def _evidence(robot: Robot, gains: DriveGains, seen: Sequence[_Mounting]) -> Iterable[Evidence]:
    """What the verdict looks at, mounting by mounting; what they share in the first."""
    weights = tuple(
        KnownWeight(name, load.mass, one.free.mass, float(one.free.larger_sigma[9]))
        for name, load, one in zip(gains.mountings.names, gains.loads, seen, strict=True)
    )
    for k, one in enumerate(seen):
        problem, source = one.problem, one.problem.source
        assert source is not None
        yield Evidence(
            robot=robot,
            source=source,
            condition=problem.unloaded.condition_numbers()[1] if problem.unloaded else None,
            parameters=problem.alone,
            estimates=(one.free,),
            by_joints=one.by_joints,
            stretches=payload_over_time(problem, one.free.estimate.weights),
            disagreement=one.disagreement,
            rivals=rivals(robot, source) if k == 0 else (),
            scales=scales(problem, one.free.estimate.weights),
            bursts=one.outside,
            gained=Gained(gains.larger_relative_sigma, weights) if k == 0 else None,
        )
