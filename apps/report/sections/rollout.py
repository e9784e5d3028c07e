"""Shows how far an identified robot's motion strays from recordings: in open loop, and replaying the path."""

from collections.abc import Sequence
from math import pi
from pathlib import PurePath

from ...rollout import CONSTANT, GROWTH_TIME, IDENTIFIED, Rollout
from ..blocks import Block, Notes, Report, Section, Table, Text
from ..figures.motion import rollout_figure

_GROWS = 10.0
"""An error of the start that grows by more within half a second hides what the parameters do."""
_WORDS = (
    "Open loop: from many moments of the recording the identified robot is moved by the measured torques alone. "
    "Replay: a controller takes it along the measured path; its torque is compared with the measured one, slow "
    "rows left out. Friction is smoothed near rest, so that joints creep where the real ones stick."
)


def rollout_report(rollouts: Sequence[Rollout], robot: str) -> Report:
    """Errors by horizon and the replay of the first recording, a line of each other; then all of them."""
    first, *others = rollouts
    lines, more = [*_notes(first), *map(rollout_line, others)], "every recording, starts at rest"
    blocks: list[Block] = [_tables(first)[0], Notes(lines, optional=True)]
    sections = [rollout_section(rollouts)]
    title = f"Predicted motion of the {robot}"
    return Report(title, blocks, sections, more, "Of recordings that were not fitted")


def rollout_line(rollout: Rollout) -> str:
    """Error after the longest horizon and the replay, in one line."""
    seconds, (unit, size) = rollout.horizons[-1], _unit(rollout)
    resting = bool(rollout.resting.all())
    errors = (rollout.spread(by, seconds, resting) for by in (IDENTIFIED, CONSTANT))
    ours, constant = (f"{spread.median / size:.2g}" if spread else "-" for spread in errors)
    return (
        f"Motion of {PurePath(rollout.source).name}: {ours} {unit} off after {seconds:g} s (constant speed "
        f"{constant}); replayed, torques {100.0 * rollout.replay.relative:.2g} % off."
    )


def _notes(rollout: Rollout) -> list[str]:
    """The replay, and whether open loop can judge anything."""
    replay, (unit, size) = rollout.replay, _unit(rollout)
    joints = " ".join(f"{100.0 * share:.1f}" for share in replay.joints)
    lines = [
        f"Replay: torque {100.0 * replay.relative:.2g} % from the measured one (joints {joints} %), path kept to "
        f"{replay.strayed / size:.2g} {unit}."
    ]
    if rollout.growth == rollout.growth:
        hides = ": open loop judges nothing here, whatever the parameters; go by the replay"
        grows = f"An error of the start grows {rollout.growth:.2g}-fold within {GROWTH_TIME:g} s"
        lines.append(f"{grows}{hides * (rollout.growth > _GROWS)}.")
    if rollout.diverged:
        lines.append(f"{rollout.diverged} of {len(rollout.resting)} starts of the identified robot ran away.")
    return lines


def rollout_section(rollouts: Sequence[Rollout]) -> Section:
    """Tables and figures of every recording."""
    blocks: list[Block] = [Text(_WORDS)]
    for k, rollout in enumerate(rollouts, start=1):
        figure = rollout_figure(rollout, f"rollout_{k}", _unit(rollout))
        blocks += [*_tables(rollout), figure, Notes(_notes(rollout))]
    return Section("rollout", "Predicted motion", blocks)


def _tables(rollout: Rollout) -> list[Table]:
    """Errors by horizon, of starts in motion and at rest."""
    (unit, size), resting = _unit(rollout), int(rollout.resting.sum())
    names = [IDENTIFIED, *(by for by in rollout.errors if by != IDENTIFIED)]
    headings = ("after", *(heading for by in names for heading in (by, f"{by}, 90 %")))
    tables = []
    for at_rest, count in ((False, len(rollout.resting) - resting), (True, resting)):
        rows = []
        for seconds in rollout.horizons if count else ():
            spreads = [rollout.spread(by, seconds, at_rest) for by in names]
            cells = (f"{error / size:.3g}" for spread in spreads if spread is not None for error in spread)
            rows.append((f"{seconds:g} s", *cells))
        starts = f"{count} starts {'at rest' if at_rest else 'in motion'}"
        title = f"{PurePath(rollout.source).name}: error [{unit}], median and 90 % of {starts}"
        tables += [Table(title, headings, rows)] if count else []
    return tables


def _unit(rollout: Rollout) -> tuple[str, float]:
    return ("deg", pi / 180.0) if rollout.turning else ("rad or m", 1.0)
