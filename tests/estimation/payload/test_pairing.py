"""A gap in one recording of a pair: method 3 goes on with what both have."""

from collections.abc import Callable

import pytest
from dynident.estimation import Settings, payload_problem
from dynident.estimation.payload.methods import payload_estimate
from dynident.estimation.payload.problem import cut_alike
from dynident.estimation.signals.rows import cut, pieces
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot
from dynident.trajectories import Simulator

SETTINGS = Processing(100.0, 10.0, 4)
LATER = 0.37  # s, of the loaded recording's clock


@pytest.fixture(scope="module")
def pair(rx90: Robot, payload: InertialParameters, wander: Callable[..., Motion]) -> tuple[Recording, Recording]:
    """Without and with payload, the same motion."""
    motion, arm = wander(6, 3, 22), Simulator(rx90)
    bare, heavy = (arm.record(motion, load, [0.2] * 6, k) for k, load in enumerate((None, payload)))
    return (
        Recording(bare.t, bare.q, bare.torque, source="bare.csv"),
        Recording(heavy.t + LATER, heavy.q, heavy.torque, source="heavy.csv"),
    )


def without_rows(recording: Recording, *gaps: tuple[float, float]) -> list[Recording]:
    """The pieces of a recording that lacks the rows between some shares of its time."""
    t = recording.t - recording.t[0]
    keep = t >= 0.0
    for low, high in gaps:
        keep &= (t < low * t[-1]) | (t > high * t[-1])
    rest = Recording(recording.t[keep], recording.q[keep], recording.torque[keep], source=recording.source)
    return list(cut(rest, pieces(rest.t, SETTINGS.cutoff, rest.source)))


@pytest.mark.parametrize(
    ("bare_gaps", "heavy_gaps", "count"),
    [((), ((0.5, 0.53),), 2), (((0.4, 0.43),), (), 2), (((0.3, 0.33), (0.7, 0.72)), ((0.5, 0.53),), 4)],
    ids=["loaded", "unloaded", "both"],
)
def test_method_3_compares_what_both_have(
    bare_gaps: tuple[tuple[float, float], ...],
    heavy_gaps: tuple[tuple[float, float], ...],
    count: int,
    pair: tuple[Recording, Recording],
    rx90: Robot,
    payload: InertialParameters,
) -> None:
    bare, heavy = without_rows(pair[0], *bare_gaps), without_rows(pair[1], *heavy_gaps)
    assert len(bare) != len(heavy)
    problem = payload_problem(rx90, heavy, bare, settings=Settings(SETTINGS, robust=False))
    assert len(problem.pairs) == count
    assert [each.lag for each in problem.pairs] == pytest.approx([LATER] * count, abs=2e-3)
    assert problem.source is not None
    text = " ".join(note for each in (*problem.source.loaded, *problem.source.unloaded) for note in each.notes)
    assert "so that method 3 compares what both have" in text
    estimate = payload_estimate(problem, 3)
    assert estimate.mass == pytest.approx(payload.mass, abs=4.0 * float(estimate.larger_sigma[9]))
    assert float(estimate.larger_sigma[9]) < 0.05


def test_pairs_and_other_motions_stay_as_they_are(pair: tuple[Recording, Recording]) -> None:
    bare, heavy = pair
    assert cut_alike([heavy], [bare], SETTINGS) == ((heavy,), (bare,), (None,))
    pieces_of = without_rows(heavy, (0.5, 0.53))
    backwards = Recording(bare.t, bare.q[::-1], bare.torque[::-1], source="other.csv")
    assert cut_alike(pieces_of, [backwards], SETTINGS)[:2] == (tuple(pieces_of), (backwards,))
