"""What most likely went wrong, where the recordings contradict the model."""

import numpy as np

from ..causes.search import Cause, likely_causes
from .reasons import Evidence, Reason

SUSPICIOUS = 0.1
"""Relative residual of some joint above which wrong assumptions are tried, even if all else looks well."""
SERIOUS = 0.5
"""Residual left over residual before: where undoing an assumption takes off half, the assumption was wrong."""


def cause_reasons(evidence: Evidence, found: list[Reason]) -> list[Reason]:
    """Causes are suggested from evidence, never corrected.

    Args:
        evidence: what was computed.
        found: the reasons so far.
    """
    source = evidence.problem.source
    contradicted = any(reason.against == "everything" for reason in found)
    if source is None or not (contradicted or _suspicious(evidence)):
        return []
    return [_reason(cause) for cause in likely_causes(evidence.problem.robot, source, contradicted)]


def _suspicious(evidence: Evidence) -> bool:
    fits = [e.estimate.fit for e in evidence.estimates if e.method != 3]
    fits += [evidence.robot_fit] if evidence.robot_fit is not None else []
    return any(np.nanmax(fit.relative_per_joint) > SUSPICIOUS for fit in fits)


def _reason(cause: Cause) -> Reason:
    text = (
        f"{cause.source} looks as if {cause.words}: with that undone the joints' mean residual falls from "
        f"{100 * cause.before:.1f} to {100 * cause.after:.1f} %"
    )
    return Reason("everything" if cause.after < SERIOUS * cause.before else "inertia", text, cause=True)
