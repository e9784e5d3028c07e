"""What spoils a weighing at rest: poses reached from one side, a payload that swings, brakes that hold."""

from collections.abc import Iterator

import numpy as np

from ..payload.static import StaticMotion
from ..signals.rests import oscillation
from .evidence import AtRest, Evidence, Swing
from .finding import Finding, error

SWINGS, WHITE, MATTERS = 3.0, 30.0, 0.02
"""Oscillation of the loaded torque at rest over that without payload, its power over that of white noise, and its
size over the payload's largest torque, above which the payload swings."""
HOLDS, CARRIES = 0.1, 0.2
"""Spread of a joint's torque over the poses, over that on the way there, below which a brake holds it; and spread
on the way there, over the largest joint's, below which a joint says nothing."""


def rested(problem: StaticMotion) -> AtRest:
    """Look at the rests of all recordings."""
    bare, payload = len(problem.source.unloaded), problem.loaded
    unloaded, loaded = problem.rests[:bare], problem.rests[bare:]
    (frequencies, size, white), (_, earlier, _) = oscillation(loaded), oscillation(unloaded)
    largest = (payload.torque_norms / np.sqrt(np.maximum(payload.rows, 1))).max()
    seen = (white > WHITE) & (size > SWINGS * earlier) & (size > MATTERS * largest)
    k, j = np.unravel_index(int(np.argmax(np.where(seen, white, 0.0))), seen.shape)
    clearest = Swing(int(j) + 1, float(frequencies[k]), float(size[k, j]), float(earlier[k, j]))
    moving, still = (
        np.max([getattr(one, kind).std(axis=0) for one in loaded], axis=0) for kind in ("before", "torque")
    )
    braked = np.flatnonzero((moving > CARRIES * moving.max()) & (still < HOLDS * moving)) + 1
    swings = seen.any() and not len(braked)  # a brake that closes is a step
    return AtRest(problem.one_sided, clearest if swings else None, tuple(braked.tolist()))


def one_sided(evidence: Evidence) -> Iterator[Finding]:
    """Poses that are reached from one side only (`weigh --static`). Any: spoils all."""
    if found := evidence.at_rest and evidence.at_rest.one_sided:
        yield error(
            f"pose {', '.join(map(str, found))} is reached from one side only, where nothing tells friction from "
            "weight: reach each pose from both sides ('dynident near --static')"
        )


def swinging(evidence: Evidence) -> Iterator[Finding]:
    """A payload that swings while the arm rests (`weigh --static`).

    Torque at rest that oscillates over {SWINGS:g} times as far as without payload, with over {WHITE:g} times the
    power of white noise and over {MATTERS:.0%} of the payload's torque: spoils all.
    """
    if swing := evidence.at_rest and evidence.at_rest.swing:
        yield error(
            f"the payload swings: at rest the torque of joint {swing.joint} oscillates at {swing.frequency:.1f} Hz "
            f"by {swing.loaded:.2g} N·m or N (rms; without payload {swing.unloaded:.2g}): wait longer, or fix it"
        )


def braked(evidence: Evidence) -> Iterator[Finding]:
    """Brakes that hold the arm at rest, not its drives (`weigh --static`).

    Torque at rest that varies by under {HOLDS:.0%} of what it does on the way there: spoils all.
    """
    if found := evidence.at_rest and evidence.at_rest.braked:
        yield error(
            f"the torque of joint {', '.join(map(str, found))} at rest is the same in all poses, on the way there "
            "it is not: a brake holds the arm, and no torque shows its weight; record with the brakes open"
        )
