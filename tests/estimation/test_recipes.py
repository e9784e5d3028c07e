"""Public data sets: the log maps that come with the project read their formats (synthetic lines, no recording)."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.map import read_log_map
from dynident.apps.logs.read import read_recording
from dynident.model import Joint, Robot, load_robot

FOLDER = Path(__file__).parents[2] / "examples/logs"
DRAW = np.random.default_rng(0)


def test_every_recipe_is_read_and_described(root: Path) -> None:
    text = (root / "docs/data_sets.md").read_text(encoding="utf-8") + (root / "docs/logs.md").read_text("utf-8")
    paths = sorted(FOLDER.glob("*.toml"))
    assert len(paths) == 4
    for path in paths:
        assert read_log_map(path)
        assert f"examples/logs/{path.name}" in text


def test_ur10e_of_dynamic_calibration(tmp_path: Path) -> None:
    """No header; time, q, qd, i, wanted currents, wanted torques."""
    table = DRAW.normal(size=(40, 31))
    table[:, 0] = 838.465 + 0.01 * np.arange(40)
    np.savetxt(tmp_path / "ur.csv", table, delimiter=",", fmt="%.4f")
    how = read_log_map(FOLDER / "ur10e_dynamic_calibration.toml")
    recording = read_recording(tmp_path / "ur.csv", load_robot("ur10e"), [2.0] * 6, how)
    assert recording.qd is not None
    assert np.allclose(recording.t, table[:, 0], atol=1e-4)
    for signal, first, factor in ((recording.q, 1, 1.0), (recording.qd, 7, 1.0), (recording.torque, 13, 2.0)):
        assert np.allclose(signal, factor * table[:, first : first + 6], atol=2e-4)


def test_ur10e_recipe_gives_the_known_recording(tmp_path: Path, recordings: Path) -> None:
    """The prepared file, written back as the data set has it, is read as the same recording."""
    path = recordings / "ur10e" / "unloaded.csv.gz"
    robot = load_robot("ur10e")
    prepared = read_recording(path, robot, [1.0] * 6)
    assert prepared.qd is not None
    extra = np.zeros((len(prepared.t), 12))
    raw = np.column_stack([prepared.t + 838.465, prepared.q, prepared.qd, prepared.torque, extra])
    np.savetxt(tmp_path / "ur.csv", raw, delimiter=",", fmt="%.4f")
    how = read_log_map(FOLDER / "ur10e_dynamic_calibration.toml")
    again = read_recording(tmp_path / "ur.csv", robot, [1.0] * 6, how)
    assert np.allclose(again.t - again.t[0], prepared.t, atol=1e-9)
    assert np.array_equal(again.torque, prepared.torque)


def test_tx40_of_figaroh(tmp_path: Path) -> None:
    """Two files without time, motor side; (8) and (9) by hand."""
    q, tau = DRAW.normal(size=(2, 30, 6))
    N = np.array([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
    counted = q - np.array([0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0])
    qm = N * counted
    qm[:, 5] += 32.0 * counted[:, 4]
    taum = tau / N
    taum[:, 4] = (tau[:, 4] - tau[:, 5]) / 45.0
    for name, values in (("pos_read_data.csv", qm), ("curr_data.csv", taum)):
        np.savetxt(tmp_path / name, values, delimiter=",", header="a,b,c,d,e,f", comments="")
    recording = read_recording(tmp_path, load_robot("tx40"), None, read_log_map(FOLDER / "tx40_figaroh.toml"))
    assert np.allclose(recording.t, np.arange(30) / 5000.0)
    assert np.allclose(recording.q, q)
    assert np.allclose(recording.torque, tau)


def test_panda(tmp_path: Path) -> None:
    """One number a line, seven lines a sample, four files."""
    values = {name: DRAW.normal(size=(25, 7)) for name in ("positions", "velocity", "torques")}
    for name, rows in values.items():
        np.savetxt(tmp_path / f"exciting_traj_{name}.txt", rows.ravel(), fmt="%.6g")
    np.savetxt(tmp_path / "exciting_traj_time.txt", 0.001 * np.arange(25))
    robot = Robot("seven", tuple(Joint(alpha=1.0) for _ in range(7)))
    recording = read_recording(tmp_path, robot, None, read_log_map(FOLDER / "panda_dyn_model.toml"))
    assert recording.qd is not None
    for signal, name in ((recording.q, "positions"), (recording.qd, "velocity"), (recording.torque, "torques")):
        assert np.allclose(signal, values[name], atol=1e-5)


def test_ur_rtde(tmp_path: Path) -> None:
    names = ["timestamp"] + [f"actual_{kind}_{j}" for kind in ("q", "qd", "current") for j in range(6)]
    table = DRAW.normal(size=(20, 19))
    table[:, 0] = 0.002 * np.arange(20)
    np.savetxt(tmp_path / "rtde.csv", table, delimiter=" ", header=" ".join(names), comments="")
    recording = read_recording(
        tmp_path / "rtde.csv", load_robot("ur10e"), [3.0] * 6, read_log_map(FOLDER / "ur_rtde.toml")
    )
    assert recording.torque == pytest.approx(3.0 * table[:, 13:])
