"""Blocks of time, the delete-a-block jackknife, robust deviations: exactly, and as far as intervals cover."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from dynident.benchmarks.coverage import Stated, cases, coverage
from dynident.benchmarks.shared import lasting
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Identification, LongMotion, Settings, identify, payload_estimate, payload_problem
from dynident.estimation.equations.equations import Equations, merged
from dynident.estimation.equations.observer import Observation, Observer, reduced, used
from dynident.estimation.fit import covariance
from dynident.estimation.fit.covariance import Rule, autocorrelation_time, block_edges, jackknife, student95
from dynident.estimation.fit.linear_problem import LinearProblem, weighted
from dynident.estimation.fit.own_equations import payload_observer
from dynident.estimation.payload.long_motion import PairedMeasurement, long_motion
from dynident.estimation.payload.methods import METHODS
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.estimation.possible.whole_robot import robot_prior, solve_constrained_prior
from dynident.estimation.signals.filtering import measurement
from dynident.model import InertialParameters, Motion, Processing, Recording, base_parameters, load_robot
from dynident.model.motion import Measurement
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

SETTINGS = Processing(decimate=4, slow_fraction=0.01)
Wander = Callable[..., Motion]


def noisy(data: Measurement, seed: int, size: float = 1.0) -> Measurement:
    noise = np.random.default_rng(seed).standard_normal(data.torque.shape)
    return Measurement(data.motion, data.torque + size * noise)


def later(data: Measurement, shift: float) -> Measurement:
    motion = data.motion
    return Measurement(Motion(motion.t + shift, motion.q, motion.qd, motion.qdd), data.torque)


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


@pytest.fixture(scope="module")
def pair(simulator: Simulator, payload: InertialParameters, wander: Wander) -> PairedMeasurement:
    motion = wander(6, 0, points=30)
    return PairedMeasurement(
        noisy(simulator.measure(motion), 0), noisy(simulator.measure(motion, payload), 1), lag=0.0
    )


def rows_out(whole: Equations, part: Equations) -> Array:
    """Numbers of rows of each joint that are left out."""
    return np.asarray(np.subtract(whole.rows, part.rows), dtype=float)


def same_equations(first: Equations, second: Equations) -> None:
    """The factors' Gram matrices are equal to rounding, and so are the numbers of rows."""
    assert (first.columns, first.rows) == (second.columns, second.rows)
    assert first.effective_rows == pytest.approx(second.effective_rows)
    for a, b in zip(first.factors, second.factors, strict=True):
        gram = b.T @ b
        size = np.sqrt(np.outer(np.diag(gram), np.diag(gram)))
        assert (np.abs(a.T @ a - gram) <= 1e-12 * size).all()


def block_length(groups: list[list[Observation]]) -> float:
    """Block length [s] of recordings of one load each."""
    return max(covariance.remembered(group, merged(map(reduced, group)))[0] for group in groups)


def cut(recording: Observation, edges: Array) -> Equations:
    return covariance.in_blocks(reduced(recording), [recording], 1.0, [edges])


def remembering(size: int, memory: float, seed: int) -> Array:
    return lasting(np.random.default_rng(seed).standard_normal(size), memory)


def times(size: int) -> Array:
    return np.linspace(0.0, 0.01 * (size - 1), size)


@pytest.mark.parametrize(("memory", "expected"), [(0.05, 0.5), (4.0, 4.0), (20.0, 20.0)])
def test_autocorrelation_time(memory: float, expected: float) -> None:
    """1/2 + sum of exp(-k / T), which is T but for 1 / (12 T)."""
    t = times(50_000)
    series = [(t, remembering(50_000, memory, seed)) for seed in range(2)]
    assert autocorrelation_time(series, 0.01) == pytest.approx(0.01 * expected, rel=0.1)


@pytest.fixture(scope="module")
def observation(simulator: Simulator, pair: PairedMeasurement) -> Observation:
    return Observer(simulator.robot, base_parameters(simulator.robot).columns).observe(
        *used(pair.unloaded, SETTINGS)
    )


