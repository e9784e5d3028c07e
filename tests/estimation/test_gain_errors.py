"""Errors of the drive gains: as rescaled recordings give them, through every method, and counted once."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import (
    PAYLOAD,
    Estimate,
    Gains,
    LongMotion,
    Settings,
    answer_payload,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.diagnosis.evidence import Evidence
from dynident.estimation.diagnosis.verdict import allowing
from dynident.estimation.equations.equations import Equations, merged
from dynident.estimation.equations.observer import PATH
from dynident.estimation.fit.estimate import error_model, usual_gains
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.payload.long_motion import Source
from dynident.estimation.payload.methods import METHODS as SOLVERS
from dynident.estimation.payload.methods import constrain_payload, moved
from dynident.model import (
    InertialParameters,
    Motion,
    Processing,
    Recording,
    Robot,
    Spring,
    base_parameters,
    load_robot,
    robot_names,
)
from dynident.model.friction import PAPER
from dynident.model.regressors import payload_columns
from dynident.trajectories import Simulator
from numpy.typing import ArrayLike, NDArray

Recordings = Callable[[ArrayLike], tuple[Recording, Recording]]
METHODS = (1, 2, 3, 4)
MOTORS = [1, 4, 5]  # counted from 0; the last two of the RX90 are coupled, a spring acts on the first


def gain_sensitivity(equations: Equations, weights: Array) -> Array:
    """Derivatives of the weighted solution by each motor's relative error."""
    derivatives = weighted(equations, weights).gain_sensitivity
    assert derivatives is not None
    return derivatives


def rescaled_torque(robot: Robot, torque: Array, factors: ArrayLike) -> Array:
    """Torques of the joints with each motor's times its factor; (9) written out."""
    G = np.eye(6)
    if robot.coupling is not None:
        G[4, 5] = 1.0
    return np.asarray(torque @ np.linalg.inv(G).T * np.asarray(factors) @ G.T)


def sprung(simulator: Simulator, joint: int) -> Simulator:
    """A copy of the robot with a gravity spring on a joint."""
    robot = simulator.robot
    spring = Spring(joint, 6000.0, 0.15, (0.08, 0.35), np.pi / 2)
    return Simulator(replace(robot, drives=replace(robot.drives, spring=spring)))


@pytest.fixture(scope="module", params=["rx90", "ur10e", "sprung"])
def arm(
    request: pytest.FixtureRequest,
    simulated: Callable[[str], Simulator],
    wander: Callable[..., Motion],
    payload: InertialParameters,
) -> tuple[Simulator, Recordings]:
    """A simulator, and noisy recordings without and with payload whose torques are scaled motor by motor."""
    simulator = sprung(simulated("rx90"), 2) if request.param == "sprung" else simulated(request.param)
    noise, motion = [0.5] * 6, wander(6, 4, points=14)

    def recordings(factors: ArrayLike) -> tuple[Recording, Recording]:
        pair = [simulator.record(motion, body, noise, [9, k]) for k, body in enumerate((None, payload))]
        bare, loaded = (
            replace(recording, torque=rescaled_torque(simulator.robot, recording.torque, factors))
            for recording in pair
        )
        return bare, loaded

    return simulator, recordings


def problem_of(arm: tuple[Simulator, Recordings], factors: ArrayLike) -> LongMotion:
    bare, loaded = arm[1](factors)
    return payload_problem(arm[0].robot, [loaded], [bare], settings=Settings(robust=False))


def sensitivity(estimate: Estimate) -> Array:
    """The derivatives that come with a result."""
    assert estimate.gain_sensitivity is not None
    return estimate.gain_sensitivity


def changed(motor: int, step: float) -> Array:
    return np.asarray(1.0 + step * np.eye(6)[motor])


@pytest.fixture(scope="module")
def problem(arm: tuple[Simulator, Recordings]) -> LongMotion:
    return problem_of(arm, np.ones(6))


@pytest.fixture(scope="module")
def rescaled(arm: tuple[Simulator, Recordings]) -> dict[bytes, LongMotion]:
    """The problem for some motors' torque up and down."""
    factors = [changed(j, step) for j in MOTORS for step in (1e-5, -1e-5)]
    return {factor.tobytes(): problem_of(arm, factor) for factor in factors}


