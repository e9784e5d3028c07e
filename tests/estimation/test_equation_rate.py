"""Fast logs: no noise folds into the equations, whichever way their rate is asked for."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import Settings, payload_estimate, payload_problem
from dynident.estimation.signals.filtering import measurement
from dynident.model import InertialParameters, Motion, Processing, Recording, load_robot
from dynident.trajectories import Simulator

AT_100 = Processing(rate=100.0, cutoff=20.0, decimate=4, slow_fraction=0.05)
NOISE = 4.0  # N·m, white at 1 kHz: more than what the filter takes off the motion


@pytest.fixture(scope="module")
def fast(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> list[Recording]:
    """Without and with payload, at 1 kHz, white noise on the torque."""
    motion, pair = wander(6, 2, points=9, rate=1000.0), []
    for k, load in enumerate((None, payload)):
        exact = simulated("ur10e").record(motion, load, [1.0] * 6, k)
        noise = np.random.default_rng(k).normal(0.0, NOISE, exact.torque.shape)
        pair.append(Recording(exact.t, exact.q, exact.torque + noise, source=f"log {k}"))
    return pair


def sigma(pair: list[Recording], processing: Processing) -> tuple[float, float]:
    """Sigma of the mass by method 1, and the mass [kg]."""
    problem = payload_problem(
        load_robot("ur10e"), [pair[1]], [pair[0]], settings=Settings(processing, robust=False)
    )
    estimate = payload_estimate(problem, 1).estimate
    return float(estimate.sigma[-1]), estimate["M_L"]


def test_sigma_of_the_mass_halves_on_fast_logs(fast: list[Recording], payload: InertialParameters) -> None:
    """White noise of a 1 kHz log has a tenth of the density in the band that torque picked at 100 Hz has."""
    picked = [replace(log, t=log.t[::10], q=log.q[::10], torque=log.torque[::10]) for log in fast]
    folded, _ = sigma(picked, AT_100)
    filtered, mass = sigma(fast, AT_100)
    assert filtered < 0.5 * folded
    assert filtered == pytest.approx(folded / np.sqrt(10.0), rel=0.15)
    assert abs(mass - payload.mass) < 4.0 * filtered


def test_a_rate_of_equations_is_the_factor_that_gives_it(fast: list[Recording]) -> None:
    by_rate = replace(AT_100, rate=None, decimate=1, equation_rate=25.0)
    assert sigma(fast, by_rate) == pytest.approx(sigma(fast, AT_100), rel=1e-9)
    assert [by_rate.thinning(rate) for rate in (1000.0, 125.0, 30.0, 10.0)] == [40, 5, 1, 1]


@pytest.mark.parametrize(
    ("recorded", "grid", "factor"),
    [(1000.0, 1000.0, 40), (500.0, 500.0, 20), (190.0, 200.0, 8), (125.0, 100.0, 4), (100.0, 100.0, 4)],
)
def test_a_fast_log_is_resampled_to_a_multiple(recorded: float, grid: float, factor: int) -> None:
    t = np.arange(int(6.0 * recorded)) / recorded
    q = np.sin(2.0 * np.pi * 0.5 * t)[:, None]
    rate = measurement(Recording(t, q, q), AT_100).motion.rate
    assert rate == pytest.approx(grid)
    assert AT_100.thinning(rate) == factor


def test_both_ways_at_once_are_an_error() -> None:
    with pytest.raises(ValueError, match="say the same"):
        Processing(decimate=2, equation_rate=10.0)


def test_a_robots_file_gives_either(tmp_path: Path) -> None:
    text = 'name = "one"\n[[joints]]\n[processing]\n'
    path = tmp_path / "one.toml"
    path.write_text(text + "equations_hz = 20\n")
    assert load_robot(path).processing.equation_rate == 20.0
    path.write_text(text + "equations_hz = 20\ndecimate = 3\n")
    with pytest.raises(InputError, match="say the same"):
        load_robot(path)
