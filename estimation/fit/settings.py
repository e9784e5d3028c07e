"""Settings of an estimation: processing of recordings, and what is allowed for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...common import Brief, InputError
from ...common.progress import Progress, silent
from ...model import Processing, Robot
from ...model.friction import Friction
from .estimate import Estimate, Gains
from .linear_problem import StopRule

METHOD_NAMES = {1: "known-robot", 2: "change", 3: "difference", 4: "global"}
"""Short names of the paper's methods, by number."""
FRICTION_CHANGE = 0.10
"""Standard deviation of friction from one recording to another, as a fraction of it: from day to day a real UR10e's
Coulomb friction differs by 1 to 9 %, its viscous friction by 2 to 12 %."""


@dataclass(frozen=True)
class Candidates:
    """Terms of friction that may be added to the robot's own, where the data show them, joint by joint."""

    terms: tuple[Friction, ...] = (Friction("FL"), Friction("FR"))


@dataclass(frozen=True, eq=False, repr=False)
class Settings(Brief):
    """Settings of an estimation.

    Attributes:
        processing: filters and rates; the robot's own by default.
        robust: keep equations in blocks of time as well, so that estimates get robust standard deviations.
        essential: when elimination of parameters ends; by the paper's ratio of 1.02 by default.
        friction_change: with ``robust``, by which fraction the friction of loaded recordings may differ from the
            robot's own (1 sigma); 0 takes it as the same.
        free_friction: method 1: estimate friction anew under load.
        methods: of a long motion, by number or name; all that can be used by default.
        joints: of a short motion, the numbers of those that move; seen in the recordings by default.
        gains: how sure the drive gains are; what the recordings say of it by default, else the usual errors.
        scale_sigma: by which fraction the scale of the loaded torques may differ from that without payload (1
            sigma); methods 1 and 4 alone know of it.
        friction: its terms, instead of the robot's; by default those that the data show.
        prior: base parameters known before ``identify``, ``Estimate.from_values``; variances next to zero fix them.
        progress: called with what is worked on.

    >>> Settings(methods=["global"], robust=False)
    Settings(robust=False, methods=(4,))
    """

    processing: Processing | None = None
    robust: bool = True
    essential: StopRule | None = None
    friction_change: float = FRICTION_CHANGE
    free_friction: bool = False
    methods: Sequence[int | str] | None = None
    joints: tuple[int, ...] | None = None
    gains: Gains | None = None
    scale_sigma: float = 0.0
    friction: tuple[Friction, ...] | Candidates = Candidates()
    prior: Estimate | None = None
    progress: Progress = silent

    def __post_init__(self) -> None:
        known: dict[Any, Any] = METHOD_NAMES | {name: number for number, name in METHOD_NAMES.items()}
        if self.methods is not None and not {*self.methods} <= known.keys():
            raise InputError(f"methods {self.methods!r}: give a list of {', '.join(map(repr, known))}")
        numbers = self.methods and tuple(known[m] if isinstance(m, str) else int(m) for m in self.methods)
        object.__setattr__(self, "methods", numbers)

    def processing_of(self, robot: Robot) -> Processing:
        """Choose the processing asked for, else the robot's own."""
        return self.processing or robot.processing


DEFAULTS = Settings()