@pytest.mark.parametrize("method", METHODS)
def test_it_is_what_rescaled_recordings_give(
    problem: LongMotion, rescaled: dict[bytes, LongMotion], method: int
) -> None:
    """To 1e-6 of each parameter's own size.

    They add up to the payload, which a common error scales, unless there is a spring.
    """
    solver, estimate = SOLVERS[method], payload_estimate(problem, method).estimate
    J = sensitivity(estimate)
    assert problem.unloaded is not None
    robot_weights = weighted(problem.unloaded).weights

    def solved(factors: Array) -> Array:
        variant = replace(rescaled[factors.tobytes()])
        assert variant.unloaded is not None
        vars(variant)["bare"] = weighted(variant.unloaded, robot_weights)
        return solver(variant).solved(estimate.weights).values

    step = 1e-5  # central differences by rescaled recordings
    slopes = [(solved(changed(j, step)) - solved(changed(j, -step))) / (2 * step) for j in MOTORS]
    expected = np.column_stack(slopes)
    size = np.linalg.norm(expected, axis=1)[:, None]
    assert (np.abs(J[:, MOTORS] - expected) < 1e-6 * size).all()
    if problem.robot.spring is None:
        assert (np.abs(J.sum(axis=1) - estimate.values) < 1e-6 * size[:, 0]).all()


def test_a_stored_robot_brings_its_own_errors(arm: tuple[Simulator, Recordings], problem: LongMotion) -> None:
    """Method 1 by stored parameters is as sensitive as by the recording they came from; without, it is refused."""
    bare, _ = arm[1](np.ones(6))
    known = identify(arm[0].robot, [bare], Settings(robust=False)).estimate
    later = replace(problem, unloaded=None, difference=None, known=known)
    both = [sensitivity(payload_estimate(p, 1).estimate) for p in (problem, later)]
    assert both[1] == pytest.approx(both[0], rel=1e-5, abs=1e-8)
    old = replace(later, known=replace(known, gain_sensitivity=None))
    with pytest.raises(InputError, match="identify the robot again"):
        constrain_payload(payload_estimate(old, 1), gains=Gains((0.02,)))


def test_saved_equations_keep_what_motors_share(problem: LongMotion, tmp_path: Path) -> None:
    """Read back, and merged with themselves, they are as sensitive as before."""
    assert problem.unloaded is not None
    problem.unloaded.save(tmp_path / "p.npz")
    read = Equations.load(tmp_path / "p.npz")
    assert len(read.shared) == bool(problem.robot.coupling) + bool(problem.robot.spring)
    weights = weighted(read).weights
    J = gain_sensitivity(problem.unloaded, weights)
    for equations in (read, merged([read, problem.unloaded])):
        assert gain_sensitivity(equations, weights) == pytest.approx(J, rel=1e-6, abs=1e-9 * np.abs(J).max())
    if read.shared:
        with pytest.raises(ValueError, match="different coupled drives"):
            merged([read, replace(read, shared={})])


def test_common_and_own_errors(problem: LongMotion) -> None:
    """A common error widens the mass by its share of it; one number stands for six; both add up."""
    free = payload_estimate(problem, 4)

    def sigma(gains: Gains | None) -> Array:
        return constrain_payload(free, gains=gains).result.free.sigma

    alone = sigma(None)
    assert alone == pytest.approx(free.estimate.sigma)
    common = sigma(Gains(common=0.03))
    J = sensitivity(free.estimate)
    share = free.mass if problem.robot.spring is None else abs(J[9].sum())
    assert np.sqrt(common[9] ** 2 - alone[9] ** 2) == pytest.approx(0.03 * share, rel=1e-6)
    assert sigma(Gains((0.02,))) == pytest.approx(sigma(Gains((0.02,) * 6)))
    own = 0.02 * np.linalg.norm(J, axis=1)
    both = sigma(Gains((0.02,), 0.03))
    assert both**2 == pytest.approx(common**2 + own**2, rel=1e-6)


GAINS = Gains((0.02,))
SETTINGS = Processing(decimate=4)
NOISE = np.array([3.0, 3.0, 2.0, 1.0, 1.0, 0.7])
RUNS = 20
Record = Callable[[int, float], Recording]


