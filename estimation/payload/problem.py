"""The payload problem: what the four methods need, reduced once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.errors import InputError
from ...model import BaseParameters, Processing, Recording, Robot
from ..equations.equations import PAYLOAD, Equations, merged, stacked
from ..equations.leave_one_out import WithoutEach
from ..fit.estimate import Estimate, error_model
from ..fit.least_squares import weighted
from ..fit.linear_problem import Held, Known, Prior, gain_sensitivity, left_out
from ..signals.alignment import AlignedPair
from .loaded_scale import LoadedScale
from .short_motion import ShortMotion

FORMULA_ONLY = (
    "the stored robot parameters have the formula's standard deviations only: identify the robot again, by a "
    "longer recording"
)


class Source(NamedTuple):
    """Recordings with and without payload, and how they were processed."""

    loaded: tuple[Recording, ...]
    unloaded: tuple[Recording, ...]
    processing: Processing


@dataclass(frozen=True)
class PayloadProblem:
    """Reduced equations for the payload methods.

    With blocks of time, those of a pair of recordings are the same stretches of one motion.

    Attributes:
        base: its base parameters; their columns make up W.
        loaded: equations [W W_L] of (22) with payload; columns base, then ``PAYLOAD``. Of a short motion whose
            torque without payload was subtracted those of ``difference``.
        unloaded: equations W without payload, for methods 1, 2 and 4.
        known: the robot's parameters from an earlier identification, for method 1 without ``unloaded``.
        difference: equations W_L of (29) for method 3, if a pair on one trajectory is there; columns ``PAYLOAD``,
            then friction's.
        pairs: how the recordings of method 3 were aligned.
        without_difference: why method 3 cannot be used, if it cannot.
        rate: at which the (first) loaded recording was processed [Hz].
        stretches: the loaded recordings once more, in a few long pieces.
        no_blocks: why there are no blocks of time although they were asked for.
        source: the recordings themselves, in which the verdict looks for causes.
        robot_weights: weights of the joints without payload, taken as given; estimated by default.
        inflation: by how much the memory of each joint's errors under load raises variances.
        few: whether blocks are shorter than that memory asks for, because the recordings are.
        friction: frictions of the robot that may be others under load, and how far.
        scale: of the loaded torques, where it may be another one.
        short: of a short motion, where friction is free in each recording and not all ten may be visible.
        compared: recordings without and with payload side by side, those that method 3 refuses among them.
    """

    robot: Robot
    base: BaseParameters
    loaded: Equations
    unloaded: Equations | None = None
    known: Estimate | None = None
    difference: Equations | None = None
    pairs: tuple[AlignedPair, ...] = ()
    without_difference: str = ""
    rate: float | None = None
    stretches: tuple[Equations, ...] = ()
    no_blocks: str = ""
    source: Source | None = None
    robot_weights: Sequence[float] | None = None
    inflation: tuple[float, ...] = ()
    few: bool = False
    friction: Mapping[str, Held] = field(default_factory=dict)
    scale: LoadedScale | None = None
    short: ShortMotion | None = None
    compared: tuple[AlignedPair, ...] = ()

    def __post_init__(self) -> None:
        """Refuse another model's robot, and blocks of one motion that are not as many."""
        if self.known is not None:
            check_known(self.robot, self.base, self.known)
        counts = {len(part.leave_one_out) for part in (self.loaded, self.unloaded, self.difference) if part}
        if self.paired and self.loaded.leave_one_out and len(counts) > 1:
            raise ValueError("paired blocks must be as many without and with payload")

    @property
    def paired(self) -> bool:
        """Whether the blocks with and without payload are of one motion."""
        return self.difference is not None and bool(self.difference.leave_one_out)

    @property
    def chosen(self) -> tuple[str, ...]:
        """The parameters that are solved for: all ten, or those that stand for what a short motion shows."""
        return PAYLOAD if self.short is None else self.short.chosen

    @cached_property
    def bare(self) -> Estimate | None:
        """The robot's own parameters by the recordings without payload."""
        if self.unloaded is None:
            return None
        weights = np.array(self.robot_weights) if self.robot_weights is not None else None
        return weighted(self.unloaded, weights)

    @property
    def alone(self) -> Estimate | None:
        """The robot's own parameters: those without payload, else those known from an earlier identification."""
        return self.bare or self.known

    @cached_property
    def both(self) -> Equations:
        """The equations of (30), robot and payload together, columns base, then ``PAYLOAD``."""
        return self.beside(self.loaded)

    def beside(self, loaded: Equations) -> Equations:
        """Equations with payload together with those without, whose other columns are zero."""
        if self.unloaded is None:
            raise InputError("method 4 needs a recording without payload")
        bare = self.unloaded.among(loaded.columns)
        less, more = bare.leave_one_out, loaded.leave_one_out
        if not (self.paired and isinstance(less, WithoutEach) and isinstance(more, WithoutEach)):
            return merged([bare, loaded])
        pairs = zip(less.blocks, more.blocks, strict=True)
        return replace(
            stacked([bare, loaded]), leave_one_out=WithoutEach([stacked(pair, compress=False) for pair in pairs])
        )

    @cached_property
    def robot_known(self) -> Known:
        """The robot's parameters for method 1: from an earlier identification, else without payload."""
        if self.known is not None:
            known = known_robot(self.known)
            # Next to a short motion the robot's errors weigh too much for the formula's, which are too small.
            return known if self.short is None else known._replace(covariance=known.lasting)
        bare, unloaded = self.bare, self.unloaded
        if bare is None or unloaded is None:
            raise InputError(
                "method 1 needs the robot's parameters: give a recording without payload or --robot-parameters"
            )
        nothing = 0.0 * bare.covariance  # blocks of time hold the recording they come from
        return Known(
            bare.names,
            bare.values,
            bare.covariance,
            nothing,
            bare.degrees_of_freedom,
            lambda: gain_sensitivity(unloaded, bare.weights),
            lambda: (
                left_out(unloaded, bare.names, bare.weights).values[:-1, :, 0] if unloaded.leave_one_out else None
            ),
        )

    @property
    def corrected(self) -> bool:
        """Whether a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.friction or (self.short and self.short.held.held))

    @property
    def robot_prior(self) -> Prior:
        """A robot known earlier, by the covariance that its errors really have.

        The jackknife's has no more rank than blocks, and no inverse; its standard deviations scale the formula's.
        """
        assert self.known is not None
        factors = [factor for factor, rows in zip(self.inflation, self.loaded.rows, strict=True) if rows]
        model, known = error_model(replace(self.known, gain_covariance=None)), self.known
        return Prior(
            known.names,
            known.values,
            model.covariance,
            float(np.median(factors)),
            model.degrees_of_freedom,
            lambda: known.gain_sensitivity,
        )

    @cached_property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time with payload, and without, that are left out in turn, -1 for none, group by group.

        Blocks that share no motion are left out one recording at a time: two groups then.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        if not self.loaded.leave_one_out:
            raise InputError(self.no_blocks or "robust standard deviations need recordings in blocks of time")
        loaded = range(len(self.loaded.without_blocks()))
        bare = self.unloaded is not None and self.unloaded.leave_one_out
        unloaded = range(len(self.unloaded.without_blocks())) if self.unloaded and bare else range(0)
        if self.paired:
            return (tuple((b, b if unloaded else -1) for b in loaded),)
        groups = tuple((b, -1) for b in loaded), tuple((-1, b) for b in unloaded)
        return groups if unloaded else groups[:1]

    @cached_property
    def without_blocks(self) -> "tuple[tuple[PayloadProblem, ...], ...]":
        """The problem without each block of time, weights without payload fixed, once for all methods.

        Blocks that share no motion are left out one recording at a time: two groups then.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        if not self.loaded.leave_one_out:
            raise InputError(self.no_blocks or "robust standard deviations need recordings in blocks of time")
        weights = tuple(self.bare.weights) if self.bare is not None else None
        whole = replace(self, robot_weights=weights, stretches=())
        cut = {"loaded": self.loaded, "unloaded": self.unloaded, "difference": self.difference}
        parts = {name: part.without_blocks() for name, part in cut.items() if part and part.leave_one_out}
        together = [tuple(parts)] if self.paired else [(name,) for name in parts]
        return tuple(
            tuple(
                replace(whole, **dict(zip(names, left, strict=True)))
                for left in zip(*(parts[name] for name in names), strict=True)
            )
            for names in together
        )


def known_robot(robot: Estimate) -> Known:
    """Parameters of an earlier identification; what their jackknife says of them no block of this time shows."""
    lasting = robot.robust.covariance if robot.robust is not None else robot.covariance
    return Known(
        robot.names,
        robot.values,
        robot.covariance,
        lasting,
        robot.degrees_of_freedom,
        lambda: robot.gain_sensitivity,
    )


def check_known(robot: Robot, base: BaseParameters, known: Estimate) -> None:
    """Refuse a robot whose parameters are not those of this model."""
    if known.names != base.columns:
        missing = sorted(set(known.names) ^ set(base.columns)) or ["their order"]
        raise InputError(
            f"the stored robot parameters are of another model of {robot.name}: they differ in "
            f"{', '.join(missing[:8])}: identify the robot again with the same options"
        )
