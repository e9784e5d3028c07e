"""Base parameters: by rules against the paper, published robots, local transfers and QR; laws of every robot."""

import re
from dataclasses import replace
from math import radians
from pathlib import Path
from string import ascii_letters

import numpy as np
import pytest
from dynident import model
from dynident.common.errors import InputError
from dynident.model import base as base_module
from dynident.model.base import BaseParameters, leftmost_independent, random_states, stacked_regressor
from dynident.model.regressors import payload_columns
from dynident.tests.model.random_robots import random_robot, small_robots
from dynident.tests.model.three_ways import Comparison, compare, local_transfer_base_parameters

KNOWN = Path(__file__).parents[1] / "reference" / "robots"
NUMBERS = {"stanford": (37, 33), "iiwa14": (48, 43), "cobra600": (11, 8), "puma560": (40, 36), "panda": (48, 43)}
"""Base inertial parameters with and without rotor inertias. Panda: 43 in Gaz et al., RA-L 2019."""
SHIPPED = {"rx90": (40, 36), "tx40": (40, 36), "ur10e": (40, 36)}


PAPER = (KNOWN.parent / "khalil_rx90_groupings.txt").read_text(encoding="utf-8").splitlines()
"""The relations (12) of the RX90 and the list of section II.D."""


def rx90_eliminated() -> set[str]:
    """Standard inertial parameters that section II.D leaves out of the base parameters."""
    (line,) = (line for line in PAPER if "Not among the base parameters" in line)
    named = line.split(": ")[1].rstrip(".")
    every_link = [f"{kind}{j}" for kind in re.findall(r"([A-Z]+)j", named) for j in range(1, 7)]
    return {*every_link, *re.findall(r"[A-Z]+\d", named)}


def serial(name: str) -> model.Robot:
    """A shipped or a known robot without the coupling of its drives."""
    robot = model.load_robot(name if name in SHIPPED else KNOWN / f"{name}.toml")
    return replace(robot, drives=replace(robot.drives, coupling=None))


def tilted() -> model.Robot:
    """A robot of general angles, its second joint a slide, one length used four times."""
    turn, slide = (
        model.Joint(kind, radians(35), 0.2, radians(20), 0.3, names=("D", "R"))
        for kind in ("revolute", "prismatic")
    )
    return model.Robot("tilted", (turn, slide, turn, turn), (1.0, 2.0, -9.0))


def grouped(base: BaseParameters) -> tuple[str, ...]:
    return tuple(text for text in base.groupings(symbolic=True) if text.split(" = ")[0].endswith("R"))


def check(comparison: Comparison) -> None:
    assert comparison.names
    assert comparison.grouping < 1e-6
    assert comparison.model < 1e-10
    assert comparison.accepted > 1e6 * comparison.rejected


@pytest.mark.parametrize("robot", [serial("rx90"), model.load_robot("rx90")], ids=["serial", "coupled"])
def test_relations_of_the_paper(robot: model.Robot) -> None:
    """The text of (12), relation by relation, and the list of section II.D."""
    base = model.closed_form_base_parameters(robot)
    relations = [line for line in PAPER if " = " in line and not line.startswith("#")]
    closed = [re.sub(r"\([^)]*\)", lambda bracket: bracket[0].replace(" ", ""), line) for line in relations]
    assert grouped(base) == tuple(re.sub(r"\s*\*\s*", "*", line) for line in closed)
    assert {name for name in base.eliminated if name[:2] not in ("FS", "FV")} == rx90_eliminated()


@pytest.mark.parametrize("name", [*SHIPPED, *NUMBERS])
def test_known_robots(name: str) -> None:
    robot = serial(name)
    check(compare(robot))
    for rotors, number in zip((True, False), (SHIPPED | NUMBERS)[name], strict=True):
        drives = model.Drives(rotor_inertia=rotors, friction=())
        assert len(model.closed_form_base_parameters(replace(robot, drives=drives)).columns) == number


@pytest.mark.parametrize("name", [*SHIPPED, *NUMBERS, "tilted"])
def test_text_is_the_grouping(name: str) -> None:
    """The symbolic text, evaluated with the robot's lengths, is the numeric grouping."""
    robot = tilted() if name == "tilted" else serial(name)
    base = model.closed_form_base_parameters(robot)
    lengths = {n: v for j in robot.joints for n, v in zip(j.names, (j.d, j.r), strict=True) if n}
    for text, row in zip(base.expressions, base.grouping, strict=True):
        for k, factor in enumerate(row):
            parameters = {column: float(k == place) for place, column in enumerate(base.standard)}
            value = eval(text.replace("^", "**"), {}, lengths | parameters)
            assert value == pytest.approx(factor, rel=1e-5, abs=1e-9)


@pytest.mark.long
def test_random_robots() -> None:
    """Rules, local transfers and QR: same names, same order, same groupings, every rule met."""
    comparisons = [compare(random_robot(seed)) for seed in range(200)]
    for comparison in comparisons:
        check(comparison)
    assert min(comparison.accepted for comparison in comparisons) > 1e6 * max(
        comparison.rejected for comparison in comparisons
    )
    assert len(set().union(*(comparison.rules for comparison in comparisons))) == 16


@pytest.mark.long
def test_small_robots() -> None:
    """Every eleventh of the grid of one and two joints."""
    robots = list(small_robots())[::11]
    assert len(robots) > 400
    for robot in robots:
        check(compare(robot))


