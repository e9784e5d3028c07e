"""Tries all wrong assumptions on the recordings that fit worst."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ....model import Processing, Recording, Robot
from ...payload.source import Source
from . import channels, description, positions
from .misfit import Model
from .sample import Sample
from .suspect import Suspect

CONVINCING = 0.8
"""Misfit left over misfit before above which an assumption is not worth a word."""
HELPFUL = 0.93
"""The same where other checks speak against the recordings already."""
NOTABLE = 0.005
"""The misfit must fall by this as well."""
AS_GOOD = 1.05
"""Assumptions whose misfit is within this factor of the best cannot be told apart."""
SETTLED = 0.3
"""Misfit left over misfit before below which no further family of assumptions is tried."""
_TOLD = 3


class Cause(NamedTuple):
    """A likely cause in a recording, with the joints' mean residual as it is and as it would be."""

    source: str
    words: str
    before: float
    after: float


def likely_causes(robot: Robot, source: Source, contradicted: bool = True) -> tuple[Cause, ...]:
    """What would explain the recordings better, one cause each for those without and with payload, the
    most convincing first.

    Args:
        robot: as described.
        source: the recordings; of each kind the one that fits worst is looked at.
        contradicted: whether something is known to be wrong; if not, only a clear gain counts.
    """
    enough = HELPFUL if contradicted else CONVINCING
    kinds = [
        _cause(robot, recordings, source.processing, enough) for recordings in (source.unloaded, source.loaded)
    ]
    found = sorted((cause for cause in kinds if cause is not None), key=lambda cause: cause.after / cause.before)
    words = [cause.words for cause in found]
    return tuple(cause for k, cause in enumerate(found) if cause.words not in words[:k])


def _cause(robot: Robot, recordings: Iterable[Recording], processing: Processing, enough: float) -> Cause | None:
    samples = [Sample.of(recording, processing) for recording in recordings]
    models = [Model.of(robot, sample) for sample in samples if len(sample.t) > 1]
    if not models:
        return None
    worst = max(models, key=lambda model: model.misfit())
    sample, before = worst.sample, worst.misfit()
    suspects: list[Suspect] = []
    for family in _families(robot, sample, worst):
        suspects += [s for s in family if s.misfit < min(enough * before, before - NOTABLE)]
        if suspects and min(s.misfit for s in suspects) < SETTLED * before:
            break
    if not suspects:
        return None
    best = min(suspect.misfit for suspect in suspects)
    alike = [suspect for suspect in suspects if suspect.misfit <= AS_GOOD * best][:_TOLD]
    return Cause(sample.source, ", or ".join(s.words for s in alike), before, alike[0].misfit)


def _families(robot: Robot, sample: Sample, model: Model) -> Iterator[Iterator[Suspect]]:
    """The likelier ones first: where two explain the same, the first is told."""
    yield channels.delays(model)
    yield channels.signs(model)
    yield channels.swaps(model)
    yield description.gravity(robot, sample)
    yield positions.exchanged(robot, sample)
    yield positions.backwards(robot, sample)
    yield channels.drifting_clocks(robot, model)
    yield description.other_robots(robot, sample)
    yield description.coupled(robot, sample)
    yield channels.offsets(model)
    yield channels.gains(model)
    yield channels.units(model)
    yield positions.zeros(robot, sample)
    yield positions.frozen(robot, sample)
    yield description.lengths(robot, sample)
