"""Inputs with one mistake each: an answer or one line, no half file, no mass wrong in silence."""

import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import load_robot, read_payload
from dynident.tests.mutations.mutants import BYTES, TEXTS
from dynident.tests.mutations.trial import Trial, trials
from dynident.tests.trajectories.test_scene_file import WHOLE
from dynident.trajectories import read_scene

COUNT, SEED = 300, 0
SECONDS = 90.0
"""Of the processor; other work on the machine does not count."""
UNKNOWABLE = {
    "^all recordings: all gains off": "torques that are all larger by one share are those of a heavier arm with "
    "a heavier payload; 8 % are within what the arm's own weight tells",
}
"""Mistakes by which a mass may be wrong in silence, and why nothing in the data can tell."""
ROOT = Path(__file__).parents[2]
FILES: dict[str, tuple[bytes, Callable[[Path], object]]] = {
    "six_axis.toml": ((ROOT / "examples/robots/six_axis.toml").read_bytes(), load_robot),
    "tx40.toml": ((ROOT / "model/robots/tx40.toml").read_bytes(), load_robot),
    "six_axis.urdf": ((ROOT / "examples/robots/six_axis.urdf").read_bytes(), load_robot),
    "gripper.toml": ((ROOT / "examples/gripper.toml").read_bytes(), read_payload),
    "scene.toml": (WHOLE.encode(), read_scene),
}


@pytest.mark.long
def test_three_hundred_mistakes() -> None:
    begun, wrong, statuses = time.process_time(), [], set[int]()
    for trial in trials(COUNT, SEED):
        statuses.add(trial.status)
        if trial.problem and not known(trial):
            wrong.append(f"{trial.mutant.kind}: {trial.problem}: {' '.join(trial.mutant.words)[:200]}")
    assert not wrong, "\n".join(wrong)
    assert statuses == {0, 1, 2}
    assert time.process_time() - begun < SECONDS


def known(trial: Trial) -> bool:
    """Whether it is a wrong mass of a kind that cannot be known."""
    return trial.problem.startswith("silent") and any(re.search(kind, trial.mutant.kind) for kind in UNKNOWABLE)


def numbers(content: bytes, draw: np.random.Generator) -> bytes:
    """One number of a file becomes another."""
    places = list(re.finditer(rb"-?\d+\.?\d*", content))
    place = places[int(draw.integers(len(places)))]
    odd = (b"0", b"-1", b"1e9", b"1e300", b"nan", b"inf", b"x", b"", b"1e-300", b"1e400", b"-5")
    return content[: place.start()] + odd[int(draw.integers(len(odd)))] + content[place.end() :]


@pytest.mark.parametrize("name", FILES)
def test_a_file_with_a_mistake_is_read_or_refused_in_a_line(name: str, tmp_path: Path) -> None:
    good, read = FILES[name]
    changes = [*BYTES.values(), *(() if name.endswith(".urdf") else TEXTS.values()), numbers, numbers]
    lines = []
    for k in range(80):
        draw = np.random.default_rng([SEED, k])
        (tmp_path / name).write_bytes(changes[k % len(changes)](good, draw))
        try:
            read(tmp_path / name)
        except InputError as error:
            lines.append(str(error))
    assert len(lines) > 40
    assert all("\n" not in line and len(line) < 1000 for line in lines)
