"""Whether a pair of recordings really shows one motion at one time."""

from .reasons import Evidence, Reason, against_inertia

MISMATCH = 0.005
"""rad or m, rms: positions of a pair that differ by more are not one motion; real pairs lie below 2e-4."""


def alignment_reasons(evidence: Evidence) -> list[Reason]:
    """Pairs that method 3 takes, although their positions differ."""
    worst = max(evidence.problem.pairs, key=lambda pair: pair.rms_mismatch, default=None)
    if worst is None or worst.rms_mismatch <= MISMATCH:
        return []
    return [
        against_inertia(
            f"{worst.unloaded.source} and {worst.loaded.source} differ by {1e3 * worst.rms_mismatch:.1f} mrad "
            "(rms) after alignment: method 3 takes them for one motion"
        )
    ]
