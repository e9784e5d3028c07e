"""The equations Y = W chi: exact on exact data, however they are reduced, merged, saved, held whole or read."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.results import read_earlier, shown_noise, write_npz
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.schema import write_json
from dynident.estimation import PAYLOAD, Settings, identify, payload_problem, robot_result
from dynident.estimation.answers.identification import identification_system, payload_system
from dynident.estimation.equations.equations import Equations, merged
from dynident.estimation.equations.observer import Observer, recorded, reduced, reduced_pieces, used
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.signals.filtering import moving_parts, noise_bandwidth
from dynident.model import InertialParameters, Motion, Processing, Recording, base_parameters, load_robot
from dynident.model.motion import Measurement
from dynident.trajectories import Simulator
from dynident.trajectories.design.goal import MEMORY


@pytest.mark.parametrize(("name", "decimate"), [("rx90", 10), ("tx40", 1), ("ur10e", 1)])
def test_exact_data_satisfy_the_equations_however_decimated(
    name: str, decimate: int, simulated: Callable[[str], Simulator], wander: Callable[..., Motion]
) -> None:
    simulator = simulated(name)
    base, motion = base_parameters(simulator.robot), wander(6, 0, rate=250.0)
    truth, observer = base.value(simulator.robot.parameters), Observer(simulator.robot, base.columns)
    data = observer.observe(*used(simulator.measure(motion), Processing(decimate=decimate)))
    for W, Y, t in zip(data.W, data.Y, data.t, strict=True):
        assert np.abs(W @ truth - Y).max() < 1e-9 * np.abs(Y).max()
        assert np.allclose(np.diff(t)[np.diff(t) < 0.05], 0.004 * decimate)
    assert reduced(data).effective_rows == pytest.approx([noise_bandwidth(decimate) * len(Y) for Y in data.Y])


def paused(rate: float = 100.0) -> Motion:
    """Rest 1 s, move 2 s, rest 0.2 s, move 3 s, rest 2 s, move 1 s."""
    parts = [(1.0, 0.0), (2.0, 0.5), (0.2, 0.0), (3.0, -0.4), (2.0, 0.0), (1.0, 0.5)]
    speed = np.concatenate([np.full(int(d * rate), v) for d, v in parts])[:, None]
    t = np.arange(len(speed)) / rate
    return Motion(t, np.cumsum(speed, axis=0) / rate, speed, np.zeros_like(speed))


def test_moving_stretches_are_used_and_short_pauses_do_not_end_them() -> None:
    motion = paused()
    moving = moving_parts(motion, 2e-3)
    used = motion.t[moving]
    assert used[0] == pytest.approx(1.0)
    assert moving[(motion.t >= 1.0) & (motion.t < 6.2)].all()  # the pause of 0.2 s included
    assert not moving[(motion.t >= 6.2) & (motion.t < 8.2)].any()
    assert moving[motion.t >= 8.2].all() == (motion.t[-1] - 8.2 >= 1.0)
    resting = Motion(motion.t, motion.q, 0.0 * motion.qd, motion.qdd)
    assert not moving_parts(resting, 2e-3).any()


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
    whole = recorded(observer, [used(data, settings)])[0]
    parts = ((piece, np.abs(piece.motion.qd) >= slow) for piece in pieces(data, size))
    same(whole, reduced_pieces(observer, parts, decimate))
    same(whole, reduced(observer.observe(*used(data, settings))))
    partner = Motion(data.motion.t, data.motion.q, 0.0 * data.motion.qd, data.motion.qdd)
    assert not used(data, settings, partner).keep.any()  # what is slow in either is left out


def test_saved_and_merged_problems(simulated: Simulated, wander: Wander, tmp_path: Path) -> None:
    simulator = simulated("tx40")
    observer = Observer(simulator.robot, base_parameters(simulator.robot).columns)
    data = [noisy(simulator, wander(6, k), k) for k in range(3)]
    problems = [recorded(observer, [used(each, Processing())])[0] for each in data]
    for k, problem in enumerate(problems):
        problem.save(tmp_path / f"{k}.npz")
    loaded = [Equations.load(tmp_path / f"{k}.npz") for k in range(3)]
    for before, after in zip(problems, loaded, strict=True):
        assert before.columns == after.columns
        assert all(np.array_equal(a, b) for a, b in zip(before.factors, after.factors, strict=True))
    same(merged(problems), merged([loaded[2], merged([loaded[0], loaded[1]])]))
    with pytest.raises(ValueError, match="different columns"):
        merged([problems[0], problems[1].select(problems[1].columns[1:])])


SETTINGS = Processing(cutoff=15.0, decimate=4)
Recordings = list[Recording]


@pytest.fixture(scope="module")
def recordings(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> tuple[Recordings, Recordings]:
    """Two noisy trajectories without and with payload."""
    simulator = simulated("rx90")
    empty, full = (
        [
            simulator.record(wander(6, k + 1, rate=250.0), load, [0.3] * 6, [k, bool(load)], f"{k} {bool(load)}")
            for k in (0, 1)
        ]
        for load in (None, payload)
    )
    return empty, full


def solved(W: Array, Y: Array, row_weights: Array) -> Array:
    return np.asarray(np.linalg.lstsq(W * row_weights[:, None], Y * row_weights, rcond=None)[0])


def test_payload(recordings: tuple[Recordings, Recordings]) -> None:
    bare, loaded = recordings
    problem = payload_problem(load_robot("rx90"), loaded, bare, settings=Settings(SETTINGS, robust=False))
    system = payload_system(problem)
    both = weighted(problem.both)
    assert system.columns == both.names
    values = solved(system.W, system.Y, system.weights[system.joint - 1])
    np.testing.assert_allclose(values, both.values, atol=1e-7 * np.abs(values).max())
    assert not system.W[~system.loaded, -10:].any()
    assert system.W[system.loaded, -10:].any()
    assert system.sources == ("0 False", "1 False", "0 True", "1 True")


def test_npz(recordings: tuple[Recordings, Recordings], tmp_path_factory: pytest.TempPathFactory) -> None:
    bare, _ = recordings
    result = identify(load_robot("rx90"), bare, Settings(SETTINGS, robust=False))
    path = tmp_path_factory.mktemp("npz") / "system.out"
    write_npz(path, identification_system(result))
    assert [file.name for file in path.parent.iterdir()] == ["system.out"]
    with np.load(path, allow_pickle=False) as data:
        values = solved(data["W"], data["Y"], data["row_weights"])
        assert [str(name) for name in data["columns"]] == list(result.base.columns)
        assert [str(name) for name in data["sources"]] == ["0 False", "1 False"]
        assert "known" not in data
    np.testing.assert_allclose(values, result.estimate.values, atol=1e-7 * np.abs(values).max())
    read = Equations.load(path)
    assert (read.columns, read.rows, read.effective_rows) == (
        result.problem.columns, result.problem.rows, result.problem.effective_rows,
    )  # fmt: skip
    for ours, theirs in zip(read.factors, result.problem.factors, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def saved(path: Path, columns: tuple[str, ...], joints: int = 2) -> Equations:
    """Equations of random rows, in a file."""
    draw, c = np.random.default_rng(0), len(columns) + 1
    factors = tuple(np.asarray(np.linalg.qr(draw.standard_normal((60, c)), mode="r")) for _ in range(joints))
    equations = Equations(columns, factors, (60,) * joints, (48.0,) * joints)
    equations.save(path)
    return equations


def test_rows_weigh_by_noise_and_independence(tmp_path: Path) -> None:
    path = tmp_path / "r.npz"
    factors = saved(path, ("A", "B", "C")).factors
    with pytest.raises(InputError, match="has no weights"):
        shown_noise(path)
    with np.load(path) as data:
        np.savez(path, weights=np.array([2.0, 4.0]), **dict(data))
    assert shown_noise(path)[0] == pytest.approx(MEMORY * np.array([0.5, 0.25]))
    for noise in (np.array([2.0, 0.5]), None):
        information = read_earlier([path], noise)
        sizes = np.ones(2) if noise is None else noise
        expected = sum(0.8 * f[:, :3].T @ f[:, :3] / s**2 for f, s in zip(factors, sizes, strict=True))
        assert information.columns == ("A", "B", "C")
        assert information.factor.T @ information.factor == pytest.approx(expected)
    with pytest.raises(InputError, match="2 joints, not 3"):
        read_earlier([path], np.ones(3))
    with pytest.raises(InputError, match="have no payload"):
        read_earlier([path], None, PAYLOAD)


def test_json_holds_the_covariance(recordings: tuple[Recordings, Recordings], tmp_path: Path) -> None:
    path, result = (
        tmp_path / "r.json",
        identify(load_robot("rx90"), recordings[0], Settings(SETTINGS, robust=False)),
    )
    write_json(path, robot_result(result))
    noise = 1.0 / result.estimate.weights
    assert shown_noise(path)[0] == pytest.approx(MEMORY * noise)
    factor = read_earlier([path], noise).factor
    assert np.linalg.inv(factor.T @ factor) == pytest.approx(result.estimate.covariance, rel=1e-6)
    with pytest.raises(InputError, match="holds no unweighted rows"):
        read_earlier([path], None)


def test_payload_with_the_robot_known(tmp_path: Path) -> None:
    path, names = tmp_path / "p.npz", tuple("abcdefghij")
    (factor,) = saved(path, ("ZZ1", *PAYLOAD), 1).factors
    information = read_earlier([path], None, names)
    assert information.columns == names
    assert information.factor.T @ information.factor == pytest.approx(0.8 * factor[:, 1:11].T @ factor[:, 1:11])


@pytest.mark.parametrize(
    ("name", "words"), [("x.txt", "dynident identify"), ("x.npz", "not a saved reduced problem")]
)
def test_files_that_are_neither(name: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("hello")
    with pytest.raises(InputError, match=words):
        read_earlier([tmp_path / name], None)
