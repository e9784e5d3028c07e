"""Both solvers answer the same problem object; the sparse constraints are those of the dense check."""

import os
import signal
from typing import cast

import numpy as np
import pytest
import scipy.sparse
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.tests.trajectories.design_problems import GOALS, SHAPES, problem
from dynident.trajectories import (
    BlendedPoints,
    BlendShape,
    DesignProblem,
    FourierShape,
    Goal,
    Solver,
    Step,
    build_design,
    score_motion,
    solve_design,
)
from dynident.trajectories.constraints import Constraints
from dynident.trajectories.lagrangian import Multipliers
from dynident.trajectories.margins import Margins

ROBOT = load_robot("rx90")
WIDTH = 0.5
QUICK = build_design(ROBOT, FourierShape(2, 4.0, samples=20), Goal("cond-scaled", payload_only=True))


def sparse(found: Constraints, task: DesignProblem, x: Array) -> Array:
    entries = found.jacobian(x, task.state(x, WIDTH), WIDTH)
    shape, starts, rows = found.pattern
    return np.asarray(scipy.sparse.csc_matrix((entries, rows, starts), shape=shape).todense())


@pytest.mark.parametrize("shape", SHAPES)
def test_sparse_jacobian_is_that_of_finite_differences(shape: str) -> None:
    """With every kind of limit, at another x than the pattern was found at."""
    task = problem("cond", shape, duration=None if shape in ("fixed", "fourier") else 12.0)
    draw = np.random.default_rng(1)
    found = Constraints(task, task.family.random(draw), WIDTH)
    x = task.family.random(draw) + 0.02 * draw.standard_normal(task.family.size)
    J, step = sparse(found, task, x), 1e-6
    for _ in range(3):
        direction = draw.standard_normal(len(x))
        ahead, behind = (found.values(task.state(x + s * direction, WIDTH)) for s in (step, -step))
        difference = (ahead - behind) / (2.0 * step)
        assert np.abs(J @ direction - difference).max() < 1e-6 * np.abs(difference).max()
    if "fourier" not in shape:
        assert len(found.pattern.rows) < 0.15 * J.size, "few entries of x act at a time"


def test_values_and_bounds_are_the_limits_own() -> None:
    """Violations as ``Margins`` finds them, rows without bounds left out."""
    task = problem("cond", "blend", duration=12.0)
    x = task.family.random(np.random.default_rng(2)) * 1.2
    state = task.state(x, WIDTH)
    found = Constraints(task, x, WIDTH)
    margins = Margins(task.limits, state, 0.03)
    margins.drawn[0][5, 2] = 0.2
    g, (low, high) = found.values(state), found.bounds(margins)
    assert max((g - high).max(), (low - g).max()) == pytest.approx(margins.violation(state))
    rows = sum(limit.values(state).size for limit in task.limits)
    assert len(g) == rows


def test_it_keeps_every_limit_and_is_deterministic(capfd: pytest.CaptureFixture[str]) -> None:
    """And finds about what the other solver finds, or better."""
    steps: list[Step] = []
    one, two = (solve_design(QUICK, seed=1, starts=1, solver="ipopt", progress=steps.append) for _ in range(2))
    other = solve_design(QUICK, seed=1, starts=1, solver="augmented")
    assert one.feasible
    assert (one.solver, other.solver) == ("ipopt", "augmented")
    assert one.score.value < other.score.value + 0.1
    assert score_motion(QUICK, one.motion(997.0)).feasible
    assert np.array_equal(one.motion(50.0).q, two.motion(50.0).q)
    assert steps[-1].best == pytest.approx(one.score.value)
    assert steps[-1].evaluations == two.evaluations
    assert tuple(capfd.readouterr()) == ("", ""), "IPOPT is silent"


def test_ipopt_on_sparse_limits() -> None:
    """A longest duration binds all times, every other limit the states of two or three points."""
    task = build_design(ROBOT, BlendShape(4, samples=6), GOALS["payload"], duration=4.0)
    design = solve_design(task, seed=0, starts=1, solver="ipopt")
    assert isinstance(design.plan, BlendedPoints)
    assert design.feasible
    assert design.plan.duration <= 4.0
    assert score_motion(task, design.motion(997.0)).feasible


def test_interrupted_between_looks() -> None:
    steps: list[Step] = []

    def stop(step: Step) -> None:
        steps.append(step)
        if len(steps) == 3:
            raise KeyboardInterrupt

    design = solve_design(QUICK, progress=stop, solver="ipopt")
    assert design.interrupted
    assert design.feasible
    assert len(steps) == 3
    assert steps[-1].best == pytest.approx(design.score.value)


def test_ctrl_c_within_ipopt(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    calls, true, before = [0], DesignProblem.evaluate, signal.getsignal(signal.SIGINT)

    def evaluate(
        self: DesignProblem, x: Array, order: float, width: float, limits: Multipliers | None = None
    ) -> tuple[float, Array]:
        calls[0] += 1
        if calls[0] == 40:
            os.kill(os.getpid(), signal.SIGINT)
        return true(self, x, order, width, limits)

    monkeypatch.setattr(DesignProblem, "evaluate", evaluate)
    design = solve_design(QUICK, solver="ipopt")
    assert design.interrupted
    assert design.feasible
    assert calls[0] <= 41
    assert tuple(capfd.readouterr()) == ("", "")
    assert signal.getsignal(signal.SIGINT) is before


def test_what_goes_wrong_within_ipopt_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not taken for a step that is too long."""

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("broken criterion")

    monkeypatch.setattr(DesignProblem, "evaluate", broken)
    with pytest.raises(ZeroDivisionError, match="broken criterion"):
        solve_design(QUICK, solver="ipopt")


def test_a_solver_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="'simplex' is not one of auto, augmented, ipopt"):
        solve_design(QUICK, solver=cast(Solver, "simplex"))
