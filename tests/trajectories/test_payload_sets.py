"""Every payload of a set: the bound against bodies drawn, a search and the semidefinite form; slopes; designs."""

from dataclasses import replace

import cvxpy
import numpy as np
import pytest
from dynident import trajectories
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import (
    InertialParameters,
    Motion,
    Pose,
    Robot,
    base_parameters,
    load_robot,
    payload_regressor,
    stand_in,
)
from dynident.model.frames import frames_at
from dynident.tests.trajectories.safe_runs import dense, drawn_bodies
from dynident.trajectories.design.limits import Limit
from dynident.trajectories.design.scene import Capsule, HalfSpace
from dynident.trajectories.design.score import check_held, holding_torques, load_torques
from dynident.trajectories.motions.family import Samples

TURNED = Pose.from_rpy((0.02, -0.03, 0.1), (0.4, -0.2, 1.1))
SETS = {
    "ball": trajectories.PayloadSet.within(8.0, 0.2, (0.0, 0.0, 0.1)),
    "ellipsoid": trajectories.PayloadSet.within(5.0, (0.3, 0.1, 0.05), (0.1, 0.0, 0.1)).seen_from(TURNED),
    "box": trajectories.PayloadSet.within(12.0, (0.1, 0.15, 0.25), (0.0, 0.05, 0.2), box=True).seen_from(TURNED),
}
DRAW = np.random.default_rng(20)


def regressor_rows(robot: Robot, count: int) -> Array:
    """Rows of the payload's regressor in random states, (count n, 10)."""
    states = DRAW.uniform(-3.0, 3.0, (3, count, robot.n))
    return np.asarray(dense(payload_regressor(robot), *states).reshape(-1, 10))


ROWS = regressor_rows(load_robot("ur10e"), 20)


@pytest.mark.parametrize("kind", SETS)
def test_no_body_of_the_set_exceeds_the_bound_and_one_reaches_it(kind: str) -> None:
    payloads = SETS[kind]
    largest, smallest = payloads.extremes(ROWS)
    torques = ROWS @ drawn_bodies(payloads, 10_000, DRAW).T
    room = 1e-9 * np.abs(ROWS).max()
    assert (torques <= largest[0][:, None] + room).all()
    assert (torques >= smallest[0][:, None] - room).all()
    for extreme in (largest, smallest):
        assert np.allclose(np.einsum("kp,pk->k", ROWS, extreme[1:]), extreme[0], rtol=1e-9, atol=room)
        in_set = payloads.extremes(np.eye(10)[9:])[0][0, 0]
        assert extreme[10].max() <= in_set * (1.0 + 1e-12) == pytest.approx(payloads.mass)
    outside = trajectories.PayloadSet(1.02 * payloads.mass, payloads.centre, 1.02 * payloads.axes, payloads.region)
    beyond = ROWS @ drawn_bodies(outside, 10_000, DRAW).T
    assert (beyond > largest[0][:, None] + room).any()  # the test can fail


def test_the_bound_is_that_of_the_semidefinite_form() -> None:
    """Over pseudo-inertias J >= 0 with J44 <= M and tr(J P) >= 0 for the ellipsoid (Wensing, Kim, Slotine 2018)."""
    payloads = SETS["ellipsoid"]
    shape = np.linalg.inv(payloads.axes @ payloads.axes.T)
    P = np.zeros((4, 4))
    P[:3, :3], P[:3, 3] = -shape, shape @ payloads.centre
    P[3, :3], P[3, 3] = P[:3, 3], 1.0 - payloads.centre @ shape @ payloads.centre
    J, row = cvxpy.Variable((4, 4), PSD=True), cvxpy.Parameter(10)
    xx, yy, zz = (J[i, i] for i in range(3))
    body = [yy + zz, -J[0, 1], -J[0, 2], xx + zz, -J[1, 2], xx + yy, J[0, 3], J[1, 3], J[2, 3], J[3, 3]]
    problem = cvxpy.Problem(
        cvxpy.Maximize(row @ cvxpy.hstack(body)), [J[3, 3] <= payloads.mass, cvxpy.trace(J @ P) >= 0.0]
    )
    for k in (1, 8, 57, 88):
        row.value = ROWS[k]
        assert problem.solve(solver=cvxpy.CLARABEL) == pytest.approx(
            payloads.extremes(ROWS[k : k + 1])[0][0, 0], rel=1e-5, abs=1e-6
        )


ARM = stand_in.rehearsed(load_robot("ur10e"))
BOUNDS = trajectories.JointBounds.of(ARM)
BODY = InertialParameters.from_com(3.0, [0.0, 0.0, 0.1], 0.009 * np.eye(3))
POSE = np.radians([0.0, -60.0, 90.0, -120.0, -90.0, 0.0])


