"""Searches the table of wrong assumptions: one at a time where recordings fit badly, readings one upon another.

A reading is how a log's joint columns are taken; the best one is a suggestion. Some readings no torque can tell
apart: the zero of an upright first axis, and on an arm that is its own mirror image the senses of all axes in the
mirror plane together.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...model import Processing, Recording, Robot
from ..payload.problem import Source
from .finding import Finding, Severity
from .misfit import Model, compiled
from .poses import quick_residual
from .reading import Reading
from .sample import Sample
from .suspects import FAMILIES, Suspect

CONVINCING = 0.8
"""Misfit left over misfit before above which an assumption is not worth a word."""
HELPFUL = 0.93
"""Misfit left over misfit before where other checks speak against the recordings already."""
NOTABLE = 0.005
"""The misfit must fall by this as well."""
AS_GOOD = 1.05
"""Assumptions whose misfit is within this factor of the best count as equal."""
SETTLED = 0.3
"""Misfit left over misfit before below which no further family of assumptions is tried."""
SERIOUS = 0.5
"""Misfit left over misfit before: where undoing an assumption takes off half, the assumption was wrong."""
_TOLD = 3
_FEWEST = 100  # moving samples of a recording
_ROUNDS = 6
_WORTH = 0.03
"""A change must lower the residual by this fraction to be kept."""
_FRONT = 3
"""Readings from which each round goes on: the best alone may be a dead end."""
_ALIKE = 0.03
_ROUNDING = 1e-9
"""Residuals that differ by less do equally well."""
_DIGITS = 9
_CLEAR = 0.95
"""The suggestion must lie below this fraction of the residual as recorded."""


class Cause(NamedTuple):
    """A likely cause in a recording, with the joints' mean residual as it is and as it would be."""

    source: str
    words: str
    before: float
    after: float

    def finding(self, subject: str) -> Finding:
        """What it says of a recording that is called ``subject``."""
        text = (
            f"{subject} looks as if {self.words}: corrected for it, the joints' mean residual falls from "
            f"{100 * self.before:.1f} to {100 * self.after:.1f} %"
        )
        severity: Severity = "error" if self.after < SERIOUS * self.before else "warning"
        return Finding(severity, self.source, text, cause=True, explains=1.0 - (self.after / self.before) ** 2)


def likely_causes(
    robot: Robot, source: Source, contradicted: bool = True, apart: bool = False
) -> tuple[Cause, ...]:
    """What would explain the recordings better, one cause each for those without and with payload.

    The most convincing comes first.

    Args:
        source: the recordings; of each kind the one that fits worst is looked at.
        contradicted: whether something is known to be wrong; if not, only a clear gain counts.
        apart: whether the recordings hold currents of unknown gains, so that joints share nothing.
    """
    kinds = [
        likely_cause(
            robot, [Sample.of(recording, source.processing) for recording in recordings], contradicted, apart
        )
        for recordings in (source.unloaded, source.loaded)
    ]
    causes = sorted((cause for cause in kinds if cause is not None), key=lambda cause: cause.after / cause.before)
    words = [cause.words for cause in causes]
    return tuple(cause for k, cause in enumerate(causes) if cause.words not in words[:k])


def likely_cause(robot: Robot, samples: Iterable[Sample], contradicted: bool, apart: bool = False) -> Cause | None:
    """What would explain the worst of some samples better; arguments as for ``likely_causes``."""
    models = [Model.of(robot, sample, apart=apart) for sample in samples if len(sample.t) > 1]
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
        suspects += [
            suspect for suspect in family(model) if suspect.misfit < min(enough * before, before - NOTABLE)
        ]
        if any(suspect.misfit < SETTLED * before for suspect in suspects):
            break
    return suspects


def neighbours(robot: Robot, reading: Reading, torques: bool = True) -> Iterator[Reading]:
    """Readings one or two changes away, in a fixed order.

    Single changes of order (two columns swapped), sense, torque sign and zero; then two joints' senses, one
    joint's sense and zero, and the zeros of two joints in a row.

    Args:
        robot: zeros of its revolute joints are changed by quarter turns.
        reading: where to start.
        torques: whether the torque's sign alone is in question.
    """
    joints, steps = range(robot.n), (1, 2, 3)
    turning = [j for j in joints if robot.joints[j].revolute]
    yield from (reading.swapped(i, j) for i, j in combinations(joints, 2))
    for j in joints:
        yield reading.turned(j)
        if torques:
            yield reading.pushed(j)
    yield from (reading.moved(j, step) for j, step in product(turning, steps))
    yield from (reading.turned(i, j) for i, j in combinations(joints, 2))
    yield from (reading.turned(j).moved(j, step) for j, step in product(turning, steps))
    for (i, j), a, b in product(pairwise(turning), steps, steps):
        yield reading.moved(i, a).moved(j, b)


