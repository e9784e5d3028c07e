"""The page of operation counts says what the code does."""

import runpy
from dataclasses import replace
from pathlib import Path

from dynident.model import base_parameters, base_regressor, inverse_dynamics_base, load_robot

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "benchmarks" / "operation_counts.py"))


def test_page_shows_the_computed_tables() -> None:
    page = (ROOT / "docs" / "operation_counts.md").read_text(encoding="utf-8")
    first, second = SCRIPT["tables"]()
    assert first in page
    assert second in page


def test_fewer_operations_than_symoro() -> None:
    for row, (multiplications, additions) in zip(SCRIPT["rigid_bodies"](), SCRIPT["SYMORO"].values(), strict=True):
        ours = [int(cell) for cell in row.split("|")[2:6]]
        assert ours[0] < multiplications
        assert ours[1] + ours[2] < additions


def test_counts_do_not_hang_on_the_numbers_of_the_rx90() -> None:
    robot = load_robot("rx90")
    joints = tuple(replace(joint, d=0.9578 * joint.d, r=1.0622 * joint.r) for joint in robot.joints)
    second = replace(robot, joints=joints, gravity=(0.0, 0.0, -9.7))
    for make in (inverse_dynamics_base, base_regressor):
        counts = [SCRIPT["operation_counts"](make(each, base_parameters(each))) for each in (robot, second)]
        assert counts[0] == counts[1]
