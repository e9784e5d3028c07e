"""Streaming and whole reductions agree; reduced problems can be saved, merged and shared."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation.equations.equations import Equations, merged
from dynident.estimation.equations.observer import Observation, Observer
from dynident.estimation.equations.reduction import reduced, reduced_measurement, reduced_pieces
from dynident.estimation.fit.least_squares import weighted
from dynident.model import Motion, Processing, base_parameters
from dynident.model.motion import Measurement
from dynident.trajectories import Simulator

Simulated = Callable[[str], Simulator]
Wander = Callable[..., Motion]


def noisy(simulator: Simulator, motion: Motion, seed: int = 0) -> Measurement:
    exact = simulator.measure(motion)
    noise = np.random.default_rng(seed).standard_normal(exact.torque.shape)
    return Measurement(motion, exact.torque + noise)


def pieces(data: Measurement, size: int) -> Iterator[Measurement]:
    motion = data.motion
    for start in range(0, len(motion.t), size):
        part = slice(start, start + size)
        yield Measurement(
            Motion(motion.t[part], motion.q[part], motion.qd[part], motion.qdd[part]), data.torque[part]
        )


def same(a: Equations, b: Equations) -> None:
    """Equal rows, and estimates equal to a millionth of sigma."""
    assert (a.columns, a.rows) == (b.columns, b.rows)
    assert a.effective_rows == pytest.approx(b.effective_rows)
    first, second = weighted(a), weighted(b)
    assert (np.abs(first.values - second.values) < 1e-6 * first.sigma).all()
    assert np.allclose(first.sigma, second.sigma, rtol=1e-9)


@pytest.mark.parametrize("decimate", [1, 5])
@pytest.mark.parametrize("size", [100, 777, 100_000])
def test_streaming_equals_the_whole(simulated: Simulated, wander: Wander, decimate: int, size: int) -> None:
    simulator = simulated("rx90")
    observer = Observer(simulator.robot, base_parameters(simulator.robot).columns)
    data = noisy(simulator, wander(6, 0, points=20, rate=200.0))
    slow = 0.05 * np.abs(data.motion.qd).max(axis=0)
    settings = Processing(decimate=decimate, still_speed=0.0, slow_fraction=0.05)
    whole = reduced_measurement(observer, data, settings)
    parts = ((piece, np.abs(piece.motion.qd) >= slow) for piece in pieces(data, size))
    same(whole, reduced_pieces(observer, parts, decimate))
    same(whole, reduced(observer.observe(data, settings)))


def test_saved_and_merged_problems(simulated: Simulated, wander: Wander, tmp_path: Path) -> None:
    simulator = simulated("tx40")
    observer = Observer(simulator.robot, base_parameters(simulator.robot).columns)
    problems = [reduced_measurement(observer, noisy(simulator, wander(6, k), k), Processing()) for k in range(3)]
    for k, problem in enumerate(problems):
        problem.save(tmp_path / f"{k}.npz")
    loaded = [Equations.load(tmp_path / f"{k}.npz") for k in range(3)]
    for before, after in zip(problems, loaded, strict=True):
        assert before.columns == after.columns
        assert all(np.array_equal(a, b) for a, b in zip(before.factors, after.factors, strict=True))
    same(merged(problems), merged([loaded[2], merged([loaded[0], loaded[1]])]))
    with pytest.raises(ValueError, match="different columns"):
        merged([problems[0], problems[1].select(problems[1].columns[1:])])


def test_dependent_columns_and_few_rows_lose_nothing() -> None:
    """The triangle keeps every product of the rows, also where a QR meets a dependent column first."""
    W, Y = np.array([[1.0, 1.0, 2.0, 3.0], [1.0, 1.0, 5.0, 1.0], [1.0, 1.0, 0.0, 7.0]]), np.array([1.0, 2.0, 9.0])
    data = Observation(("a", "b", "c", "d"), (W,), (Y,), (np.arange(3.0),), 1.0)
    (factor,) = reduced(data).factors
    rows = np.column_stack([W, Y])
    assert np.allclose(factor.T @ factor, rows.T @ rows, atol=1e-12)


def test_files_that_are_not_reduced_problems(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("no")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    for name in ("text.npz", "other.npz", "none.npz"):
        with pytest.raises(InputError, match=name):
            Equations.load(tmp_path / name)