@dataclass(frozen=True)
class Ranked:
    """A reading and what it leaves unexplained.

    Attributes:
        residual: relative torque residual, or rms distance of the tool [m].
    """

    reading: Reading
    residual: float


@dataclass(frozen=True)
class KinematicsCheck:
    """Readings of a log, best first.

    Attributes:
        as_recorded: every column as it stands.
        ranked: what was tried, best first; of readings that do equally well the simplest first.
        unit: of the residuals.
    """

    as_recorded: Ranked
    ranked: tuple[Ranked, ...]
    unit: str

    @property
    def suggested(self) -> Ranked | None:
        """The best reading, if it does clearly better than the log as recorded."""
        best = self.ranked[0]
        return best if best.residual < _CLEAR * self.as_recorded.residual else None

    @property
    def alike(self) -> tuple[Ranked, ...]:
        """Other readings that do as well as the best."""
        limit = _alike(self.ranked)
        return tuple(reading for reading in self.ranked[1:] if reading.residual <= limit)


def rank_readings(
    robot: Robot,
    recordings: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
) -> KinematicsCheck:
    """Rank readings by the residual of the robot's identification from recordings without payload.

    Raises:
        InputError: if there is too little motion to tell anything.
    """
    samples = [Sample.of(recording, processing or robot.processing) for recording in recordings]
    for sample in samples:
        if len(sample.t) < _FEWEST:
            raise InputError(f"{sample.source}: {len(sample.t)} moving samples are too few to check the kinematics")
    together, evaluate = Sample.joined(samples), compiled(robot)

    def residual(reading: Reading) -> float:
        try:
            return Model.of(robot, reading.of(together), evaluate).misfit()
        except InputError:  # outside the spring's table: this cannot be the reading
            return float("inf")

    return _ranked(robot, residual, "relative torque residual", True, progress)


def rank_readings_by_pose(
    robot: Robot, q: Array, positions: Array, rotations: Array | None = None, progress: Progress = silent
) -> KinematicsCheck:
    """Rank readings by how well forward kinematics reproduces the logged tool.

    Args:
        q: joint positions [rad or m], N x n.
        positions: of the tool in any fixed frame [m], N x 3.
        rotations: axes of the tool, N x 3 x 3; without them the sense and zero of the last joint stay open.
    """
    places = np.unique(np.linspace(0, len(q) - 1, 60).astype(int))

    def residual(reading: Reading) -> float:
        axes = None if rotations is None else rotations[places]
        return quick_residual(robot, reading.positions(q[places]), positions[places], axes)

    unit = (
        "m, rms distance of the tool"
        if rotations is None
        else "m, rms distance of the tool and of its axes at 0.2 m"
    )
    return _ranked(robot, residual, unit, False, progress)


def _ranked(
    robot: Robot, residual: Callable[[Reading], float], unit: str, torques: bool, progress: Progress
) -> KinematicsCheck:
    """Search from the log as recorded to ever better neighbours, a few at a time, while that is worth it."""
    start = Ranked(Reading.as_recorded(robot.n), residual(Reading.as_recorded(robot.n)))
    tried = {start.reading: start}
    front, spread = [start], set[Reading]()
    for k in range(_ROUNDS):
        progress(f"trying readings of the joints, round {k + 1} of at most {_ROUNDS}", k / _ROUNDS)
        before = _best_first(tried.values())[0]
        for centre in front:
            spread.add(centre.reading)
            for reading in neighbours(robot, centre.reading, torques):
                if reading not in tried:
                    tried[reading] = Ranked(reading, residual(reading))
        best = _best_first(tried.values())[0]
        if not best.residual < (1.0 - _WORTH) * before.residual:
            break
        fresh = [entry for entry in tried.values() if entry.reading not in spread]
        front = sorted(fresh, key=_order)[:_FRONT]
    return KinematicsCheck(start, tuple(_best_first(tried.values())), unit)


def _alike(candidates: Iterable[Ranked]) -> float:
    """Residual up to which readings do as well as the best."""
    return min(reading.residual for reading in candidates) * (1.0 + _ALIKE) + _ROUNDING


def _best_first(candidates: Iterable[Ranked]) -> list[Ranked]:
    """Sort causes: those as good as the best by the number of their changes, then the others by their residual."""
    candidates = list(candidates)
    limit = _alike(candidates)

    def rank(entry: Ranked) -> tuple[bool, int, tuple[float, int, Reading]]:
        worse = entry.residual > limit
        return worse, 0 if worse else entry.reading.changes, _order(entry)

    return sorted(candidates, key=rank)


def _order(entry: Ranked) -> tuple[float, int, Reading]:
    """Residual, then simplicity: rounding decides nothing between readings that no torque tells apart."""
    return round(entry.residual, _DIGITS), entry.reading.changes, entry.reading