def test_blocks_are_equal_and_long_enough(observation: Observation) -> None:
    t = np.concatenate(observation.t)
    edges = block_edges(observation, 3.0)
    inner = np.diff(np.concatenate([[t.min()], edges[1:-1], [t.max()]]))
    assert np.ptp(inner) < 1e-9
    assert 3.0 <= inner[0] < 3.0 * (1.0 + 1.0 / (len(inner) - 1))
    assert (edges[0], edges[-1]) == (-np.inf, np.inf)
    assert len(block_edges(observation, 1000.0)) == 2


def test_block_length(observation: Observation) -> None:
    """White noise: the shortest; noise that remembers: five times its memory; many recordings: at most 100."""
    assert block_length([[observation]]) == 1.0
    slow = tuple(Y + 23.5 * remembering(len(Y), 10.0, j) for j, Y in enumerate(observation.Y))
    remembered = Observation.of(observation.columns, observation.W, slow, observation.t, observation.bandwidth)
    errors = remembered.errors(weighted(reduced(remembered)).values)
    memories = [autocorrelation_time([(t, e)], 0.04) for t, e in zip(remembered.t, errors, strict=True)]
    assert max(memories) > 0.2
    assert block_length([[observation], [remembered]]) == pytest.approx(5.0 * max(memories), rel=1e-6)
    duration = np.ptp(np.concatenate(observation.t))
    assert block_length([[observation] * 10]) == pytest.approx(10.0 * duration / 100.0)


def without(recording: Observation, start: float, stop: float) -> Observation:
    """All rows but those of a block."""
    stays = [(t < start) | (t >= stop) for t in recording.t]
    rows = tuple(own[:, keep] for own, keep in zip(recording.rows, stays, strict=True))
    return replace(recording, rows=rows, t=tuple(t[keep] for t, keep in zip(recording.t, stays, strict=True)))


def test_leaving_a_block_out_is_reducing_without_it(observation: Observation) -> None:
    edges = block_edges(observation, 2.0)
    parts = list(cut(observation, edges).without_each())
    assert len(parts) == len(edges) - 1 >= 10
    for k, part in enumerate(parts):
        direct = reduced(without(observation, edges[k], edges[k + 1]))
        same_equations(part, direct)
        part_fit, direct_fit = weighted(part), weighted(direct)
        assert (np.abs(part_fit.values - direct_fit.values) < 1e-6 * part_fit.sigma).all()


def test_jackknife_of_a_mean_is_the_textbook_one() -> None:
    """s^2 / B, exactly; independent groups add, with the degrees of freedom of the smaller."""
    draws = np.random.default_rng(0).standard_normal((12, 3))
    parts = [np.delete(draws, k, axis=0) for k in range(12)]

    def mean(data: Array) -> Array:
        return np.asarray(data.mean(axis=0))

    once = jackknife([map(mean, parts)], mean(draws), 1.0)
    assert np.allclose(once.covariance, np.cov(draws.T) / 12.0, rtol=1e-12, atol=1e-15)
    assert (once.blocks, once.degrees_of_freedom, once.warning) == (12, 11, "")
    assert student95(once.degrees_of_freedom) == pytest.approx(2.20099, abs=1e-5)
    twice = jackknife([map(mean, parts), map(mean, parts[:9])], mean(draws), 1.0)
    assert (twice.blocks, twice.degrees_of_freedom) == (21, 8)
    changes = np.array([mean(part) for part in parts[:9]]) - mean(draws)
    assert np.allclose(twice.covariance, once.covariance + 8.0 / 9.0 * changes.T @ changes)
    assert "9 blocks" in twice.warning


@pytest.fixture(scope="module")
def problem(simulator: Simulator, pair: PairedMeasurement) -> LongMotion:
    return problem_of(simulator, [pair])


def problem_of(simulator: Simulator, pairs: list[PairedMeasurement], paired: bool = True) -> LongMotion:
    robot = simulator.robot
    loaded, bare = [pair.loaded for pair in pairs], [pair.unloaded for pair in pairs]
    settings = Settings(SETTINGS, friction_change=0.0)
    return long_motion(payload_observer(robot), loaded, bare, pairs if paired else [], settings)


