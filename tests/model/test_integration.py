"""Steps one after the other: in compiled code, and by CasADi's own machine, as if each were called alone."""

import casadi as ca
import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model.integration import Stepper, runge_kutta
from dynident.model.kernel.kernel import Kernel

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


@pytest.mark.parametrize("wrong", [(0, 1), (1, 1), (1, 2), (2, 1), (3, 0)])
def test_inputs_that_do_not_fit_are_refused(step: ca.Function, wrong: tuple[int, int]) -> None:
    kernel = Kernel(step)
    if not kernel.compiled:
        pytest.skip("no compiler")
    place, axis = wrong
    arguments = inputs()
    arguments[place] = np.concatenate([arguments[place]] * 2, axis=axis)
    with pytest.raises(ValueError, match="do not fit"):
        kernel.chain(*arguments)


def test_no_step_differs_from_another(step: ca.Function) -> None:
    kernel = Kernel(step)
    if not kernel.compiled:
        pytest.skip("no compiler")
    state, drive, *shared = inputs()
    with pytest.raises(ValueError, match="steps one number"):
        kernel.chain(state, drive[0], *shared)


def test_outputs_too_few_for_the_next_state_are_refused() -> None:
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    kernel = Kernel(ca.Function("short", [x, u], [x[0] + u]))
    if not kernel.compiled:
        pytest.skip("no compiler")
    with pytest.raises(ValueError, match="1 outputs cannot be the next state of 3 numbers"):
        kernel.chain(np.zeros((RUNS, 3)), np.zeros((STEPS, RUNS, 1)))