@pytest.fixture(scope="module", params=["ur10e", "rx90"])
def source(request: pytest.FixtureRequest, simulated: Callable[[str], Simulator]) -> Simulator:
    """The RX90's drives 5 and 6 are coupled."""
    return simulated(request.param)


@pytest.fixture(scope="module")
def robot(source: Simulator) -> Robot:
    return load_robot(source.robot.name)


@pytest.fixture(scope="module")
def recorders(
    source: Simulator, wander: Callable[..., Motion], payload: InertialParameters
) -> tuple[Record, Record]:
    """Without payload, and another motion with it: run -> recording whose gains are off by that run's errors."""

    def recorder(body: InertialParameters | None, seed: int) -> Record:
        motion = wander(6, seed, points=20)
        exact, coupling = source.measure(motion, body).torque, source.robot.coupling

        def record(run: int, size: float = 0.02) -> Recording:
            errors = size * np.random.default_rng([5, run]).standard_normal(6)
            noisy = exact + NOISE * np.random.default_rng([seed, run]).standard_normal(exact.shape)
            motors = (1.0 + errors) * (coupling.motor_torques(noisy) if coupling else noisy)
            torque = coupling.joint_torques(motors) if coupling else motors
            return Recording(motion.t, motion.q, torque, motion.qd, f"motion {seed}", gain_sigma=0.0)

        return record

    return recorder(None, 3), recorder(payload, 4)


def test_intervals_hold_what_wrong_gains_do(
    source: Simulator, robot: Robot, recorders: tuple[Record, Record], payload: InertialParameters
) -> None:
    """A stored robot and a payload have the same errors: counted once they cover, left out they do not."""
    hits: dict[str, list[NDArray[np.bool_]]] = {"robot": [], "robot exact": [], "payload": [], "payload exact": []}
    for run in range(RUNS):
        bare, loaded = (record(run, 0.02) for record in recorders)
        identification = identify(robot, [bare], Settings(SETTINGS, robust=False, friction=PAPER, gains=GAINS))
        estimate, truth = identification.estimate, identification.base.value(dict(source.robot.parameters))
        assert estimate.interval95_with_gains is not None
        for name, ends in (("robot", estimate.interval95_with_gains), ("robot exact", estimate.interval95)):
            hits[name].append((ends[:, 0] <= truth) & (truth <= ends[:, 1]))
        problem = payload_problem(robot, [loaded], [], estimate, Settings(SETTINGS, robust=False))
        free = payload_estimate(problem, 1)
        for name, gains in (("payload", GAINS), ("payload exact", None)):
            model = error_model(free.estimate, gains)
            hits[name].append(np.abs(model.values - payload.vector)[6:] <= 2.0 * model.sigma[6:])
    share = {name: np.mean(inside, axis=0) for name, inside in hits.items()}
    assert 0.92 < share["robot"].mean() < 0.99, share["robot"]
    assert share["robot"].min() > 0.7
    assert share["robot exact"].mean() < 0.85
    assert share["payload"].mean() > 0.88, share["payload"]
    assert share["payload exact"][3] < 0.5


def test_a_stored_robots_error_is_not_an_error_of_its_own(robot: Robot, recorders: tuple[Record, Record]) -> None:
    """Robot and payload apart would be several times less sure of the mass: 2 % of the robot's torques."""
    bare, loaded = (record(0, 0.0) for record in recorders)
    known = identify(robot, [bare], Settings(SETTINGS, robust=False, friction=PAPER, gains=GAINS)).estimate
    assert known.covariance_by_gains is not None

    def mass_sigma(known: Estimate, gains: Gains | None) -> float:
        problem = payload_problem(robot, [loaded], [], known, Settings(SETTINGS, robust=False))
        return float(constrain_payload(payload_estimate(problem, 1), gains=gains).result.free.sigma[9])

    once, plain = mass_sigma(known, GAINS), mass_sigma(known, None)
    bare_known = replace(known, gain_covariance=None)
    assert mass_sigma(bare_known, GAINS) == once  # the robot's own share is not added again
    assert mass_sigma(bare_known, None) == plain
    twice = replace(bare_known, covariance=known.covariance + known.covariance_by_gains)
    assert mass_sigma(twice, GAINS) > 2.5 * once
    assert once > 3.0 * plain


