"""Inputs in the working folder; searches and experiments of a moment."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.commands import simulate as demo
from dynident.tests.commands.lines import inputs_of_all_lines
from dynident.trajectories.design import goal, search


@pytest.fixture(scope="session")
def experiments() -> dict[str, Any]:
    """The paper's experiments that were simulated, and one answer to them, by what they were made of."""
    return {}


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch, experiments: dict[str, Any]) -> None:
    """Laws on options and files hold whatever is found: searches of a few steps, one answer to all experiments."""
    monkeypatch.setattr(search, "_FLOOR_ITERATIONS", 10)
    choose_effort = search._Search.__post_init__

    def few_steps(own: Any) -> None:
        choose_effort(own)
        own.first, own.refined, own.settled, own.stages, own.turns = 8, 4, 4, 1, 1

    monkeypatch.setattr(search._Search, "__post_init__", few_steps)
    for name in ("_GLANCES", "_LOOKS", "_FEW"):
        monkeypatch.setattr(goal, name, 1)
    simulate, identify = demo.simulate_paper, demo.identified

    def simulated(*arguments: Any) -> Any:
        key = repr(arguments[1:4])
        if key not in experiments:
            experiments[key] = simulate(*arguments)
        return experiments[key]

    def identified(experiment: Any, progress: Any) -> Any:
        if "answer" not in experiments:
            exact = simulate(experiment.robot, demo.levels(experiment.robot, "none"), 0, 2)
            experiments["answer"] = identify(exact, progress)
        return experiments["answer"]

    monkeypatch.setattr(demo, "simulate_paper", simulated)
    monkeypatch.setattr(demo, "identified", identified)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """Inputs of a line for each command, in the working folder."""
    with inputs_of_all_lines() as place:
        yield place
