"""A passport: its answer by itself, every byte guarded, merged as reduced together, refused where it differs."""

import contextlib
import json
import random
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps import fleet
from dynident.apps.fleet import Log, Passport, Recipe, RobotPassport
from dynident.apps.fleet.answers import free_estimate, numbers_of
from dynident.apps.logs.read import read_recording
from dynident.apps.report.documents import identification_document, payload_document
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.common.schema import json_text
from dynident.estimation import Identification, identify
from dynident.model import load_robot
from dynident.tests.frozen.inputs import unpack

ARM = "--robot rx90 --unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv"
NEAR = "--robot rx90 --unloaded rx_near_unloaded.csv --loaded rx_near_loaded.csv"
KNOWN = "--robot tx40 --decimate 8 --robot-parameters tx_robot.json --loaded tx_arm_loaded.csv"
HELD_OUT = "--validate rx_near_unloaded.csv"
QUICK = {
    "identify": f"identify --robot rx90 --data rx_arm_unloaded.csv {HELD_OUT} --gain-sigma 2%",
    "payload": f"payload {ARM} {HELD_OUT}",
    "weigh": f"weigh {NEAR}",
}
LINES = QUICK | {
    "not to be used": "identify --robot rx90 --data rx_arm_loaded.csv --signs=1,-1,1,1,1,1",
    "ratio": "identify --robot rx90 --data rx_arm_unloaded.csv --essential-ratio 1.2",
    "elastic": "identify --robot tx40 --data tx_arm_unloaded.csv --decimate 8 --offsets",
    "six axes": "identify --robot six_axis.toml --data six_arm_unloaded.csv",
    "currents": "identify --robot ur10e --data ur_currents_unloaded.csv --drive-gains 12,12,10,11,11,11",
    "swapped": "payload --robot rx90 --loaded rx_arm_unloaded.csv --unloaded rx_arm_loaded.csv",
    "wrong sign": f"payload {ARM} --signs=1,1,-1,1,1,1",
    "constrained": f"payload {ARM} --mass-min 6.5 --com-within=0.02,0.03,0,0.01,0.1,0.2",
    "ellipsoid": f"payload {ARM} --ellipsoid=0,0,0.1,0.1,0.1,0.1 --gain-sigma-common 1%",
    "scale": f"payload {ARM} --method 4 --scale-sigma 2%",
    "friction": f"payload {ARM} --method 1 --free-friction",
    "stored": f"payload {KNOWN} --method 1",
    "stored pair": f"payload {KNOWN} --unloaded tx_arm_unloaded.csv --friction-change 10%",
    "weigh stored": f"weigh {KNOWN}",
    "weigh both": f"weigh {KNOWN} --unloaded tx_arm_unloaded.csv --mass 1.6 --mass-sigma 0.05",
    "stand-in": f"weigh {NEAR} --inertia box:200x200x100 --moving 2,3,5,6",
    "tool frame": f"payload {ARM} --tool-frame 0,0,0.05,0,0,30 --mount wall",
}
"""A command of each kind, with what decides its answer beside the logs."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("passports")
    unpack(place)
    with contextlib.chdir(place):
        yield place


@pytest.fixture(scope="module")
def robots(folder: Path) -> list[RobotPassport]:
    """Two passports of one robot, of logs that hold the same numbers under two names."""
    robot = load_robot("rx90")
    result, recipe = (
        identify(robot, [read_recording("rx_arm_unloaded.csv", robot)]),
        Recipe("identify", robot.processing),
    )
    logs = [Log("without payload", f"{name}.csv", f"{k}" * 64) for k, name in enumerate(("monday", "tuesday"))]
    return [fleet.robot_passport(result, recipe, [log]) for log in logs]


def numbers(tree: object, path: str = "") -> dict[str, float]:
    """Every number of a document by its place."""
    if isinstance(tree, dict):
        return {key: x for name, below in tree.items() for key, x in numbers(below, f"{path}.{name}").items()}
    if isinstance(tree, list):
        return {key: x for k, below in enumerate(tree) for key, x in numbers(below, f"{path}[{k}]").items()}
    return {path: float(tree)} if isinstance(tree, int | float) else {}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in LINES]
)
def test_the_answer_by_the_passport_alone(name: str, folder: Path) -> None:
    """Value, interval and verdict of the command, again from its passport."""
    status = main([*LINES[name].split(), "--passport", "p.npz", "--json", "p.json", "--quiet"])
    first = json.loads(Path("p.json").read_text())
    Path("p.json").unlink()
    passport = fleet.read_passport("p.npz")
    answer, recipe = fleet.answered(passport), passport.recipe
    document: Any
    if isinstance(answer, Identification):
        document = identification_document(answer, recipe.processing, recipe.drive_gains)
    else:
        document = payload_document(answer, recipe.processing, recipe.drive_gains)
    again = json.loads(json_text(document))
    if isinstance(passport, RobotPassport):  # the nearest robot that can exist is no part of its answer
        first.pop("constrained")
        again.pop("constrained", None)
    assert status == int(answer.verdict.level == "do_not_use")
    assert first.get("verdict", first.get("reasons_against_use")) == again.get(
        "verdict", again.get("reasons_against_use")
    )
    from_passport, theirs = numbers(again), numbers(first)
    of_samples = ("lag", "max_position_mismatch", "gain_sigma.notes")
    assert not [key for key in set(from_passport) ^ set(theirs) if not any(word in key for word in of_samples)]
    shared = [key for key in theirs if key in from_passport]
    assert len(shared) > 100
    apart = {
        key: (from_passport[key], theirs[key])
        for key in shared
        if abs(from_passport[key] - theirs[key]) > 1e-12 + 1e-9 * abs(theirs[key])
    }
    assert not apart


def test_a_passport_comes_back_as_it_was(robots: list[RobotPassport]) -> None:
    content = fleet.passport_bytes(robots[0])
    again = fleet.files.passport_of(content)
    assert again.robot == robots[0].robot
    assert again.recipe == robots[0].recipe
    assert fleet.passport_bytes(again) == content


def test_every_changed_byte_is_noticed(robots: list[RobotPassport]) -> None:
    content, draw = fleet.passport_bytes(robots[0]), random.Random(0)
    for _ in range(200):
        place, change = draw.randrange(len(content)), draw.randrange(1, 256)
        changed = bytearray(content)
        changed[place] ^= change
        with pytest.raises(InputError):
            fleet.files.passport_of(bytes(changed))
    for size in (0, 10, len(content) // 2, len(content) - 1):
        with pytest.raises(InputError):
            fleet.files.passport_of(content[:size])
    with pytest.raises(InputError, match="not as it was written"):
        fleet.files.passport_of(content + b"0")


def test_a_passport_opens_fast(robots: list[RobotPassport], tmp_path: Path) -> None:
    fleet.write_passport(tmp_path / "p.npz", robots[0])
    fleet.read_passport(tmp_path / "p.npz")
    begin = time.process_time()
    fleet.read_passport(tmp_path / "p.npz")
    assert time.process_time() - begin < 0.3


def test_other_recipes_robots_and_arms_do_not_merge(robots: list[RobotPassport]) -> None:
    first, second = robots
    third = replace(second, recipe=Recipe("identify", replace(first.robot.processing, cutoff=3.0)))
    with pytest.raises(InputError, match=r"different recipes \(processing\)"):
        fleet.merged_passports([first, third])
    with pytest.raises(InputError, match="different robots"):
        fleet.merged_passports([first, replace(second, robot=second.robot.with_offsets(True))])
    with pytest.raises(InputError, match=r"of arm 'A', .* of 'B'"):
        fleet.merged_passports([replace(first, about={"arm": "A"}), replace(second, about={"arm": "B"})])
    with pytest.raises(InputError, match="counts once"):
        fleet.merged_passports([first, first])
    with pytest.raises(InputError, match="two or more"):
        fleet.merged_passports([first])


def test_merged_is_reduced_together(folder: Path) -> None:
    """By the same equations; the blocks of time are each recording's own, and with them robust deviations."""
    robot = load_robot("rx90")
    names = ("rx_arm_unloaded.csv", "rx_arm_loaded.csv")
    recordings = [read_recording(name, robot) for name in names]
    passports: list[Passport] = [
        fleet.robot_passport(
            identify(robot, [recording]), Recipe("identify", robot.processing), [Log("without payload", name, name)]
        )
        for name, recording in zip(names, recordings, strict=True)
    ]
    together, pooled = identify(robot, recordings), fleet.answered(fleet.merging.pooled(passports))
    assert isinstance(pooled, Identification)
    free = pooled.estimate
    np.testing.assert_allclose(free.values, together.estimate.values, rtol=1e-9, atol=1e-9 * abs(free.values).max())
    np.testing.assert_allclose(free.sigma, together.estimate.sigma, rtol=1e-9)
    # A payload on the arm is no other day of it: what contradicts is named, with its sigmas.
    with pytest.raises(InputError, match=r"contradict each other: .*M.* by .* ± .* sigma\)"):
        fleet.merged_passports(passports)


def test_what_agrees_merges(robots: list[RobotPassport], tmp_path: Path) -> None:
    first, second = robots
    merged = fleet.merged_passports([first, second])
    assert [log.name for log in merged.logs] == [first.name, second.name]
    alone, both = free_estimate(fleet.answered(first)), free_estimate(fleet.answered(merged))
    np.testing.assert_allclose(both.values, alone.values, rtol=1e-8)
    assert len(numbers_of(fleet.answered(merged))) == len(alone.names)
