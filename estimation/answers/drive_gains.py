"""What ``gains`` answers: drive gains with their uncertainty, and whether to use them."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.speech import Speaks
from ...model import InertialParameters, Robot
from ..diagnosis.evidence import KNOWN_WELL
from ..diagnosis.finding import Verdict
from ..fit.drive_gains import Fingerprints
from ..fit.estimate import Estimate, Fit
from ..fit.robust import RobustCovariance
from ..gains.known_load import KnownLoad, Mountings, known_values
from ..payload.by_joints import ByJoints
from ..payload.problem import PayloadProblem, Source
from .prediction import DRAWN, TorquePrediction, payload_prediction


@dataclass(frozen=True, repr=False)
class DriveGains(Speaks):
    """Torque per current of each motor, on the joint side.

    Attributes:
        robot: the robot, its equations those of the joints.
        logarithms: ln K of gains [N·m/A or N/A] for bodies that can exist, its fit that of the currents [A]. Both
            covariances, by the formula and the robust one, hold the sigma of the mass.
        free_values: gains without constraints, shape (n,).
        gravity: per motor, whether gravity acts on it in some pose.
        rests_on: per motor, in words, which torques its gain rests on.
        loads: what was known of the payload in each mounting.
        payloads: its ten in each mounting as identified, known ones as given.
        without_robust: why there is no robust covariance.
        recordings: from which they were identified.
        mountings: which loaded recordings have the weight where.
        disagreement: factor on every standard deviation by which all joints' shares together disagree; 1 where they
            do not.
        posed: each mounting's payload problem with the torques that the gains give, where the verdict looked at it.
        by_joints: the weight in each of them as single joints see it.
        source: the recordings of currents, and how they were processed.
    """

    robot: Robot
    logarithms: Estimate
    free_values: Array
    gravity: tuple[bool, ...]
    rests_on: tuple[str, ...]
    loads: tuple[KnownLoad, ...]
    payloads: tuple[InertialParameters, ...]
    without_robust: str = ""
    recordings: Fingerprints = field(default_factory=dict)
    mountings: Mountings = Mountings()
    disagreement: float = 1.0
    verdict: Verdict = Verdict("use")
    posed: tuple[PayloadProblem, ...] = ()
    by_joints: tuple[ByJoints, ...] = ()
    source: Source | None = None

    def __post_init__(self) -> None:
        """Lock the array."""
        object.__setattr__(self, "free_values", frozen_array(self.free_values, (len(self.gravity),), "free gains"))

    @property
    def headline(self) -> str:
        """The robot, how many of its gains are known, and the verdict in a line."""
        known = f"{sum(self.identified)} of {len(self.identified)} gains identified"
        return f"{self.robot.name}, {known}, {self.verdict.level.replace('_', ' ')}"

    @cached_property
    def values(self) -> Array:
        """Gains K [N·m/A or N/A], shape (n,)."""
        return np.exp(self.logarithms.values)

    @property
    def payload(self) -> InertialParameters:
        """The payload's ten in the first mounting."""
        return self.payloads[0]

    @property
    def known(self) -> dict[str, float]:
        """What was known of the payload, by name: of the first mounting as in ``PAYLOAD``, then XX_L2 .. M_L2."""
        return known_values(self.loads)

    @property
    def fit(self) -> Fit:
        """How well the currents [A] are explained."""
        return self.logarithms.fit

    @property
    def robust(self) -> RobustCovariance | None:
        """Covariance of ln K that holds for autocorrelated noise."""
        return self.logarithms.robust

    @property
    def relative_sigma(self) -> Array:
        """Relative standard deviations by the formula, shape (n,)."""
        return self.logarithms.sigma

    @property
    def relative_sigma_robust(self) -> Array | None:
        """Relative standard deviations that hold for autocorrelated noise, where there is enough data for them."""
        return self.logarithms.sigma_robust

    @property
    def larger_relative_sigma(self) -> Array:
        """The larger of both, times ``disagreement``, shape (n,)."""
        return self.disagreement * self.logarithms.larger_sigma

    @cached_property
    def larger_relative_covariance(self) -> Array:
        """Covariance of ln K with the larger standard deviations and their own correlations, n x n.

        The correlations are the robust ones where the robust deviations are the larger.
        """
        if self.robust is None:
            return self.disagreement**2 * self.logarithms.covariance
        own = self.robust.covariance
        stretch = self.larger_relative_sigma / self.robust.sigma
        return np.asarray(own * np.outer(stretch, stretch))

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few recordings, current times gain, and what robot and weight predict: all were used."""
        predictions = []
        for problem, body in zip(self.posed, self.payloads[: len(self.posed)], strict=True):
            assert problem.source is not None
            settings = problem.source.processing
            predictions += [
                payload_prediction(problem, body, recording, settings, False)
                for recording in problem.source.loaded[:DRAWN]
            ]
        return tuple(predictions[:DRAWN])

    @property
    def identified(self) -> tuple[bool, ...]:
        """Per joint, whether its gain is known to 5 % (1 sigma)."""
        return tuple(bool(sigma <= KNOWN_WELL) for sigma in self.larger_relative_sigma)

    @property
    def identifiability(self) -> tuple[str, ...]:
        """Per joint, in words, what its gain rests on and whether that is enough."""
        return tuple(
            words + ("" if good else f"; too little, known to {100 * sigma:.0f} % only: keep the maker's gain")
            for words, good, sigma in zip(self.rests_on, self.identified, self.larger_relative_sigma, strict=True)
        )
