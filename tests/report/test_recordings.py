"""Simulated recordings on disk: read back as they were, with the truth beside them."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.apps.logs.read import read_recording
from dynident.apps.report.recordings import write_recording, write_truth
from dynident.model import InertialParameters, load_robot
from dynident.model.files.payload_file import read_payload
from dynident.trajectories import Controller, Experiment, Task, plan_point_to_point, run_experiment
from dynident.trajectories.motions.via_points import random_points
from dynident.trajectories.simulation.disturbances import RX90_DISTURBANCES

RX90 = load_robot("rx90")
LEVELS = replace(RX90_DISTURBANCES, gain_error=0.02)


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    reference = plan_point_to_point(RX90, random_points(RX90, 2, 0))
    tasks = [Task("a", reference), Task("b", reference, PAYLOAD)]
    return run_experiment(RX90, tasks, LEVELS, seed=3)


def test_a_recording_is_read_back(experiment: Experiment, tmp_path: Path) -> None:
    written = experiment.runs[1].recording
    write_recording(tmp_path / "b.csv", written)
    read = read_recording(tmp_path / "b.csv", RX90)
    for name in ("t", "q", "torque"):
        assert np.allclose(getattr(read, name), getattr(written, name), rtol=1e-11, atol=1e-11)
    assert read.gain_sigma == written.gain_sigma == LEVELS.gain_error
    assert read.notes == ()


def test_the_truth_is_whole(experiment: Experiment, tmp_path: Path) -> None:
    target = tmp_path / "truth.toml"
    write_truth(target, experiment, Controller(), ["a.csv", "b.csv"], {"dynident": "1"})
    truth = tomllib.loads(target.read_text())
    assert truth["parameters"] == dict(RX90.parameters)
    assert truth["seed"] == 3
    assert truth["versions"] == {"dynident": "1"}
    assert truth["drawn"]["drive_gains"] == experiment.gains.tolist()
    assert tuple(truth["disturbances"]["white"]) == LEVELS.white
    assert truth["controller"]["position"] == Controller().position
    files = [run["file"] for run in truth["runs"]]
    assert files == ["a.csv", "b.csv"]
    assert [run["payload"] for run in truth["runs"]] == [False, True]
    assert truth["runs"][0]["mean_friction"] == experiment.runs[0].friction
    # The payload of the truth can be simulated again.
    assert np.allclose(read_payload(target).vector, PAYLOAD.vector)
    assert isinstance(read_payload(target), InertialParameters)