def weighing_robot(problem: LongMotion, weights: Array) -> LongMotion:
    """The problem with the joints' weights of the recordings without payload given."""
    fixed = replace(problem)
    assert fixed.unloaded is not None
    vars(fixed)["bare"] = weighted(fixed.unloaded, weights)
    return fixed


def test_blocks_of_one_motion_are_cut_at_the_same_points(simulator: Simulator, pair: PairedMeasurement) -> None:
    """Whatever the unloaded recording's own clock shows."""
    observer = payload_observer(simulator.robot)
    plain = long_motion(observer, [pair.loaded], [pair.unloaded], [pair], Settings(SETTINGS))
    shifted = long_motion(
        observer, [pair.loaded], [later(pair.unloaded, -7.5)], [pair._replace(lag=7.5)], Settings(SETTINGS)
    )
    bare, moved = plain.unloaded, shifted.unloaded
    assert bare is not None
    assert moved is not None
    assert plain.difference is not None
    assert len(plain.loaded.blocks) == len(bare.blocks) == len(plain.difference.blocks) >= 20
    for a, b, heavy in zip(bare.without_each(), moved.without_each(), plain.loaded.without_each(), strict=True):
        same_equations(a, b)
        assert np.abs(rows_out(bare, a) - rows_out(plain.loaded, heavy)).max() <= 1
    fewer = replace(bare, blocks=bare.blocks[1:])
    with pytest.raises(ValueError, match="as many"):
        replace(plain, unloaded=fewer)


@pytest.mark.parametrize("method", METHODS)
def test_payload_without_a_block_by_hand(method: int, problem: LongMotion) -> None:
    """The covariance is that of solving again with one block's rows gone from all the equations."""
    assert problem.unloaded is not None
    assert problem.difference is not None
    estimate = payload_estimate(problem, method).estimate
    robot_weights = weighted(problem.unloaded).weights
    changes = []
    count = len(problem.loaded.blocks)
    for k in range(count):
        loaded, unloaded, difference = (
            whole.without_each()[k] for whole in (problem.loaded, problem.unloaded, problem.difference)
        )
        part = weighing_robot(
            replace(problem, loaded=loaded, unloaded=unloaded, difference=difference), robot_weights
        )
        changes.append(METHODS[method](part).solved(estimate.weights).values - estimate.values)
    expected = (count - 1) / count * np.array(changes).T @ np.array(changes)
    assert estimate.robust is not None
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert (np.abs(estimate.robust.covariance - expected) < 1e-6 * size).all()
    assert (estimate.robust.blocks, estimate.robust.degrees_of_freedom) == (count, count - 1)