def problem(
    payloads: trajectories.PayloadSet | None, torque: Array = BOUNDS.torque, covariance: Array | None = None
) -> trajectories.DesignProblem:
    """A motion of four joints near a pose of a UR10e's stand-in."""
    shape = trajectories.NearShape(POSE[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 8.0)
    goal = trajectories.NearGoal(0.007 * BOUNDS.torque, 10.0, BODY)
    loads = trajectories.Loads(known() if covariance is not None else ARM.parameters, payloads, covariance)
    return trajectories.build_design(ARM, shape, goal, bounds=replace(BOUNDS, torque=torque), loads=loads)


def known() -> dict[str, float]:
    base = base_parameters(ARM)
    return dict(zip(base.columns, base.value(ARM.parameters).tolist(), strict=True))


def torque_limit_of(task: trajectories.DesignProblem) -> Limit:
    return next(limit for limit in task.limits if limit.kind == "torque")


@pytest.mark.parametrize("kind", SETS)
def test_slopes_are_those_of_differences(kind: str) -> None:
    """In the entries of the regressor, with the robot's own torque and its uncertainty."""
    root = DRAW.standard_normal((len(known()), len(known())))
    task = problem(SETS[kind], covariance=root @ root.T / 400.0)
    limit, states = torque_limit_of(task), DRAW.uniform(-2.0, 2.0, (3, 20, ARM.n))
    samples = Samples(np.full(20, 0.1), *states)
    state = task.kernel.state(samples, 0.05)
    weights, step = DRAW.standard_normal(limit.values(state).shape), DRAW.standard_normal(state.entries.shape)
    slopes = Samples(*map(np.zeros_like, state))
    limit.measure(state)[1](weights, slopes)
    h = 1e-7
    ends = [
        (limit.values(state._replace(entries=state.entries + s * h * step)) * weights).sum() for s in (1.0, -1.0)
    ]
    assert (ends[0] - ends[1]) / (2.0 * h) == pytest.approx((slopes.entries * step).sum(), rel=1e-5)


@pytest.mark.parametrize("kind", ["box"])
def test_what_is_added_to_the_robots_own_torque_is_the_sets(kind: str) -> None:
    """Against the payload's regressor by itself, and two standard deviations by the covariance."""
    names, torque = known(), np.where(np.arange(6) == 4, np.inf, BOUNDS.torque)
    covariance = np.diag(np.linspace(0.1, 1.0, len(names)))
    plain, sure, doubtful = (
        problem(None, torque),
        problem(SETS[kind], torque),
        problem(SETS[kind], torque, covariance),
    )
    x = plain.family.random(DRAW)
    states = [task.state(x, 0.0) for task in (plain, sure, doubtful)]
    own, known_well, known_badly = (
        torque_limit_of(task).values(state) for task, state in zip((plain, sure, doubtful), states, strict=True)
    )
    rows = dense(payload_regressor(ARM), *states[0][1:4])
    largest, smallest = SETS[kind].extremes(rows.reshape(-1, 10))
    unit = np.where(np.isfinite(torque), torque, 1.0)
    expected = np.hstack([own + extreme[0].reshape(-1, 6) / unit for extreme in (largest, smallest)])
    assert np.allclose(known_well, expected, rtol=1e-9, atol=1e-9)
    W = plain.kernel.matrix(states[0])[:, :, [plain.kernel.columns.index(name) for name in names]]
    sigma = np.sqrt(np.einsum("jNc,c,jNc->Nj", W, np.diag(covariance), W)) / unit
    assert np.allclose(known_badly - known_well, np.hstack([2.0 * sigma, -2.0 * sigma]), atol=1e-9)


def test_brakes_hold_what_gravity_asks_of_the_worst_body() -> None:
    task, pose = problem(SETS["ball"].lighter(6.0)), POSE[None]
    rows = dense(payload_regressor(ARM), pose, 0.0 * pose, 0.0 * pose)[0]
    still = Motion(np.zeros(1), pose, 0.0 * pose, 0.0 * pose)
    own = next(iter(load_torques(problem(None), still).values()))[0]
    extremes = [own + extreme[0] for extreme in SETS["ball"].lighter(6.0).extremes(rows)]
    assert np.allclose(holding_torques(task, pose), np.abs(extremes).max(axis=0), atol=1e-9)


def test_a_pose_in_which_a_payload_cannot_be_held_is_refused() -> None:
    task = problem(replace(SETS["ball"], mass=40.0))
    with pytest.raises(InputError, match="at rest in the pose: torque with any payload up to 40 kg of joint"):
        check_held(task, POSE[None])


def test_the_ball_is_a_body_of_the_scene() -> None:
    scene = trajectories.Scene(
        (Capsule("arm", 2, 0.05), Capsule("hand", 5, 0.05)), (HalfSpace("floor", offset=-5.0),)
    )
    shape = trajectories.NearShape(POSE[None], (2, 3, 5, 6), np.full(4, np.radians(30.0)), 8.0)
    loads = trajectories.Loads(ARM.parameters, SETS["ball"])
    goal = trajectories.NearGoal(0.007 * BOUNDS.torque, 10.0, BODY)
    task = trajectories.build_design(ARM, shape, goal, bounds=BOUNDS, loads=loads, scene=scene)
    limit = next(limit for limit in task.limits if limit.kind == "clearance")
    labels = [label for label in limit.labels if "payload" in label]
    assert labels == ["payload within bounds to floor", "payload within bounds to arm"]
    height = frames_at(ARM, POSE.tolist())[6]
    centre = height.p + height.R @ SETS["ball"].centre
    values = limit.values(task.at_rest(POSE[None]))[0] * limit.unit
    base = ARM.base.R @ centre + ARM.base.p
    assert values[limit.labels.index(labels[0])] == pytest.approx(base[2] + 5.0 - 0.2)
