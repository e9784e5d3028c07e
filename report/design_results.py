"""A designed or replayed motion as tables for a terminal and as a JSON document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich import box
from rich.table import Table

from ..trajectories import DesignProblem, Score
from ..trajectories.design import Floor

_MOST_SHOWN = 12
_SHOWN = 8  # of more parameters: the least known


def criterion_text(kind: str, value: float) -> str:
    """A criterion's value in words, as a solver works with it."""
    if not np.isfinite(value):
        return f"{kind}: not every parameter can be told"
    if kind == "d":
        return f"d: uncertainty {np.exp(0.5 * value):.4g} (geometric mean of sigma)"
    if kind == "a":
        return f"a: relative sigma {100.0 * np.exp(value):.4g} % (root mean square)"
    return f"{kind}: condition number {np.exp(value):.4g}"


def score_table(problem: DesignProblem, score: Score, title: str) -> Table:
    """What the motion would teach, and how near each limit comes."""
    learnt = score.learnt
    table = Table("", title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("", overflow="fold")
    length = problem.goal.data_length
    recorded = f"{length:g} s of data, the motion repeated" if length else "recorded once"
    table.add_row("duration", f"{score.duration:.4g}", f"s; {recorded}")
    table.add_row("parameters", str(len(problem.names)), f"criterion {problem.criterion.kind}")
    table.add_row("condition number", _finite(learnt.condition_number), "of W in SI units")
    table.add_row("", _finite(learnt.condition_number_scaled), "columns scaled to norm 1")
    table.add_row("log det", _finite(learnt.log_det), "of the information matrix", end_section=True)
    for limit in score.limits:
        state = f"violated by {limit.violation:.4g}" if limit in _violated(score) else "met"
        table.add_row(limit.name, f"{limit.value:.4g}", f"{limit.worst}, limit {limit.limit:.4g}: {state}")
    return table


def sigma_table(score: Score, reference: Mapping[str, float], labels: Mapping[str, str]) -> Table | None:
    """Predicted standard deviations; of many parameters the least known. None where not all can be told."""
    sigma = score.learnt.sigma
    if not np.isfinite(list(sigma.values())).all():
        return None
    relative = score.relative_sigma(dict(reference))
    shown = sorted(sigma, key=lambda name: -relative.get(name, 0.0)) if len(sigma) > _MOST_SHOWN else list(sigma)
    shown = shown[: _SHOWN if relative else 0] if len(sigma) > _MOST_SHOWN else shown
    if not shown:
        return None
    title = "Predicted sigma" + (
        f", the {len(shown)} least known of {len(sigma)}" if len(shown) < len(sigma) else ""
    )
    table = Table("", title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    for heading in ("sigma", "value", "%"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name in shown:
        value = f"{reference[name]:.4g}" if name in reference else ""
        percent = f"{100.0 * relative[name]:.2g}" if name in relative else ""
        table.add_row(labels.get(name, name), f"{sigma[name]:.3g}", value, percent)
    return table


def floor_note(kind: str, floor: Floor) -> str:
    """How far a motion is from the best that states within the limits allow."""
    if kind == "d":
        times = f"its uncertainty is {np.exp(0.5 * floor.gap):.3g} times the floor's"
    elif kind == "a":
        times = f"its relative sigma is {np.exp(floor.gap):.3g} times the floor's"
    else:
        times = f"its condition number is {np.exp(floor.gap):.3g} times the floor's"
    return (
        f"Floor over {floor.states} weighted states within the limits, continuity ignored: "
        f"{criterion_text(kind, floor.value)}; {times}."
    )


def replay_note(kind: str, replay: Score) -> str:
    """What a controller's own profiles between the via points would make of the motion."""
    limits = f"but {'; '.join(replay.violations)}" if replay.violations else "every limit met"
    return (
        f"Replayed by trapezoidal moves as --val3 asks for: {criterion_text(kind, replay.value)} in "
        f"{replay.duration:.4g} s, {limits}. Score the controller's log by 'dynident score'."
    )


def _violated(score: Score) -> list[Any]:
    return [limit for limit in score.limits if str(limit) in score.violations]


def _finite(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "rank-deficient"
