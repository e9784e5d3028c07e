"""The search for a motion and the floor under it, with what is said about them on the way."""

from __future__ import annotations

from collections.abc import Callable

from ... import trajectories
from ...common.errors import InputError
from .progress import note, status


def best_motion(
    problem: trajectories.DesignProblem,
    seed: int,
    starts: int | None,
    words: Callable[[float | None], str] = lambda best: "",
) -> trajectories.Design:
    """The best motion that keeps every limit.

    Args:
        seed: of the random starts.
        starts: number of random starts; None for the criterion's own.
        words: what is said of the best criterion so far; None before there is one.

    Raises:
        InputError: if there is none; says which limit is missed and by how much.
    """
    with status("building") as progress:

        def show(text: str, best: float | None, evaluations: int) -> None:
            progress(f"{text}, {evaluations} evaluations{words(best)}")

        design = trajectories.solve_design(problem, seed=seed, starts=starts, progress=show)
    if design.missed:
        raise InputError(
            f"the whole run, or its rehearsal, does not keep every limit ({design.missed[0]}): choose other poses, "
            "or another --seed"
        )
    if not design.feasible:
        stopped = "interrupted: " if design.interrupted else ""
        missed = "; ".join(design.score.violations)
        raise InputError(f"{stopped}no motion was found that keeps every limit, the nearest has: {missed}")
    if design.interrupted:
        note("interrupted: this is the best motion so far; it keeps every limit")
    return design


def floor_of(
    problem: trajectories.DesignProblem, score: trajectories.Score, seed: int
) -> trajectories.Floor | None:
    """The floor under a motion's criterion; None if it was interrupted, which costs no motion."""
    try:
        with status("estimating the floor"):
            return trajectories.floor_under(problem, score.value, seed=seed)
    except KeyboardInterrupt:
        note("interrupted: the floor is not known")
        return None
