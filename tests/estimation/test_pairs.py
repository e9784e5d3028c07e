"""Two recordings of one motion: gaps, paths that differ, and the method that is recommended."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.errors import InputError
from dynident.estimation import Settings, answer_payload, payload_problem
from dynident.estimation.equations.observer import PATH
from dynident.estimation.fit.settings import FRICTION_CHANGE
from dynident.estimation.payload.long_motion import LongMotion
from dynident.estimation.payload.methods import ONE_PATH, payload_estimate, recommended_method
from dynident.estimation.payload.problem import cut_alike
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.alignment import aligned
from dynident.estimation.signals.rows import cut, pieces
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot
from dynident.trajectories import NearMotion, Simulator, Task, random_via_points, run_experiment
from dynident.trajectories.motions.family import Plan
from dynident.trajectories.simulation.closed_loop import CONTROLLERS
from dynident.trajectories.simulation.disturbances import no_disturbances

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


ROBOT = invented.robot("ur10e")
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])
LOAD = InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))


def near() -> NearMotion:
    """20 s near a pose, periods of 5 s."""
    draw = np.random.default_rng(0)
    a, b = np.zeros((2, 1, 6, 4))
    for joint in (2, 3, 5, 6):
        own = 0.6 * draw.standard_normal(4)
        a[0, joint - 1] = own - own.mean()
    return NearMotion(POSE[None], a, b, 5.0, 4, 0.0)


@cache
def sagging(mrad: float, wide: bool = False) -> tuple[Recording, Recording]:
    """Recordings without noise under a controller without integral action."""
    plan: Plan = random_via_points(ROBOT, 6, 1) if wide else near()
    controller = replace(CONTROLLERS["proportional"], rate=100.0).sagging(ROBOT, LOAD, [plan], 1e-3 * mrad)
    tasks = [Task("bare", plan), Task("loaded", plan, LOAD)]
    bare, loaded = (run.recording for run in run_experiment(ROBOT, tasks, no_disturbances(6), 0, controller).runs)
    return bare, loaded


@pytest.mark.long
@pytest.mark.parametrize("mrad", [2.0, 4.0])
def test_what_a_sag_changes_is_taken_off_and_a_quarter_of_it_is_unsure(mrad: float) -> None:
    bare, loaded = sagging(mrad)
    problem = difference_weighing(ROBOT, [loaded], [bare])
    estimate = payload_estimate(problem, 3).estimate
    posed = problem.posed()
    (levels, path) = posed.fixed
    assert path.names == (PATH,)
    as_measured = replace(posed, fixed=(levels, path._replace(values=np.array([-1.0]))))
    plain = as_measured.values(estimate.weights)
    change = plain - estimate.values
    assert abs(estimate["M_L"] - LOAD.mass) < 0.6 * abs(plain[9] - LOAD.mass)
    assert abs(estimate["M_L"] - LOAD.mass) < 4e-4 * mrad * LOAD.mass
    lasting = posed.lasting(estimate.weights)
    exact = replace(posed, fixed=(levels, path._replace(lasting=np.zeros((1, 1)))))
    quarter = lasting - exact.lasting(estimate.weights)
    assert quarter == pytest.approx(np.outer(change, change) / 16.0, rel=1e-6, abs=1e-12)


def test_a_pair_is_refused_by_the_rms_of_the_joint_that_differs_most() -> None:
    """Not by a single sample, on both sides of the limit; 10 mrad by default."""
    bare, loaded = sagging(9.0)
    pair = aligned(bare, loaded, 100.0, 0.05)
    each = np.sqrt(np.mean((pair.loaded.q - pair.unloaded.q) ** 2, axis=0))
    assert pair.rms_mismatch == pytest.approx(each.max())
    assert pair.max_mismatch > 1.2 * pair.rms_mismatch
    assert aligned(bare, loaded, 100.0, 1.001 * pair.rms_mismatch).lag == pair.lag
    with pytest.raises(InputError, match=rf"q{np.argmax(each) + 1} differs by .* \(rms, limit"):
        aligned(bare, loaded, 100.0, 0.999 * pair.rms_mismatch)
    assert ROBOT.processing.max_mismatch == 0.01
    farther = sagging(14.0)
    with pytest.raises(InputError, match=r"rms, limit 0\.01"):
        difference_weighing(ROBOT, [farther[1]], [farther[0]])


PROCESSING = Processing(cutoff=10.0, rate=100.0, decimate=2, max_mismatch=0.01)
Problem = Callable[..., LongMotion]


@pytest.fixture(scope="module")
def paired(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> Problem:
    """A pair of an arm: how far the loaded path is off [rad, rms], and its friction, relative, 1 sigma."""

    def problem(
        name: str = "rx90", apart: float = 0.0, friction: float = 0.0, change: float = FRICTION_CHANGE
    ) -> LongMotion:
        simulator = simulated(name)
        robot, motion = simulator.robot, wander(6, 4, points=20)
        turn = 2.0 * np.pi * 0.3
        sag = np.sqrt(2.0) * apart * np.sin(turn * motion.t)[:, None] * np.eye(6)[1]
        speed = np.sqrt(2.0) * apart * turn * np.cos(turn * motion.t)[:, None] * np.eye(6)[1]
        lower = Motion(motion.t, motion.q + sag, motion.qd + speed, motion.qdd - turn**2 * sag)
        draw = np.random.default_rng(5)
        another = {
            key: value * (1.0 + friction * float(draw.standard_normal()) * key.startswith(("FS", "FV")))
            for key, value in robot.parameters.items()
        }
        bare = simulator.record(motion, None, [0.3] * 6, 1)
        loaded = simulator.record(lower, payload, [0.3] * 6, 2, parameters=another)
        return payload_problem(robot, [loaded], [bare], settings=Settings(PROCESSING, friction_change=change))

    return problem


@pytest.mark.parametrize("name", ["rx90", "irb120", "ur10e"])
def test_friction_that_is_another_one_under_load_hardly_moves_method_3(
    name: str, paired: Problem, payload: InertialParameters
) -> None:
    size = payload.mass * np.array([0.45, 0.45, 0.45, 1.0])
    errors = [
        np.linalg.norm((payload_estimate(problem, 3).ten - payload.vector)[6:] / size)
        for problem in (paired(name, friction=0.2), paired(name, friction=0.2, change=0.0))
    ]
    assert errors[0] < 0.5 * errors[1], errors


def test_one_path_is_answered_by_method_3(paired: Problem) -> None:
    answer = answer_payload(paired())
    assert answer.recommended.method == answer.free.method == 3
    assert "one path, within 0.0" in answer.recommendation[1]


def test_a_path_that_sags_is_answered_by_method_4(paired: Problem) -> None:
    problem = paired(apart=2.0 * ONE_PATH)
    assert problem.difference is not None
    method, reason = recommended_method(problem, (1, 2, 3, 4))
    assert (method, reason[:11]) == (4, "no pair ran")
    assert recommended_method(paired(apart=0.5 * ONE_PATH), (1, 2, 3, 4))[0] == 3
    assert recommended_method(problem, (1, 2, 3))[0] == 3