@pytest.mark.parametrize("name", robot_names())
def test_gains_of_which_nothing_is_said_have_usual_errors(name: str) -> None:
    """The recordings' word comes first; the least sure of them counts."""
    robot = load_robot(name)
    silent = Recording(np.arange(3.0), np.zeros((3, robot.n)), np.zeros((3, robot.n)))
    exact, stated = replace(silent, gain_sigma=0.0), replace(silent, gain_sigma=0.005)
    usual = {"motor": 0.02, "link": 0.01}[robot.drives.side]
    assert usual_gains(robot, [exact, exact]) is None
    assert usual_gains(robot, [exact, stated]) == Gains((0.005,))
    assert usual_gains(robot, [exact, silent]) == usual_gains(robot, []) == Gains((usual,), assumed=True)
    assert usual_gains(robot, [replace(silent, gain_sigma=0.05), silent]) == Gains((0.05,))
    assert usual_gains(robot, [replace(silent, gains=(1.0,) * robot.n)]) == Gains((0.02,), assumed=True)


@pytest.mark.parametrize("error", [pytest.param(0.0, marks=pytest.mark.long), 0.02])
def test_what_is_assumed_of_gains_shortens_no_interval(
    error: float, robot: Robot, recorders: tuple[Record, Record]
) -> None:
    """Joints may agree or disagree; by any method. Nor does what is stated of them."""
    exact = [record(1, error) for record in recorders]
    silent, told = ([replace(recording, gain_sigma=sigma) for recording in exact] for sigma in (None, 0.02))
    each = []
    for bare, heavy in (exact, silent, told):
        answer = answer_payload(payload_problem(robot, [heavy], [bare], settings=Settings(SETTINGS)))
        each.append({one.method: float(np.ptp(one.intervals.parameters[9])) for one in answer.constrained})
    assert each[0].keys() == each[1].keys() == each[2].keys()
    for method, width in each[0].items():
        assert min(each[1][method], each[2][method]) > width


@pytest.mark.parametrize("name", ["rx90", "ur10e", "panda"])
def test_stating_errors_of_gains_shortens_no_interval(name: str, payload: InertialParameters) -> None:
    """By any method, however far the stated errors excuse joints that disagree; on equations drawn at random."""
    robot, draw = load_robot(name), np.random.default_rng(7)
    base = base_parameters(robot)
    chi, G = draw.uniform(1.0, 9.0, len(base.columns)), base.effect_of(payload_columns(robot))
    columns, count = (*base.columns, *PAYLOAD), (300,) * robot.n

    def drawn(body: Array) -> Equations:
        W = draw.standard_normal((robot.n, 300, len(chi)))
        rows = [np.column_stack([own, own @ G]) for own in W]
        torques = [own @ np.append(chi, body) + 2.0 * draw.standard_normal(300) for own in rows]
        factors = [np.column_stack(both) for both in zip(rows, torques, strict=True)]
        return Equations(columns, tuple(factors), count, tuple(map(float, count)))

    bare, loaded = drawn(np.zeros(10)).select(base.columns), drawn(payload.vector)
    change = loaded.minus(base.columns, chi).select((*PAYLOAD, PATH))
    motion = LongMotion(robot, base, loaded, Source((), (), robot.processing), bare, change)
    for method in METHODS:
        free = payload_estimate(motion, method)
        for factor in (1.0, 1.5, 3.0):
            exact = constrain_payload(allowing(free, Evidence(robot, disagreement=3.0, unexcused=3.0)))
            for gains in (Gains((1e-3,)), Gains((0.02,)), Gains(common=0.1)):
                told = allowing(free, Evidence(robot, disagreement=factor, unexcused=3.0), gains)
                possible, wider = constrain_payload(told, gains=gains), 1.0 - 1e-9
                assert (possible.result.free.sigma >= wider * exact.result.free.sigma).all()
                alone = error_model(moved(free, factor=factor).estimate, gains)
                assert (possible.result.free.sigma >= wider * alone.sigma).all()
                assert (
                    possible.result.free.sigma <= np.maximum(exact.result.free.sigma, alone.sigma) / wider
                ).all()
