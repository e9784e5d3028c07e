"""Drive gains of a problem: free, of possible bodies, with covariances, and what to think of them."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters, Robot
from ..diagnosis.causes import likely_causes
from ..diagnosis.evidence import Diagnosis, Evidence, Gained, KnownWeight
from ..diagnosis.states import states_of
from ..diagnosis.verdict import diagnose, judge
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import Estimate, Fit
from ..fit.robust import NORMAL95, RobustCovariance, jackknife
from ..gains.current_side import CurrentFit
from ..gains.known_load import KnownLoad
from ..gains.possible import possible_gains
from ..gains.problem import GainProblem, free_gains, gravity_acts, rests_on
from ..payload.by_joints import payload_over_time
from ..payload.methods import identify_payload
from ..payload.problem import PayloadProblem
from ..payload.result import PayloadEstimate
from .drive_gains import DriveGains


def identify_gains(problem: GainProblem, load: KnownLoad | Sequence[KnownLoad]) -> DriveGains:
    """Identify the drive gains on the current side, with bodies that can exist, and judge them.

    Args:
        load: what is known of the payload, in all mountings or in each.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    loads = problem.mountings.loads(load)
    with _explained(problem):
        free = free_gains(problem.equations, problem.weights, loads)
        sharpest = int(np.argmin(np.diag(free.covariance)))
        best = possible_gains(problem, problem.equations, loads, free, sharpest)
    robust, reason = _jackknifed(problem, loads, best, sharpest)
    mountings = [_Mounting.of(posed, problem.description) for posed in problem.posed_by(1.0 / best.k)]
    logarithms = _logarithms(problem, loads, free, best, robust, mountings)
    bodies = best.x[len(problem.base.columns) :].reshape(-1, len(PAYLOAD))
    gains = DriveGains(
        robot=problem.description,
        logarithms=logarithms,
        free_values=1.0 / free.k,
        gravity=gravity_acts(problem.robot),
        rests_on=rests_on(problem.robot),
        loads=loads,
        payloads=tuple(map(InertialParameters, bodies)),
        without_robust=reason,
        recordings=problem.recordings,
        mountings=problem.mountings,
        disagreement=max((mounting.diagnosis.disagreement for mounting in mountings), default=1.0),
        posed=tuple(mounting.problem for mounting in mountings),
        by_joints=tuple(mounting.diagnosis.by_joints for mounting in mountings),
        source=problem.source,
    )
    return replace(gains, verdict=judge(*_evidence(problem.description, gains, mountings))) if mountings else gains


def _jackknifed(
    problem: GainProblem, loads: Sequence[KnownLoad], best: CurrentFit, sharpest: int
) -> tuple[RobustCovariance | None, str]:
    """Robust covariance of ln K; None, and why, where there are too few blocks of time.

    Args:
        loads: what is known of the payload in each mounting.
        best: the gains by all blocks, from which each solution without one starts.
        sharpest: the joint (from 0) whose gain the currents tell best.
    """
    if not problem.deletions:
        return None, problem.without_blocks

    def solve(part: Equations) -> Array:
        return -np.log(possible_gains(problem, part, loads, best, sharpest).k)

    try:
        robust = jackknife(solve, problem.deletions, -np.log(best.k), problem.block_length)
    except InputError as error:
        return None, str(error)
    return robust, problem.without_blocks


def _logarithms(
    problem: GainProblem,
    loads: Sequence[KnownLoad],
    free: CurrentFit,
    best: CurrentFit,
    robust: RobustCovariance | None,
    mountings: "Sequence[_Mounting]",
) -> Estimate:
    """Logarithms of the gains, ln K = -ln k, with the errors that all of them share."""
    # An error of the weighed mass scales all gains alike, and so may a burst of other torques.
    mass_share = max(load.mass_sigma / load.mass for load in loads) ** 2
    burst_share = max((mounting.reach for mounting in mountings), default=0.0) ** 2
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    return Estimate(
        names=tuple(f"K{j}" for j in range(1, problem.robot.n + 1)),
        values=-np.log(best.k),
        covariance=free.covariance + mass_share + burst_share,
        degrees_of_freedom=free.degrees_of_freedom,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        weights=problem.weights,
        robust=robust and replace(robust, covariance=robust.covariance + mass_share + burst_share),
    )


@contextmanager
def _explained(problem: GainProblem) -> Iterator[None]:
    """Names what the recordings look like where they give no gains."""
    try:
        yield
    except InputError as error:
        likely = likely_causes(problem.description, states_of(problem.source), free_gains=True)
        raise InputError("; ".join([str(error), *(finding.text for finding in likely)])) from None


class _Mounting(NamedTuple):
    """The weight in one mounting as the torques show it that the gains give."""

    problem: PayloadProblem
    free: PayloadEstimate
    diagnosis: Diagnosis

    @staticmethod
    def of(problem: PayloadProblem, description: Robot) -> "_Mounting":
        """The gains' own errors are those of these recordings: none are allowed for."""
        free = identify_payload(problem, 4)
        return _Mounting(problem, free, diagnose(problem, free, None, description))

    @property
    def reach(self) -> float:
        """Standard deviation, relative, that lets intervals reach what is found without bursts."""
        bursts = self.diagnosis.effect("bursts")
        return abs(float(bursts.change[9]) / self.free.mass) / NORMAL95 if bursts else 0.0


def _evidence(robot: Robot, gains: DriveGains, mountings: Sequence[_Mounting]) -> Iterable[Evidence]:
    """What the verdict looks at, mounting by mounting; what they share in the first."""
    weights = tuple(
        KnownWeight(name, load.mass, mounting.free.mass, float(mounting.free.larger_sigma[9]))
        for name, load, mounting in zip(gains.mountings.names, gains.loads, mountings, strict=True)
    )
    for k, mounting in enumerate(mountings):
        problem, source = mounting.problem, mounting.problem.source
        assert source is not None
        yield Evidence(
            robot=robot,
            source=source,
            condition=problem.unloaded.condition_numbers()[1] if problem.unloaded else None,
            parameters=problem.alone,
            estimates=(mounting.free,),
            stretches=payload_over_time(problem, mounting.free.estimate.weights),
            gained=Gained(gains.larger_relative_sigma, weights) if k == 0 else None,
            compared=problem.compared,
            diagnosis=mounting.diagnosis if k == 0 else replace(mounting.diagnosis, alternatives=()),
        )
