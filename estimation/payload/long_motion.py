"""A payload moved by every joint: the equations that the four methods of section V take, and what they are of."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import BaseParameters, Processing, Recording, Robot
from ..equations.equations import PAYLOAD, Equations, merged
from ..fit.estimate import Estimate, error_model
from ..fit.friction import TermChoice
from ..fit.least_squares import weighted
from ..fit.linear_problem import Known, SoftPrior, left_out
from ..fit.settings import DEFAULTS, Settings
from ..signals.alignment import AlignedPair
from .result import in_payload_frame
from .under_load import friction_changes, with_changes, with_scale

FORMULA_ONLY = (
    "the stored robot parameters have the formula's standard deviations only: identify the robot again, by a "
    "longer recording"
)

FREE_SCALE = (
    "the scale of the loaded torques is free (--scale-sigma), of which a difference of torques knows nothing"
)


class Source(NamedTuple):
    """Recordings with and without payload, their processing, and both side by side.

    Attributes:
        compared: recordings of one trajectory, those that method 3 refuses among them.
        why_no_pair: why method 3 cannot be used, if it cannot.
        rate: at which the (first) loaded recording was processed [Hz].
        choices: terms of friction that were tried on the recordings without payload.
    """

    loaded: tuple[Recording, ...]
    unloaded: tuple[Recording, ...]
    processing: Processing
    compared: tuple[AlignedPair, ...] = ()
    why_no_pair: str = ""
    rate: float | None = None
    choices: tuple[TermChoice, ...] = ()


@dataclass(frozen=True, repr=False)
class LongMotion(Brief):
    """Reduced equations of recordings in which every joint moves.

    With blocks of time, those of a pair of recordings are the same stretches of one motion.

    Attributes:
        base: the robot's base parameters; their columns make up W.
        loaded: equations [W W_L] of (22) with payload in frame n; columns base, then ``PAYLOAD``.
        source: the recordings themselves, in which the verdict looks for causes.
        unloaded: equations W without payload, for methods 1, 2 and 4.
        difference: equations W_L of (29) for method 3, if a pair on one trajectory is there.
        known: the robot's parameters from an earlier identification, for method 1, beside ``unloaded`` too.
        carried: payload under whose load friction is, its ten in frame n; zero where none grows with load.
        inflation: by how much the memory of each joint's errors under load raises variances; none without blocks.
        few: whether blocks as long as that memory asks for would be too few, so that shorter ones were cut.
    """

    robot: Robot
    base: BaseParameters
    loaded: Equations
    source: Source
    unloaded: Equations | None = None
    difference: Equations | None = None
    known: Estimate | None = None
    settings: Settings = DEFAULTS
    carried: Array = field(default_factory=lambda: np.zeros(len(PAYLOAD)))
    inflation: tuple[float, ...] = ()
    few: bool = False

    def __post_init__(self) -> None:
        """Refuse another model's robot, and blocks of one motion that are not as many."""
        if self.known is not None:
            check_known(self.robot, self.base, self.known)
        counts = {len(part.blocks) for part in (self.loaded, self.unloaded, self.difference) if part}
        if self.paired and self.loaded.blocks and len(counts) > 1:
            raise ValueError("paired blocks must be as many without and with payload")

    @property
    def paired(self) -> bool:
        """True if the blocks with and without payload are of one motion."""
        return self.difference is not None and len(self.difference.blocks) > 0

    @property
    def pairs(self) -> tuple[AlignedPair, ...]:
        """Alignment of the recordings of method 3."""
        return self.source.compared if self.difference is not None else ()

    @property
    def why_no_pair(self) -> str:
        """Reason why method 3 cannot be used, if it cannot."""
        return FREE_SCALE if self.settings.scale_sigma > 0.0 else self.source.why_no_pair

    @cached_property
    def bare(self) -> Estimate | None:
        """Estimate the robot's own parameters by the recordings without payload."""
        return None if self.unloaded is None else weighted(self.unloaded)

    @property
    def robot_estimate(self) -> Estimate | None:
        """Robot's own parameters: by recordings without payload, else those of an earlier identification."""
        return self.bare or self.known

    @cached_property
    def robot_known(self) -> Known:
        """Robot's parameters for method 1: from an earlier identification, else without payload."""
        if self.known is not None:
            return known_robot(self.known)
        own, unloaded = self.bare, self.unloaded
        if own is None or unloaded is None:
            raise InputError(
                "method 1 needs the robot's parameters: give a recording without payload or --robot-parameters"
            )
        return Known(
            own.names,
            own.values,
            own.covariance,
            0.0 * own.covariance,  # blocks of time hold the recording they come from
            own.degrees_of_freedom,
            lambda: own.gain_sensitivity,
            lambda: left_out(unloaded, own.names, own.weights).values[:-1, :, 0] if unloaded.blocks else None,
        )

    @property
    def corrected(self) -> bool:
        """True if a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.friction)

    @property
    def robot_prior(self) -> Known:
        """Prior of a robot known earlier, by the covariance that its errors really have."""
        assert self.known is not None
        return prior_of(self.known, self.inflation, self.loaded)

    @cached_property
    def friction(self) -> Mapping[str, SoftPrior]:
        """Frictions of the robot that may be others under load, and how far."""
        try:
            robot = self.robot_estimate
        except InputError:  # by method 3 it is not needed
            robot = None
        if robot is None or not self.inflation:
            return {}
        return friction_changes(robot, self.inflation, self.settings.friction_change)

    @cached_property
    def scaled(self) -> tuple[Equations, dict[str, SoftPrior]]:
        """[W W_L], where the scale of the loaded torques may be another one with a column for it, and its role."""
        if not self.settings.scale_sigma > 0.0:
            return self.loaded, {}
        role = SoftPrior(self.settings.scale_sigma, max(self.inflation, default=1.0))
        return with_scale(self.loaded, self.robot_known, role)

    def under_load(self, friction: bool = True) -> tuple[Equations, dict[str, SoftPrior]]:
        """[W W_L], the payload in its frame, and columns near zero for all that may be another one under load.

        Args:
            friction: with the changes of friction; else of the scale alone.
        """
        scaled, near = self.scaled
        loaded, changes = with_changes(in_payload_frame(self.robot, scaled), self.friction if friction else {})
        return loaded, near | changes

    @cached_property
    def both(self) -> Equations:
        """Join the equations of (30), robot and payload together, columns base, then ``PAYLOAD``."""
        return self.with_unloaded(self.loaded)

    def with_unloaded(self, loaded: Equations) -> Equations:
        """Join equations with payload and those without, whose other columns are zero."""
        if self.unloaded is None:
            raise InputError("method 4 needs a recording without payload")
        unloaded = self.unloaded.select(loaded.columns)
        if not (self.paired and unloaded.blocks and loaded.blocks):
            return merged([unloaded, loaded])
        blocks = unloaded.blocks.joined(loaded.blocks, together=True)
        return replace(merged([unloaded.whole, loaded.whole]), blocks=blocks)

    @property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time with payload, and without, that are left out in turn, -1 for none, group by group.

        Blocks that share no motion are left out one recording at a time: two groups then, without payload first, as
        the equations of method 4 hold them.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        loaded, unloaded = len(self.loaded.blocks), len(self.unloaded.blocks) if self.unloaded else 0
        if not loaded:
            raise InputError("robust standard deviations need recordings in blocks of time")
        check_blocks(loaded, unloaded or loaded)
        if self.paired:
            return (tuple((b, b if unloaded else -1) for b in range(loaded)),)
        groups = tuple((-1, b) for b in range(unloaded)), tuple((b, -1) for b in range(loaded))
        return groups if unloaded else groups[1:]

    @property
    def block_length(self) -> float:
        """Shortest length of a block [s], unless a whole recording is shorter."""
        return self.loaded.blocks.length


def check_blocks(*counts: int) -> None:
    """Refuse so few blocks of time that none can be left out."""
    if min(counts) < 2:
        raise InputError("robust standard deviations need two blocks of time at least: record longer")


def known_robot(robot: Estimate) -> Known:
    """Parameters of an earlier identification, with their between-session covariance."""
    lasting = robot.robust.covariance if robot.robust is not None else robot.covariance
    return Known(
        robot.names,
        robot.values,
        robot.covariance,
        lasting,
        robot.degrees_of_freedom,
        lambda: robot.gain_sensitivity,
    )


def prior_of(known: Estimate, inflation: tuple[float, ...], loaded: Equations) -> Known:
    """Prior of a robot known earlier, by the covariance that its errors really have.

    The jackknife's has no more rank than blocks, and no inverse; its standard deviations scale the formula's.

    Args:
        inflation: by how much the memory of each joint's errors raises variances.
        loaded: the equations that it is a prior of.
    """
    factors = [factor for factor, rows in zip(inflation, loaded.rows, strict=True) if rows]
    model = error_model(replace(known, gain_covariance=None))
    return Known(
        known.names,
        known.values,
        model.covariance,
        model.covariance,
        model.degrees_of_freedom,
        lambda: known.gain_sensitivity,
        inflation=float(np.median(factors)),
    )


def check_known(robot: Robot, base: BaseParameters, known: Estimate) -> None:
    """Refuse a robot whose parameters are not those of this model."""
    if known.names != base.columns:
        missing = sorted(set(known.names) ^ set(base.columns)) or ["their order"]
        raise InputError(
            f"the stored robot parameters are of another model of {robot.name}: they differ in "
            f"{', '.join(missing[:8])}: identify the robot again with the same options"
        )
