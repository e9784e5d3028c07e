"""The system held whole gives any solver the same answer."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.apps.report.recordings import write_npz
from dynident.common.arrays import Array
from dynident.estimation import Settings, identify, payload_estimate, payload_problem
from dynident.estimation.answers.identification import identification_system
from dynident.estimation.answers.system import payload_system
from dynident.estimation.equations.equations import Equations
from dynident.estimation.payload.methods import combined
from dynident.model import InertialParameters, Motion, Processing, Recording, load_robot
from dynident.trajectories import Simulator

SETTINGS = Processing(cutoff=15.0, decimate=4)
Recordings = list[Recording]


@pytest.fixture(scope="module")
def recordings(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> tuple[Recordings, Recordings]:
    """Two noisy trajectories without and with payload."""
    simulator = simulated("rx90")
    motions = [wander(6, seed, rate=250.0) for seed in (1, 2)]
    return tuple(  # type: ignore[return-value]
        [simulator.record(motion, load, [0.3] * 6, [k, load is not None], f"{k} {load is not None}")
         for k, motion in enumerate(motions)]
        for load in (None, payload)
    )  # fmt: skip


def solved(W: Array, Y: Array, row_weights: Array) -> Array:
    return np.asarray(np.linalg.lstsq(W * row_weights[:, None], Y * row_weights, rcond=None)[0])


def test_identification(recordings: tuple[Recordings, Recordings]) -> None:
    bare, _ = recordings
    result = identify(load_robot("rx90"), bare, Settings(SETTINGS, robust=False))
    system = identification_system(result, bare, SETTINGS)
    assert system.columns == result.base.columns
    values = solved(system.W, system.Y, system.weights[system.joint - 1])
    np.testing.assert_allclose(values, result.estimate.values, atol=1e-7 * np.abs(values).max())
    assert not system.loaded.any()
    counts = [int(np.sum(system.joint == j)) for j in range(1, 7)]
    assert counts == list(result.problem.rows)
    assert set(system.recording) == {0, 1}
    for number in (0, 1):
        assert system.t[system.recording == number].max() <= bare[number].t[-1]


def test_payload(recordings: tuple[Recordings, Recordings]) -> None:
    bare, loaded = recordings
    problem = payload_problem(load_robot("rx90"), loaded, bare, settings=Settings(SETTINGS, robust=False))
    system = payload_system(problem, loaded, bare, SETTINGS)
    both = combined(problem)
    assert system.columns == both.names
    values = solved(system.W, system.Y, system.weights[system.joint - 1])
    np.testing.assert_allclose(values, both.values, atol=1e-7 * np.abs(values).max())
    assert not system.W[~system.loaded, -10:].any()
    assert system.W[system.loaded, -10:].any()
    assert system.sources == ("0 False", "1 False", "0 True", "1 True")


def test_payload_with_a_stored_robot(recordings: tuple[Recordings, Recordings]) -> None:
    """Without unloaded recordings: the robot's part moved to the left, the rest solved, is method 1."""
    bare, loaded = recordings
    robot = load_robot("rx90")
    known = identify(robot, bare, Settings(SETTINGS, robust=False)).estimate
    problem = payload_problem(robot, loaded, known=known, settings=Settings(SETTINGS, robust=False))
    system = payload_system(problem, loaded, (), SETTINGS)
    assert system.known is not None
    assert system.loaded.all()
    residue = system.Y - system.W[:, :-10] @ system.known
    values = solved(system.W[:, -10:], residue, system.weights[system.joint - 1])
    np.testing.assert_allclose(values, payload_estimate(problem, 1).estimate.values, atol=1e-8)


def test_npz(recordings: tuple[Recordings, Recordings], tmp_path_factory: pytest.TempPathFactory) -> None:
    bare, _ = recordings
    result = identify(load_robot("rx90"), bare, Settings(SETTINGS, robust=False))
    path = tmp_path_factory.mktemp("npz") / "system.out"
    write_npz(path, identification_system(result, bare, SETTINGS))
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


def test_a_system_with_missing_rows_is_refused(recordings: tuple[Recordings, Recordings]) -> None:
    bare, _ = recordings
    system = identification_system(
        identify(load_robot("rx90"), bare, Settings(SETTINGS, robust=False)), bare, SETTINGS
    )
    with pytest.raises(ValueError, match="one entry for each row"):
        replace(system, joint=system.joint[1:])
    with pytest.raises(ValueError, match="rows and"):
        replace(system, Y=system.Y[1:])
