"""Drive gains of a problem: free, of possible bodies, with covariances, and whether to use them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from msgspec import UNSET

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.speech import Speaks
from ...common.threads import one_thread
from ...model import InertialParameters, Recording, Robot
from ..diagnosis.causes import likely_causes
from ..diagnosis.evidence import KNOWN_WELL, Evidence, Gained, KnownWeight
from ..diagnosis.finding import Verdict
from ..diagnosis.states import states_of
from ..diagnosis.verdict import diagnose, judge
from ..equations.equations import PAYLOAD
from ..fit.covariance import NORMAL95, RobustCovariance, jackknife
from ..fit.drive_gains import Fingerprints, fingerprints
from ..fit.estimate import Estimate, Fit
from ..fit.settings import DEFAULTS, Settings
from ..gains.known_load import KnownLoad, Mountings, known_values
from ..gains.possible import possible_gains
from ..gains.problem import GainProblem, free_gains, gain_problem, rests_on
from ..payload.by_joints import ByJoints
from ..payload.long_motion import LongMotion, Source
from ..payload.methods import payload_estimate
from ..results.parts import ProcessingDocument, ResidualDocument, RobustDocument, VerdictDocument
from ..results.payload import named
from ..results.robot import GainsResult, GainsTable, LoadDocument, MountingDocument
from .payload import check_lists
from .system import DRAWN, TorquePrediction, payload_prediction


@dataclass(frozen=True, repr=False)
class DriveGains(Speaks):
    """Drive gains: torque per current of each motor, on the joint side."""

    robot: Robot  # its equations those of the joints
    logarithms: Estimate  # ln K of possible bodies, its fit that of the currents [A]; covariances hold the mass's
    free_values: Array  # gains without constraints [N·m/A or N/A], shape (n,)
    rests_on: tuple[str, ...]  # per motor, the torques that its gain rests on
    loads: tuple[KnownLoad, ...]  # what was known of the payload in each mounting
    payloads: tuple[InertialParameters, ...]  # as identified in each mounting, what is known as given
    without_robust: str = ""  # why there is no robust covariance
    recordings: Fingerprints = field(default_factory=dict)
    mountings: Mountings = Mountings()
    disagreement: float = 1.0  # factor on every standard deviation, by the joints' payload ratios
    verdict: Verdict = Verdict("use")
    posed: tuple[LongMotion, ...] = ()  # each mounting's payload problem with the torques that the gains give
    by_joints: tuple[ByJoints, ...] = ()  # the weight in each of them as single joints see it
    source: Source | None = None  # the recordings of currents, and how they were processed

    @property
    def headline(self) -> str:
        """State robot, number of known gains and verdict in a line."""
        return self.result.headline

    @cached_property
    def result(self) -> GainsResult:
        """Result that ``--json`` writes and ``--drive-gains`` reads."""
        return gains_result(self)

    @cached_property
    def values(self) -> Array:
        """Gains K [N·m/A or N/A], shape (n,)."""
        return np.exp(self.logarithms.values)

    @property
    def larger_relative_sigma(self) -> Array:
        """The larger of formula's and robust relative standard deviation, times ``disagreement``, shape (n,)."""
        return self.disagreement * self.logarithms.larger_sigma

    @property
    def larger_relative_covariance(self) -> Array:
        """Covariance of ln K with the larger standard deviations, n x n.

        Its correlations are the robust ones where there are some.
        """
        robust, sigma = self.logarithms.robust, self.larger_relative_sigma
        if robust is None:
            return self.disagreement**2 * self.logarithms.covariance
        return np.asarray(robust.covariance * np.outer(sigma / robust.sigma, sigma / robust.sigma))

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few recordings, current times gain, and those of robot and weight: all were used."""
        chosen = [
            (problem, body, recording, problem.source.processing)
            for problem, body in zip(self.posed, self.payloads, strict=False)
            for recording in problem.source.loaded
        ]
        return tuple(payload_prediction(*one, held_out=False) for one in chosen[:DRAWN])

    @property
    def identified(self) -> tuple[bool, ...]:
        """True for each joint whose gain is known to 5 % (1 sigma)."""
        return tuple(bool(sigma <= KNOWN_WELL) for sigma in self.larger_relative_sigma)


@one_thread
def identify_gains(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> GainsResult:
    """Identify drive gains from motor currents without and with a weight that is known, and judge them.

    Args:
        loaded: recordings with the weight, whose ``torque`` holds motor currents [A].
        unloaded: the same without it.
        load: the weight, or that of each mounting.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    check_lists(loaded, unloaded)
    return answer_gains(gain_problem(robot, unloaded, loaded, settings, load, mounting), load).result


