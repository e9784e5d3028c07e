"""Shows how far an identified robot's motion strays from recordings: in open loop, and replaying the path."""

from collections.abc import Sequence
from math import pi
from pathlib import PurePath

import numpy as np

from ....estimation.results.parts import Rollout
from ...rollout import CONSTANT, GROWTH_TIME, IDENTIFIED
from ..blocks import Block, Drawing, Notes, Report, Section, Table, Text
from ..figures.canvas import BLUE, GREY, ORANGE, Figure, log_scale, panels, plain

_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREY, ":"), ("black", "-."))
_GROWS = 10.0  # an error of the start that grows by more in half a second hides what the parameters do
_WORDS = (
    "Open loop: from many moments of the recording, the identified robot is driven by the measured torques alone. "
    "Replay: a controller tracks the measured path, and its torque is compared with the measured one (slow rows "
    "left out). Friction is smoothed near rest, so joints creep where real ones stick."
)


def rollout_report(rollouts: Sequence[Rollout], robot: str) -> Report:
    """Errors by horizon and the replay of the first recording, a line of each other; then all of them."""
    table, *more, notes = _parts(rollouts[0], 1)
    lines = [Notes([rollout_line(rollout) for rollout in rollouts[1:]], optional=True)]
    others = [block for k, rollout in enumerate(rollouts[1:], 2) for block in _parts(rollout, k)]
    section = Section("rollout", "Predicted motion", [Text(_WORDS), *more, *others])
    title, details = f"Predicted motion of the {robot}", "every recording, starts at rest"
    return Report(title, [table, notes, *lines], [section], details, "Of recordings that were not fitted")


def rollout_line(rollout: Rollout) -> str:
    """Error after the longest horizon and the replay, in one line."""
    last, (unit, size) = rollout.horizons[-1], _unit(rollout)
    spreads = last.in_motion or last.at_rest or {}
    ours, constant = (f"{spreads[by][0] / size:.2g}" for by in (IDENTIFIED, CONSTANT))
    return (
        f"Motion of {PurePath(rollout.source).name}: {ours} {unit} off after {last.seconds:g} s (constant speed "
        f"{constant}); replayed, torques {100.0 * rollout.replay_relative:.2g} % off."
    )


def rollout_section(rollouts: Sequence[Rollout]) -> Section:
    """Tables and figures of every recording."""
    blocks = [block for k, rollout in enumerate(rollouts, 1) for block in _parts(rollout, k)]
    return Section("rollout", "Predicted motion", [Text(_WORDS), *blocks])


def _parts(rollout: Rollout, number: int) -> list[Block]:
    """Errors by horizon, of starts in motion and at rest; a figure; the replay, and whether open loop can judge."""
    (unit, size), moving, resting = _unit(rollout), rollout.starts_in_motion, rollout.starts_at_rest
    headings = ("after", *(heading for by in rollout.working.by for heading in (by, f"{by}, 90 %")))
    blocks: list[Block] = []
    for how, count in (("in motion", moving), ("at rest", resting)):
        rows = []
        for horizon in rollout.horizons:
            spreads = (horizon.at_rest if how == "at rest" else horizon.in_motion) or {}
            cells = (f"{error / size:.3g}" for spread in spreads.values() for error in spread)
            rows.append((f"{horizon.seconds:g} s", *cells))
        starts = f"{count} starts {how}"
        title = f"{PurePath(rollout.source).name}: error [{unit}], median and 90 % of {starts}"
        blocks += [Table(title, headings, rows)] if count else []
    caption = (
        f"Distance of predicted from measured motion on {rollout.source}, root mean square over the joints: median "
        "of the starts, shaded up to 90 %."
    )
    blocks.append(Drawing(f"rollout_{number}", caption, lambda: _draw(rollout)))
    joints = " ".join(f"{100.0 * ratio:.1f}" for ratio in rollout.replay_joints)
    lines = [
        f"Replay: torque {100.0 * rollout.replay_relative:.2g} % from the measured one (joints {joints} %), path "
        f"kept to {rollout.replay_strayed / size:.2g} {unit}."
    ]
    if rollout.growth == rollout.growth:
        hides = ": open loop says nothing here, whatever the parameters; go by the replay"
        grows = f"An error of the start grows {rollout.growth:.2g}-fold within {GROWTH_TIME:g} s"
        lines.append(f"{grows}{hides * (rollout.growth > _GROWS)}.")
    if rollout.diverged:
        lines.append(f"{rollout.diverged} of {moving + resting} starts of the identified robot diverged.")
    return [*blocks, Notes(lines, optional=True)]


def _draw(rollout: Rollout) -> Figure:
    figure, ((axis,),) = panels((5.8, 3.2))
    (unit, size), errors = _unit(rollout), rollout.working
    for by, (colour, line) in zip(errors.by, _STYLES, strict=False):
        spreads = [errors.spread(by, seconds, not rollout.starts_in_motion) for seconds in errors.times]
        low, high = np.array(spreads).T / size
        axis.plot(errors.times, low, color=colour, linestyle=line, label=by)
        axis.fill_between(errors.times, low, high, color=colour, alpha=0.2, linewidth=0)
    log_scale(axis)
    axis.set(xlabel="time after the start [s]", ylabel=f"error [{unit}]")
    axis.legend(fontsize=9, frameon=False)
    plain(axis)
    return figure


def _unit(rollout: Rollout) -> tuple[str, float]:
    return ("deg", pi / 180.0) if rollout.working.turning else ("rad or m", 1.0)
