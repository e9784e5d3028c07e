"""Tries all wrong assumptions on the recordings that fit worst."""

from collections.abc import Iterable
from typing import NamedTuple

from ...model import Robot
from ..payload.problem import Source
from .finding import Finding
from .misfit import Model, Sample
from .suspects import FAMILIES, Suspect

CONVINCING = 0.8
"""Misfit left over misfit before above which an assumption is not worth a word."""
HELPFUL = 0.93
"""Misfit left over misfit before where other checks speak against the recordings already."""
NOTABLE = 0.005
"""The misfit must fall by this as well."""
AS_GOOD = 1.05
"""Assumptions whose misfit is within this factor of the best cannot be told apart."""
SETTLED = 0.3
"""Misfit left over misfit before below which no further family of assumptions is tried."""
SERIOUS = 0.5
"""Misfit left over misfit before: where undoing an assumption takes off half, the assumption was wrong."""
_TOLD = 3


class Cause(NamedTuple):
    """A likely cause in a recording, with the joints' mean residual as it is and as it would be."""

    source: str
    words: str
    before: float
    after: float

    def finding(self, subject: str) -> Finding:
        """What it says of a recording that is called ``subject``."""
        text = (
            f"{subject} looks as if {self.words}: with that undone the joints' mean residual falls from "
            f"{100 * self.before:.1f} to {100 * self.after:.1f} %"
        )
        return Finding("error" if self.after < SERIOUS * self.before else "warning", self.source, text, cause=True)


def likely_causes(robot: Robot, source: Source, contradicted: bool = True) -> tuple[Cause, ...]:
    """What would explain the recordings better, one cause each for those without and with payload.

    The most convincing comes first.

    Args:
        robot: as described.
        source: the recordings; of each kind the one that fits worst is looked at.
        contradicted: whether something is known to be wrong; if not, only a clear gain counts.
    """
    kinds = [
        likely_cause(robot, [Sample.of(recording, source.processing) for recording in recordings], contradicted)
        for recordings in (source.unloaded, source.loaded)
    ]
    causes = sorted((cause for cause in kinds if cause is not None), key=lambda cause: cause.after / cause.before)
    words = [cause.words for cause in causes]
    return tuple(cause for k, cause in enumerate(causes) if cause.words not in words[:k])


def likely_cause(robot: Robot, samples: Iterable[Sample], contradicted: bool) -> Cause | None:
    """What would explain the worst of some samples better; arguments as for ``likely_causes``."""
    models = [Model.of(robot, sample) for sample in samples if len(sample.t) > 1]
    if not models:
        return None
    before, worst = max(((model.misfit(), model) for model in models), key=lambda entry: entry[0])
    suspects = _suspects(worst, before, HELPFUL if contradicted else CONVINCING)
    if not suspects:
        return None
    best = min(suspect.misfit for suspect in suspects)
    alike = [suspect for suspect in suspects if suspect.misfit <= AS_GOOD * best][:_TOLD]
    return Cause(worst.sample.source, ", or ".join(s.words for s in alike), before, alike[0].misfit)


def _suspects(model: Model, before: float, enough: float) -> list[Suspect]:
    """Assumptions without which the misfit falls to less than ``enough`` of what it was before."""
    suspects: list[Suspect] = []
    for family in FAMILIES:
        suspects += [one for one in family(model) if one.misfit < min(enough * before, before - NOTABLE)]
        if any(suspect.misfit < SETTLED * before for suspect in suspects):
            break
    return suspects