def answer_gains(problem: GainProblem, load: KnownLoad | Sequence[KnownLoad]) -> DriveGains:
    """Identify the drive gains on the current side, with bodies that can exist, and judge them.

    Args:
        load: what is known of the payload, in all mountings or in each.

    Raises:
        InputError: if the recordings do not determine the gains.
    """
    loads = problem.mountings.loads(load)
    try:
        free = free_gains(problem.equations, problem.weights, loads)
        sharpest = int(np.argmin(np.diag(free.covariance)))
        best = possible_gains(problem, problem.equations, loads, free, sharpest)
    except InputError as error:  # what the recordings look like is told with it
        likely = likely_causes(problem.description, states_of(problem.source), free_gains=True)
        raise InputError("; ".join([str(error), *(finding.text for finding in likely)])) from None
    robust: RobustCovariance | None = None
    reason = problem.without_blocks
    if problem.deletions:
        try:
            groups = [
                [-np.log(possible_gains(problem, part, loads, best, sharpest).k) for part in group]
                for group in problem.deletions
            ]
            robust = jackknife(groups, -np.log(best.k), max(each.block_length for each in problem.posed))
        except InputError as error:
            reason = str(error)
    # The weight as the torques show it that the gains give; the gains' own errors are those of these recordings.
    posed = problem.posed_by(1.0 / best.k)
    identified = [payload_estimate(each, 4) for each in posed]
    diagnoses = [
        diagnose(each, own, None, problem.description) for each, own in zip(posed, identified, strict=True)
    ]
    # An error of the weighed mass scales all gains alike, and so may a burst of other torques.
    bursts = [(own.mass, diagnosis.effect("bursts")) for own, diagnosis in zip(identified, diagnoses, strict=True)]
    reach = max((abs(float(found.change[9]) / mass) / NORMAL95 for mass, found in bursts if found), default=0.0)
    shared = max(load.mass_sigma / load.mass for load in loads) ** 2 + reach**2
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    logarithms = Estimate(
        names=tuple(f"K{j}" for j in range(1, problem.robot.n + 1)),
        values=-np.log(best.k),
        covariance=free.covariance + shared,
        degrees_of_freedom=free.degrees_of_freedom,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        weights=problem.weights,
        robust=robust and replace(robust, covariance=robust.covariance + shared),
    )
    gains = DriveGains(
        robot=problem.description,
        logarithms=logarithms,
        free_values=1.0 / free.k,
        rests_on=rests_on(problem.robot),
        loads=loads,
        payloads=tuple(map(InertialParameters, best.x[len(problem.base.columns) :].reshape(-1, len(PAYLOAD)))),
        without_robust=reason,
        recordings=fingerprints(problem.source.unloaded, problem.source.loaded),
        mountings=problem.mountings,
        disagreement=max((diagnosis.disagreement for diagnosis in diagnoses), default=1.0),
        posed=posed,
        by_joints=tuple(diagnosis.by_joints for diagnosis in diagnoses),
        source=problem.source,
    )
    weights = tuple(
        KnownWeight(name, load.mass, own.mass, float(own.larger_sigma[9]))
        for name, load, own in zip(gains.mountings.names, loads, identified, strict=True)
    )
    # What the mountings have in common stands in the evidence of the first.
    evidence = [
        Evidence(
            robot=problem.description,
            source=each.source,
            condition=each.unloaded.condition_numbers()[1] if each.unloaded else None,
            parameters=each.robot_estimate,
            estimates=(own,),
            gained=None if k else Gained(gains.larger_relative_sigma, weights),
            compared=each.source.compared,
            diagnosis=replace(diagnosis, alternatives=()) if k else diagnosis,
        )
        for k, (each, own, diagnosis) in enumerate(zip(posed, identified, diagnoses, strict=True))
    ]
    return replace(gains, verdict=judge(*evidence))


def gains_result(gains: DriveGains) -> GainsResult:
    """Collect what ``gains`` answers."""
    processing = gains.source.processing if gains.source else gains.robot.processing
    own, sigma, tens = gains.logarithms, gains.larger_relative_sigma, [named(one.vector) for one in gains.payloads]
    mountings = tuple(map(MountingDocument, gains.mountings.names, tens))
    vague = "; too little, known to {:.0f} % only: keep the maker's gain"
    return GainsResult(
        robot=gains.robot.name,
        robot_title=gains.robot.title or UNSET,
        processing=ProcessingDocument.made(gains.robot, processing, ()),
        load=LoadDocument(
            known=known_values(gains.loads),
            mass_sigma=max(load.mass_sigma for load in gains.loads),
            identified=tens[0],
            mountings=mountings if len(mountings) > 1 else UNSET,
        ),
        drive_gains=GainsTable(
            values=gains.values,
            sigma=gains.values * sigma,
            relative_sigma=sigma,
            relative_sigma_formula=own.sigma,
            relative_sigma_robust=own.sigma_robust,
            relative_covariance=gains.larger_relative_covariance,
            without_constraints=gains.free_values,
            identified=gains.identified,
            rests_on=tuple(
                text if good else text + vague.format(100 * one)
                for text, good, one in zip(gains.rests_on, gains.identified, sigma, strict=True)
            ),
        ),
        fingerprints=gains.recordings,
        robust=RobustDocument.made(own.robust, gains.without_robust),
        relative_residual=ResidualDocument.of(own.fit),
        disagreement=gains.disagreement,
        verdict=VerdictDocument.made(gains.verdict),
    ).made_by(gains)
