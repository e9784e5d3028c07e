"""Drive gains of a problem: free, of possible bodies, with covariances, and whether to use them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
from msgspec import UNSET

from ...common import Brief, InputError, one_thread
from ...model import InertialParameters, Recording, Robot
from ..diagnosis.causes import likely_causes
from ..diagnosis.engine import states_of
from ..diagnosis.evidence import KNOWN_WELL
from ..diagnosis.verdict import diagnose, judge
from ..equations.equations import PAYLOAD
from ..fit.covariance import NORMAL95, RobustCovariance, jackknife
from ..fit.estimate import Estimate, Fit, fingerprints
from ..fit.settings import DEFAULTS, Settings
from ..gains.problem import GainProblem, KnownLoad, free_gains, gain_problem, known_values, possible_gains, rests_on
from ..payload.by_joints import ByJoints
from ..payload.long_motion import LongMotion, Source
from ..payload.methods import payload_estimate
from ..results import robot as documents
from ..results.payload import TorquePrediction, named
from ..signals.recordings import check_given
from .identification import DRAWN, payload_predictions


@dataclass(frozen=True, repr=False)
class GainsWorking(Brief):
    """Weighings by the torques that drive gains give, one for each mounting of the known weight."""

    source: Source  # the recordings of currents
    mountings: tuple[int, ...]  # their numbers
    loads: tuple[KnownLoad, ...]
    payloads: tuple[InertialParameters, ...]  # as identified in each mounting, what is known as given
    posed: tuple[LongMotion, ...]
    by_joints: tuple[ByJoints, ...]

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few recordings, current times gain, and those of robot and weight: all were used."""
        return tuple(chain.from_iterable(map(payload_predictions, self.posed, self.payloads)))[:DRAWN]


@one_thread()
def identify_gains(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> documents.GainsResult:
    """Identify drive gains from motor currents without and with a weight that is known, and judge them.

    Args:
        loaded: recordings with the weight, whose ``torque`` holds motor currents [A].
        unloaded: the same without it.
        load: the weight, or that of each mounting.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass. All one
            by default.

    Raises:
        InputError: if the recordings do not determine the gains.

    >>> result = identify_gains(robot, currents_loaded, currents, known_mass(7.0))
    >>> result.drive_gains.values[:4].round()
    array([10., 10., 10., 10.])
    """
    check_given(robot, loaded, unloaded)
    return answer_gains(gain_problem(robot, unloaded, loaded, load, mounting, settings))


def answer_gains(problem: GainProblem) -> documents.GainsResult:
    """Identify the drive gains on the current side, with bodies that can exist, and judge them."""
    loads, names = problem.loads, problem.mountings
    try:
        free = free_gains(problem.equations, loads)
        sharpest = int(np.argmin(np.diag(free.covariance)))
        best = possible_gains(problem, problem.equations, free, sharpest)
    except InputError as error:  # what the recordings look like is told with it
        likely = likely_causes(problem.description, states_of(problem.source), free_gains=True)
        raise InputError("; ".join([str(error), *(finding.text for finding in likely)])) from None
    robust: RobustCovariance | None = None
    reason = problem.without_blocks
    if problem.deletions:
        try:
            groups = [
                [-np.log(possible_gains(problem, part, best, sharpest).k) for part in group]
                for group in problem.deletions
            ]
            robust = jackknife(groups, -np.log(best.k), max(each.loaded.block_length for each in problem.posed))
        except InputError as error:
            reason = str(error)
    # The weight as the torques show it that the gains give; the gains' own errors are those of these recordings.
    posed = problem.posed_by(1.0 / best.k)
    identified = [payload_estimate(each, 4) for each in posed]
    diagnoses = [
        diagnose(each, own, None, problem.description) for each, own in zip(posed, identified, strict=True)
    ]
    # An error of the weighed mass scales all gains alike, and so may a burst of other torques.
    bursts = [
        (own.mass, diagnosis.effects.get("bursts")) for own, diagnosis in zip(identified, diagnoses, strict=True)
    ]
    reach = max((abs(float(found.change[9]) / mass) / NORMAL95 for mass, found in bursts if found), default=0.0)
    shared = max(load.mass_sigma / load.mass for load in loads) ** 2 + reach**2
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    logarithms = Estimate(  # ln K of possible bodies, its fit that of the currents [A]
        names=tuple(f"K{j}" for j in range(1, problem.robot.n + 1)),
        values=-np.log(best.k),
        covariance=free.covariance + shared,
        degrees_of_freedom=free.degrees_of_freedom,
        fit=Fit(errors, problem.equations.torque_norms, problem.equations.rows),
        weights=problem.weights,
        robust=robust and replace(robust, covariance=robust.covariance + shared),
    )
    # The covariance has the larger standard deviations, and the robust correlations where there are some; all times
    # the disagreement of the joints' payload ratios.
    disagreement = max(diagnosis.disagreement for diagnosis in diagnoses)
    sigma, covariance = disagreement * logarithms.larger_sigma, disagreement**2 * logarithms.covariance
    if logarithms.robust is not None:
        wider = sigma / logarithms.robust.sigma
        covariance = logarithms.robust.covariance * np.outer(wider, wider)
    gains, well = np.exp(logarithms.values), (sigma <= KNOWN_WELL).tolist()
    vague = "; too little, known to {:.0f} % only: keep the maker's gain"
    based = zip(rests_on(problem.robot), well, sigma, strict=True)
    table = documents.GainsTable(
        gains,
        covariance,
        sigma=gains * sigma,
        relative_sigma=sigma,
        relative_sigma_formula=logarithms.sigma,
        relative_sigma_robust=logarithms.sigma_robust,
        without_constraints=1.0 / free.k,
        identified=tuple(well),
        rests_on=tuple(text if good else text + vague.format(100 * one) for text, good, one in based),
    )
    weights = tuple(
        (name, load.mass, own.mass, float(own.estimate.larger_sigma[9]))
        for name, load, own in zip(names, loads, identified, strict=True)
    )
    # What the mountings have in common stands in the evidence of the first.
    evidence = [
        replace(
            found,
            condition=each.unloaded.condition_numbers()[1] if each.unloaded else None,
            parameters=each.robot_estimate,
            estimates=(own,),
            gained=None if k else sigma,
            weights=() if k else weights,
            alternatives=() if k else found.alternatives,
        )
        for k, (each, own, found) in enumerate(zip(posed, identified, diagnoses, strict=True))
    ]
    robot, source = problem.description, problem.source
    payloads = tuple(
        map(InertialParameters, best.x[len(problem.posed[0].base.columns) :].reshape(-1, len(PAYLOAD)))
    )
    tens = [named(body.vector) for body in payloads]
    return documents.GainsResult(
        robot=robot.name,
        robot_title=robot.title or UNSET,
        processing=documents.ProcessingDocument.made(robot, source.processing, ()),
        load=documents.LoadDocument(
            known=known_values(loads),
            mass_sigma=max(load.mass_sigma for load in loads),
            identified=tens[0],
            mountings=tuple(map(documents.MountingDocument, names, tens)) if len(names) > 1 else UNSET,
        ),
        drive_gains=table,
        fingerprints=fingerprints(source.unloaded, source.loaded),
        robust=documents.RobustDocument.made(logarithms.robust, reason),
        relative_residual=documents.ResidualDocument.of(logarithms.fit),
        disagreement=disagreement,
        verdict=judge(*evidence),
    ).made_by(
        GainsWorking(source, names, loads, payloads, posed, tuple(diagnosis.by_joints for diagnosis in diagnoses))
    )
