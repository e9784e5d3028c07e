"""For which payloads a motion keeps its torque limits, and what brakes hold when power is cut."""

from collections.abc import Sequence

import numpy as np

from ....trajectories import DesignProblem, PayloadSet, Score
from ....trajectories.design.score import holding_torques
from ..blocks import Table, columns


def payload_notes(problem: DesignProblem, score: Score) -> list[str]:
    """The set of payloads, and the largest share of a torque limit that brakes hold; nothing without a set."""
    payloads = problem.payloads
    if payloads is None:
        return []
    missed = any(limit.name.startswith("torque") and str(limit) in score.violations for limit in score.limits)
    hold = "do NOT hold" if missed else "hold"
    shares = holding_torques(problem, score.samples.q) / problem.bounds.torque
    joint = int(np.argmax(shares))
    bounds = f"up to {payloads.mass:g} kg {region_in_words(payloads)}, down to none"
    return [
        f"Torque limits {hold} for every payload {bounds}.",
        f"Power cut on the way: the brake of joint {joint + 1} then holds up to {100 * shares[joint]:.0f} % of its "
        "torque limit.",
    ]


def region_in_words(payloads: PayloadSet) -> str:
    """Where the bodies lie, in the last link's frame."""
    x, y, z = 1e3 * payloads.centre + 0.0
    half = 1e3 * payloads.half
    place = f"about ({x:.4g}, {y:.4g}, {z:.4g}) mm of the last link's frame"
    if payloads.region == "cube":
        return f"in a box of half edges {_listed(half)} mm {place}"
    if np.ptp(half) < 1e-9 * half.max():
        return f"within {half[0]:.4g} mm {place}"
    return f"in an ellipsoid of half axes {_listed(half)} mm {place}"


def holding_tables(problem: DesignProblem, score: Score) -> list[Table]:
    """Torque that holds the arm still, joint by joint, with its worst payload; nothing without a set."""
    if problem.payloads is None:
        return []
    start, worst = (holding_torques(problem, poses) for poses in (score.samples.q[:1], score.samples.q))
    rows = [
        (f"joint {j}", f"{round(first, 6):.4g}", f"{round(most, 6):.4g}", f"{limit:.4g}")
        for j, (first, most, limit) in enumerate(zip(start, worst, problem.bounds.torque, strict=True), 1)
    ]
    headings = columns(("power cut",), ("at the start", "on the way at most", "limit"))
    return [Table("Torque that brakes have to hold, N·m or N, with the worst payload", headings, rows)]


def _listed(numbers: Sequence[float] | np.ndarray) -> str:
    return ", ".join(f"{x:.4g}" for x in numbers)