def test_without_gravity() -> None:
    for seed in range(40):
        robot = replace(random_robot(seed), gravity=(0.0, 0.0, 0.0))
        check(compare(robot))
        with pytest.raises(InputError, match="use base_parameters"):
            model.closed_form_base_parameters(robot)


def test_prismatic_rotor_beyond_the_first_joint() -> None:
    """The counter-example of base.py: a rule for j = 1 only would keep four parameters."""
    joints = (model.Joint("prismatic"), model.Joint("prismatic", alpha=radians(90)))
    base = model.closed_form_base_parameters(model.Robot("two slides", joints, drives=model.Drives(friction=())))
    assert base.groupings(symbolic=True) == ("M1R = -IA2 + M1", "IA1 = IA1", "M2R = IA2 + M2")
    assert base.unidentifiable == base.standard[:9] + base.standard[11:20]
    check(compare(model.Robot("two slides", joints)))


def coupled(robot: model.Robot, j: int, k: int) -> model.Robot:
    return replace(robot, drives=model.Drives(coupling=model.Coupling((j, k))))


TURN, FOLD = model.Joint(d=0.3), model.Joint(alpha=radians(-90))
PLANAR = model.Robot("planar", (model.Joint(), FOLD, TURN, TURN))
SMALL = [
    robot for robot in map(random_robot, range(40)) if 2 < robot.n < 6 and all(j.revolute for j in robot.joints)
]


@pytest.mark.parametrize(
    "robot",
    [
        *map(model.load_robot, ("rx90", "tx40")),
        *(coupled(PLANAR, j, k) for j, k in ((1, 2), (2, 3), (3, 4), (4, 3), (1, 3))),
        coupled(model.Robot("flat", (TURN, TURN, FOLD)), 1, 2),
        *(coupled(robot, j, j + 1) for robot in SMALL for j in range(1, robot.n)),
    ],
    ids=lambda robot: f"{robot.name} {robot.coupling.joints}",
)
def test_coupled_drives_by_rules_and_by_rank(robot: model.Robot) -> None:
    rules, rank = model.closed_form_base_parameters(robot), model.base_parameters(robot)
    assert (rules.decided_by, rank.decided_by) == ("closed form", "QR")
    assert rules.names == rank.names
    assert rules.grouping == pytest.approx(rank.grouping, abs=1e-6)


@pytest.mark.parametrize("pair", [(2, 1), (3, 2)])
def test_coupled_drives_that_no_rule_covers(pair: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="no rule covers: use base_parameters"):
        model.closed_form_base_parameters(coupled(PLANAR, *pair))


def test_a_broken_rule_is_seen_by_rank(monkeypatch: pytest.MonkeyPatch) -> None:
    robot, whole = model.load_robot("rx90"), base_module.moves(model.load_robot("rx90"))
    with pytest.raises(InputError, match="coupled drives"):
        local_transfer_base_parameters(robot)
    for rule in {name for name, *_ in whole}:
        monkeypatch.setattr(base_module, "moves", lambda _, rule=rule: [m for m in whole if m[0] != rule])
        assert model.closed_form_base_parameters(robot).columns != model.base_parameters(robot).columns


def test_nearly_vertical_gravity_is_snapped() -> None:
    """Else axis 1 would be almost along gravity, and MX1 and MY1 neither visible nor invisible."""
    robot = model.Robot("level", (model.Joint(), model.Joint(alpha=radians(90))), gravity=(0.0, 1e-5, -9.81))
    assert robot.gravity == (0.0, 0.0, -9.81)
    assert "gravity along y: 1e-05 taken as 0" in robot.snapped
    check(compare(robot))


def test_grouped_regressor(robot: model.Robot) -> None:
    """W_s = W_base G on states that played no part in finding G."""
    base = model.base_parameters(robot)
    W = stacked_regressor(robot, *random_states(robot, 100, seed=99))
    rebuilt = W[:, base.chosen] @ base.grouping
    assert np.abs(rebuilt - W).max() <= 1e-10 * np.abs(W).max()
    assert np.linalg.matrix_rank(W) == len(base.columns)


def test_payload_is_determined(shipped: model.Robot) -> None:
    """Method 2 can find all ten: the map from the payload to base parameters has rank 10."""
    base = model.base_parameters(shipped)
    effect = base.effect_of(payload_columns(shipped))
    sizes = np.linalg.svd(effect, compute_uv=False)
    assert effect.shape == (len(base.columns), 10)
    assert sizes[-1] > 1e-2 * sizes[0]


def test_leftmost_columns_are_chosen() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 20))
    W = np.column_stack([np.zeros(20), a, -3.0 * a, b, a + b, 1e-12 * np.arange(20.0)])
    assert leftmost_independent(W) == [1, 3]
    assert leftmost_independent(np.zeros((4, 3))) == []
    assert leftmost_independent(np.eye(2, 5) + 1.0) == [0, 1]


def test_choice_does_not_hang_on_rounding() -> None:
    """Powers of x are nearly dependent: orthogonalised once, their sum would seem to be something new."""
    powers = np.linspace(0.0, 1.0, 50)[:, None] ** np.arange(11)
    W = np.column_stack([powers, powers.sum(axis=1)])
    assert leftmost_independent(W) == list(range(11))


def test_joints_do_not_feel_links_before_them(robot: model.Robot) -> None:
    rows, columns = model.standard_regressor(robot).sparsity_out(0).get_triplet()
    links = [int(name.lstrip(ascii_letters)) for name in model.standard_columns(robot)]
    assert all(row + 1 <= links[column] for row, column in zip(rows, columns, strict=True))
