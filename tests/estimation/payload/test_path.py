"""A path that differs: an arm that sags under its load."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.errors import InputError
from dynident.estimation import Settings, payload_estimate, payload_problem
from dynident.estimation.equations.observer import PATH
from dynident.estimation.payload.methods import from_difference
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.alignment import aligned
from dynident.model import InertialParameters, Recording
from dynident.trajectories import NearMotion, Task, random_via_points, run_experiment
from dynident.trajectories.motions.family import Plan
from dynident.trajectories.simulation.closed_loop import CONTROLLERS
from dynident.trajectories.simulation.disturbances import no_disturbances

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


@pytest.mark.long
def test_method_3_takes_it_off_as_well() -> None:
    bare, loaded = sagging(4.0, wide=True)
    problem = payload_problem(ROBOT, [loaded], [bare], settings=Settings(robust=False))
    assert problem.difference is not None
    assert PATH in problem.difference.columns
    mass = payload_estimate(problem, 3).mass
    (path,) = from_difference(problem).fixed
    as_measured = replace(from_difference(problem), fixed=(path._replace(values=np.array([-1.0])),))
    plain = as_measured.solved().values[9]
    assert abs(mass - LOAD.mass) < max(abs(plain - LOAD.mass), 1e-3 * LOAD.mass)


@pytest.mark.long
def test_one_and_the_same_path_leaves_nothing_to_take_off() -> None:
    bare, _ = sagging(2.0)
    problem = difference_weighing(ROBOT, [replace(bare, torque=1.1 * bare.torque, source="loaded")], [bare])
    place = problem.loaded.columns.index(PATH)
    largest = max(float(np.abs(factor[:, place]).max(initial=0.0)) for factor in problem.loaded.factors)
    assert largest < 1e-3 * problem.loaded.torque_norms.max()


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