@pytest.mark.parametrize("method", [1, 2, 4])
def test_blocks_of_two_motions_are_two_groups(
    method: int, simulator: Simulator, wander: Wander, payload: InertialParameters
) -> None:
    """Each group by its own number of blocks, (B - 1) / B, whichever recording is the longer one."""
    motions = [wander(6, seed, points=points) for seed, points in ((1, 40), (2, 16))]
    for bare, heavy in (motions, motions[::-1]):
        loaded, unloaded = (
            simulator.record(heavy, payload, RX90_NOISE, 1),
            simulator.record(bare, None, RX90_NOISE, 2),
        )
        settings = Settings(SETTINGS, friction_change=0.0)
        motion = payload_problem(simulator.robot, [loaded], [unloaded], settings=settings)
        assert motion.unloaded is not None
        assert motion.difference is None
        estimate, robot = (
            payload_estimate(motion, method, covariance="jackknife").estimate,
            weighted(motion.unloaded),
        )
        own, other = (replace(equations, shared={}) for equations in (motion.unloaded, motion.loaded))
        groups = (
            [replace(motion, unloaded=rest, loaded=other) for rest in own.without_each()],
            [replace(motion, unloaded=own, loaded=rest) for rest in other.without_each()],
        )
        expected = np.zeros((10, 10))
        for group in groups:
            parts = [METHODS[method](weighing_robot(part, robot.weights)) for part in group]
            changes = np.array([part.solved(estimate.weights).values - estimate.values for part in parts])
            expected += (1.0 - 1.0 / len(group)) * changes.T @ changes
        assert estimate.robust is not None
        assert np.diag(estimate.robust.covariance) == pytest.approx(np.diag(expected), rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_rule_for_variances_is_asked_by_name(method: int, problem: LongMotion) -> None:
    """The formula's alone, the jackknife's as by default, or the sandwich by how much the errors remember."""
    usual = payload_estimate(problem, method).estimate
    plain, cut, by_memory = (payload_estimate(problem, method, covariance=rule).estimate for rule in get_args(Rule))
    assert plain.robust is None
    assert usual.robust is not None
    assert cut.robust is not None
    assert np.array_equal(cut.robust.covariance, usual.robust.covariance)
    assert by_memory.robust is not None
    posed, expected = METHODS[method](problem), float(np.median(problem.inflation)) * plain.covariance
    expected = posed.sandwich(usual.weights, problem.inflation) if isinstance(posed, LinearProblem) else expected
    assert by_memory.robust.by_memory
    assert by_memory.robust.covariance == pytest.approx(expected, rel=1e-9)
    without = payload_estimate(replace(problem, inflation=(), few=False), method, covariance="sandwich")
    assert "how long errors remember is not known" in without.without_robust


def test_a_robot_known_before_adds_its_own_jackknife(
    simulator: Simulator, pair: PairedMeasurement, wander: Wander
) -> None:
    """Method 1 is linear in the robot's parameters: blocks left out earlier count as those left out now."""
    bare = noisy(simulator.measure(wander(6, 5, points=20)), 2)
    at_once = problem_of(simulator, [PairedMeasurement(bare, pair.loaded)], paired=False)
    assert at_once.unloaded is not None
    alone = weighted(at_once.unloaded)
    length = at_once.unloaded.block_length
    robust = jackknife(
        [[weighted(part, alone.weights).values for part in at_once.unloaded.without_each()]], alone.values, length
    )
    known = replace(alone, robust=robust)
    later = replace(at_once, unloaded=None, known=known)
    now, then = (payload_estimate(p, 1).estimate.robust for p in (at_once, later))
    assert now is not None
    assert then is not None
    assert np.allclose(then.covariance, now.covariance, rtol=1e-5, atol=1e-7 * np.diag(now.covariance).min())
    assert (then.blocks, then.degrees_of_freedom) == (now.blocks, now.degrees_of_freedom)
    plain = payload_estimate(replace(later, known=replace(known, robust=None)), 1)
    assert plain.estimate.robust is None
    assert "identify the robot again" in plain.without_robust


def test_too_short_for_blocks_says_so_and_still_answers(
    simulator: Simulator, payload: InertialParameters, wander: Wander
) -> None:
    motion = wander(6, 0, points=3)
    pair = PairedMeasurement(noisy(simulator.measure(motion), 0), noisy(simulator.measure(motion, payload), 1))
    problem = problem_of(simulator, [pair])
    assert problem.unloaded is not None
    assert problem.difference is not None
    loaded, unloaded, difference = (
        replace(whole, blocks=(whole.whole,)) for whole in (problem.loaded, problem.unloaded, problem.difference)
    )
    single = replace(problem, loaded=loaded, unloaded=unloaded, difference=difference)
    result = payload_estimate(single, 3)
    assert result.estimate.robust is not None
    assert result.estimate.robust.by_memory
    assert "blocks are too few for a jackknife" in result.estimate.robust.warning
    assert "two blocks" in payload_estimate(replace(single, inflation=(), few=False), 3).without_robust
    assert result.mass == pytest.approx(payload.mass, abs=0.5)
    with pytest.raises(InputError, match="two blocks"):
        single.loaded.without_each()


MEMORY = 20.0  # samples


@pytest.fixture(scope="module")
def exact() -> list[Recording]:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    return [simulator.record(random_via_points(robot, 14, seed=k).motion(250.0)) for k in range(4)]


def with_noise(exact: list[Recording], seed: int) -> list[Recording]:
    """A third as large as the noise behind Table 2."""
    draws = (np.random.default_rng(10 * seed + k).standard_normal(r.torque.shape) for k, r in enumerate(exact))
    noise = (lasting(draw, MEMORY) * np.array(RX90_NOISE) / 3.0 for draw in draws)
    return [replace(r, torque=r.torque + own) for r, own in zip(exact, noise, strict=True)]


@pytest.fixture(scope="module")
def results(exact: list[Recording]) -> list[Identification]:
    """By recordings with noise that remembers."""
    return [identify(load_robot("rx90"), with_noise(exact, seed)) for seed in range(4)]


def test_essential_parameters_have_their_own(exact: list[Recording], results: list[Identification]) -> None:
    """By solving again with the essential parameters alone, each block gone in turn, weights fixed."""
    result = results[0]
    observer, processing = Observer(result.robot, result.base.columns), result.robot.processing
    whole = [observer.observe(*used(measurement(log, processing), processing)) for log in with_noise(exact, 0)]
    equations = merged(reduced(recording) for recording in whole)
    parts = covariance.in_blocks(equations, whole, covariance.remembered(whole, equations)[0]).without_each()
    estimate = result.elimination.estimate
    assert len(estimate.names) < 54
    values = [weighted(part.select(estimate.names), estimate.weights).values for part in parts]
    changes = np.array(values) - estimate.values
    assert estimate.sigma_robust is not None
    expected = np.sqrt((len(values) - 1) / len(values) * np.sum(changes**2, axis=0))
    assert estimate.sigma_robust == pytest.approx(expected, rel=1e-9)
    assert len(values) >= 10


def test_distance_and_probability_go_by_robust_deviations(results: list[Identification]) -> None:
    """The estimate alone tells: no caller can forget it."""
    result = results[1]
    robot, base, estimate = result.robot, result.base, result.estimate
    assert estimate.robust is not None
    shifted = replace(estimate, values=estimate.values - 3.0 * estimate.sigma)
    wide = replace(shifted, robust=replace(estimate.robust, covariance=4.0 * estimate.robust.covariance))
    plain, wider = (solve_constrained_base(robot, base, e) for e in (shifted, wide))
    assert plain.chi2_rise > 1.0
    assert wider.chi2_rise == pytest.approx(plain.chi2_rise / 4.0, rel=1e-3)
    assert np.abs((wider.values - plain.values) / estimate.robust.sigma).max() < 1e-2
    assert np.allclose(plain.free.sigma, estimate.robust.sigma)
    assert plain.free.degrees_of_freedom == estimate.robust.degrees_of_freedom
    prior = solve_constrained_prior(robot, base, shifted, robot_prior(robot))
    assert prior.nearest.chi2_rise == pytest.approx(plain.chi2_rise, rel=1e-6)


def disc(noise: str, trajectories: int, runs: int) -> dict[str, list[Stated]]:
    return coverage(cases(trajectories)[noise]._replace(arms=("disc",)), range(runs))


def pooled(rows: Mapping[str, Sequence[Stated]], kind: str) -> list[float]:
    """Coverage of the ten by methods 1 to 4."""
    return [float(np.mean([stated.held for stated in rows[f"disc, method {m}, {kind}"]])) for m in (1, 2, 3, 4)]


@pytest.mark.long
def test_intervals_hold_the_truth_under_white_noise() -> None:
    rows = disc("white", 4, 50)
    for kind in ("formula", "jackknife"):
        assert np.all(np.abs(np.array(pooled(rows, kind)) - 0.95) <= 0.02), pooled(rows, kind)
    assert min(pooled(rows, "recommended")) > 0.95


@pytest.mark.long
def test_intervals_hold_under_noise_that_remembers() -> None:
    """AR(1) torque noise, correlation time 20 samples at 250 Hz."""
    rows = disc("ar", 4, 12)
    assert max(pooled(rows, "formula")) < 0.82
    assert min(pooled(rows, "jackknife")) >= 0.90
    assert max(pooled(rows, "jackknife")) <= 0.98


@pytest.mark.long
def test_intervals_hold_where_decimated_noise_remembers() -> None:
    """The formula is far too short there."""
    rows = disc("late", 2, 10)
    assert max(pooled(rows, "formula")) < 0.75
    assert min(pooled(rows, "recommended")) > 0.88
