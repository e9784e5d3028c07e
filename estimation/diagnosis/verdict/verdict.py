"""Whether a payload's numbers may be typed into a controller, and why.

One check a file, each a function from the evidence to its reasons; thresholds stand where they are used.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from .alignment import alignment_reasons
from .causes import cause_reasons
from .constraints import constraint_reasons
from .friction import friction_reasons
from .inertia import condition_reasons, inertia_reasons, inertia_sigma
from .joints import joint_reasons
from .mass import mass_reasons
from .reasons import Evidence, Reason
from .residual import fit_reasons, residual_reasons
from .steadiness import steadiness_reasons

__all__ = ["CHECKS", "Evidence", "Level", "Reason", "Verdict", "fit_reasons", "inertia_sigma", "verdict"]

Level = Literal["use", "mass_and_com_only", "do_not_use"]
"""Use every number; the mass and the centre of mass; none."""

CHECKS: tuple[Callable[[Evidence], list[Reason]], ...] = (
    residual_reasons,
    friction_reasons,
    mass_reasons,
    joint_reasons,
    steadiness_reasons,
    alignment_reasons,
    condition_reasons,
    inertia_reasons,
)
"""Checks of the recordings, in the order in which their reasons are told; what was known beforehand comes last."""


@dataclass(frozen=True)
class Verdict:
    """A level and the reasons for it, in words."""

    level: Level
    reasons: tuple[str, ...]


def verdict(evidence: Evidence) -> Verdict:
    """Judge the payload estimates of one set of recordings."""
    found = [reason for check in CHECKS for reason in check(evidence)]
    found += [*cause_reasons(evidence, found), *constraint_reasons(evidence)]
    if any(reason.against == "everything" for reason in found):
        told = [reason for reason in found if reason.against == "everything" or reason.cause]
        return Verdict("do_not_use", tuple(reason.text for reason in told))
    level: Level = "mass_and_com_only" if found else "use"
    return Verdict(level, tuple(reason.text for reason in found))
