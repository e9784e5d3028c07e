"""Steps one after the other: in compiled code, and by CasADi's own machine, as if each were called alone."""

import casadi as ca
import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model.integration import Stepper, runge_kutta

STEPS, RUNS = 7, 11


@pytest.fixture
def step() -> ca.Function:
    """A pendulum with its own length, driven, and what it was driven by."""
    x, drive, length, h = ca.SX.sym("x", 2), ca.SX.sym("u", 1), ca.SX.sym("l"), ca.SX.sym("h")
    none = ca.SX(0, 1)
    after = runge_kutta(
        lambda x, _: ca.vertcat(x[1], drive - 9.81 / length * ca.sin(x[0])), x, h, (none, none, none)
    )
    return ca.Function("pendulum", [x, drive, length, h], [ca.vertcat(after, 2.0 * drive)])


def inputs() -> list[Array]:
    draw = np.random.default_rng(0)
    return [
        draw.normal(size=(RUNS, 2)),
        draw.normal(size=(2 * STEPS, RUNS, 1))[::2],
        draw.uniform(0.5, 2.0, size=(RUNS, 1)),
        np.array([0.01]),
    ]


def alone(step: ca.Function) -> Array:
    """Run after run, step after step."""
    state, drive, length, h = inputs()
    out = np.empty((STEPS, 3, RUNS))
    for k in range(RUNS):
        x = state[k]
        for i in range(STEPS):
            out[i, :, k] = np.array(step(x, drive[i, k], length[k], h)).ravel()
            x = out[i, :2, k]
    return out


def test_it_is_what_single_calls_give(step: ca.Function, compiled: bool) -> None:
    arguments = inputs()
    state = arguments[0].copy()
    np.testing.assert_allclose(Stepper(step)(*arguments), alone(step), rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(arguments[0], state, "the caller's state stays")


def test_the_last_step_is_the_next_ones_start(step: ca.Function, compiled: bool) -> None:
    state, drive, *shared = inputs()
    stepper = Stepper(step)
    whole = stepper(state, drive, *shared)
    first = stepper(state, drive[:3], *shared)
    second = stepper(np.ascontiguousarray(first[-1, :2].T), drive[3:], *shared)
    np.testing.assert_array_equal(np.concatenate([first, second]), whole)
