"""The payload problem: what the four methods need, reduced once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed
from ...common.progress import Progress, silent
from ...model import INERTIAL, BaseParameters, Processing, Recording, Robot, base_parameters
from ...model.regressors import payload_columns
from ..equations.problem import ReducedProblem
from ..fit.estimate import Estimate
from ..recordings.plausibility import check_apart, check_recordings
from ..robot.identification import base_problem, check_lengths, check_moving
from ..signals.alignment import AlignedPair, aligned
from ..signals.filtering import measurement
from .blocks import PairedMeasurement, PayloadBlocks, payload_blocks
from .equations import difference_problem, loaded_problem
from .source import Source

FORMULA_ONLY = (
    "the stored robot parameters have the formula's standard deviations only: identify the robot again with this "
    "version"
)


class FixedWeights(NamedTuple):
    """Weights of the joints that a method takes as given instead of estimating them, shape (n,) each.

    ``robot``: of the robot's equations without payload (methods 1 and 2); ``own``: the result's ``weights``.
    """

    robot: Array | None
    own: Array


@dataclass(frozen=True)
class PayloadProblem:
    """Reduced equations for the payload methods.

    Attributes:
        robot: the robot.
        base: its base parameters; their columns make up W.
        loaded: equations [W W_L] of (22) with payload; columns base, then ``PAYLOAD``.
        unloaded: equations W without payload, for methods 1, 2 and 4.
        known: the robot's parameters from an earlier identification, for method 1 without ``unloaded``.
        difference: equations W_L of (29) for method 3, if a pair on one trajectory is there.
        pairs: how the recordings of method 3 were aligned.
        without_difference: why method 3 cannot be used, if it cannot.
        rate: at which the (first) loaded recording was processed [Hz].
        blocks: the same equations cut in blocks of time, for robust standard deviations.
        without_blocks: why there are none although they were asked for.
        source: the recordings themselves, in which the verdict looks for causes.
    """

    robot: Robot
    base: BaseParameters
    loaded: ReducedProblem
    unloaded: ReducedProblem | None = None
    known: Estimate | None = None
    difference: ReducedProblem | None = None
    pairs: tuple[AlignedPair, ...] = ()
    without_difference: str = ""
    rate: float | None = None
    blocks: PayloadBlocks | None = None
    without_blocks: str = ""
    source: Source | None = None

    def __post_init__(self) -> None:
        """Refuse a robot whose parameters are not those of this model."""
        if self.known is not None and self.known.names != self.base.columns:
            other = sorted(set(self.known.names) ^ set(self.base.columns)) or ["their order"]
            raise InputError(
                f"the stored robot parameters are of another model of {self.robot.name}: they differ in "
                f"{', '.join(other[:8])}: identify the robot again with the same options"
            )


def payload_problem(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording] = (),
    known: Estimate | None = None,
    processing: Processing | None = None,
    progress: Progress = silent,
    robust: bool = False,
) -> PayloadProblem:
    """Process recordings with and without payload and reduce them.

    Args:
        robot: the robot.
        loaded: recordings with the payload.
        unloaded: recordings without; for method 3 the k-th is the same trajectory as the k-th of ``loaded``.
        known: the robot's identified parameters, instead of or beside ``unloaded``.
        processing: settings; the robot's own by default.
        progress: told what is being worked on.
        robust: keep the equations in blocks of time as well, so that estimates get robust standard deviations;
            not with a ``known`` robot that has none itself.

    Raises:
        InputError: if a recording cannot be used.
    """
    processing = processing or robot.processing
    progress("base parameters")
    base = base_parameters(robot)
    check_visible(robot, base)
    check_recordings(robot, loaded)
    check_apart(loaded, unloaded)
    check_lengths(loaded, processing)
    check_moving(robot, base, loaded)
    bare = base_problem(robot, base, unloaded, processing, progress=progress) if unloaded else None
    measured = []
    for recording in loaded:
        progress(f"filtering {recording.source}")
        measured.append(measurement(recording, processing))
    both = loaded_problem(robot, base, measured, processing)
    difference: ReducedProblem | None = None
    pairs: tuple[AlignedPair, ...] = ()
    together: list[PairedMeasurement] = []
    reason = "no recordings without payload"
    if unloaded:
        progress("aligning recordings with and without payload")
        try:
            pairs = _paired(loaded, unloaded, processing)
            together = [_measured(pair, processing) for pair in pairs]
            difference = difference_problem(robot, [(p.unloaded, p.loaded) for p in together], processing)
            reason = ""
        except InputError as error:
            reason = str(error)
    blocks: PayloadBlocks | None = None
    unavailable = ""
    if robust and known is not None and known.robust is None:
        unavailable = FORMULA_ONLY
    elif robust:
        progress("cutting into blocks")
        try:
            alone = [measurement(recording, processing) for recording in unloaded]
            blocks = payload_blocks(robot, base, measured, alone, together, processing)
        except InputError as error:
            unavailable = str(error)
    rate = measured[0].motion.rate
    source = Source(tuple(loaded), tuple(unloaded), processing)
    return PayloadProblem(
        robot, base, both, bare, known, difference, pairs, reason, rate, blocks, unavailable, source
    )


def check_visible(robot: Robot, base: BaseParameters) -> None:
    """Refuse an arm on which no motion shows all ten parameters of a payload.

    Raises:
        InputError: names the parameters that stay hidden, alone or in combination.
    """
    effect = base.effect_of(payload_columns(robot))
    hidden = decomposed(effect).null
    if hidden.size:
        named = [kind for kind, size in zip(INERTIAL, np.abs(hidden).max(axis=1), strict=True) if size > 1e-6]
        raise InputError(
            f"no motion of {robot.name} shows {hidden.shape[1]} of a payload's ten directions "
            f"({', '.join(named)}): its joints do not turn the payload in enough ways"
        )


def _paired(
    loaded: Sequence[Recording], unloaded: Sequence[Recording], processing: Processing
) -> tuple[AlignedPair, ...]:
    if len(loaded) != len(unloaded):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload do not form pairs: method 3 "
            "needs each trajectory once without and once with it, in the same order"
        )
    return tuple(
        aligned(a, b, processing.rate, processing.max_mismatch) for a, b in zip(unloaded, loaded, strict=True)
    )


def _measured(pair: AlignedPair, processing: Processing) -> PairedMeasurement:
    return PairedMeasurement(measurement(pair.unloaded, processing), measurement(pair.loaded, processing), pair.lag)
