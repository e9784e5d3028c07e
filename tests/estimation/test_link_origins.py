"""Who decides the numbers of a link: told by what changes that no motion shows do to them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.whole_robot import BODY_NUMBERS, WholeRobot, origins, whole_robot
from dynident.model import INERTIAL, BaseParameters, Robot, base_parameters, load_robot
from dynident.model.frames import bodies_in_link_frames
from dynident.tests.model.urdf_files import dressed_urdf

Parameters = Callable[[Robot, int], dict[str, float]]


def exact(base: BaseParameters, values: dict[str, float], sigma: float = 0.1) -> Estimate:
    """Base parameters as they are, each with the same standard deviation."""
    C, unit = sigma**2 * np.eye(len(base.columns)), np.ones(1)
    return Estimate(base.columns, base.value(values), C, np.inf, Fit(unit, unit, (1,)), unit)


def numbers(robot: Robot, names: tuple[str, ...], x: Array) -> Array:
    """All links' body numbers, one after the other."""
    values = []
    for body in bodies_in_link_frames(robot, dict(zip(names, x.tolist(), strict=True))).values():
        values += [body.mass, *body.com, *body.inertia_com[np.triu_indices(3)]]
    return np.array(values)


def check(robot: Robot, values: dict[str, float]) -> WholeRobot:
    """Labels against differences of the numbers themselves along every hidden direction and parameter."""
    base = base_parameters(robot)
    x = np.array([values[name] for name in base.standard])
    result = whole_robot(robot, values, "a table", base, exact(base, values))
    labels = [label for link in result.links for label in link.numbers.values()]
    np.testing.assert_allclose([label.value for label in labels], numbers(robot, base.standard, x), rtol=1e-12)

    def differences(directions: Array) -> Array:
        step = 1e-6
        ends = [[numbers(robot, base.standard, x + s * v) for s in (step, -step)] for v in directions]
        return np.array([(high - low) / (2.0 * step) for high, low in ends]).T

    hidden = np.linalg.svd(base.grouping)[2][len(base.chosen) :]
    by_hidden, by_one = np.abs(differences(hidden)).max(axis=1), differences(np.eye(len(x)))
    largest = np.abs(by_one).max(axis=1)
    for label, moved, gradient, size in zip(labels, by_hidden, by_one, largest, strict=True):
        part = {
            base.names[i] for i in np.flatnonzero(np.abs(base.grouping[:, np.abs(gradient) > 1e-7 * size]).any(1))
        }
        assert set(label.origin.base) == part
        assert (label.origin.kind == "prior") == (not part)
        assert (label.origin.kind == "identified") == (moved < 1e-7 * size)
        assert (label.origin.share == 1.0) == (label.origin.kind == "identified")
    by_base = differences(np.asarray(np.linalg.pinv(base.grouping).T, dtype=float))
    for label, slopes in zip(labels, by_base, strict=True):
        assert (label.sigma is None) == (label.origin.kind != "identified")
        if label.sigma is not None and label.interval is not None:
            assert label.sigma == pytest.approx(0.1 * np.linalg.norm(slopes), rel=1e-5, abs=1e-12)
            assert np.subtract(label.interval, label.value) == pytest.approx(
                [-1.96 * label.sigma, 1.96 * label.sigma], rel=1e-3, abs=1e-9
            )
    own = origins(robot, base)
    by_name = {name: label for link in result.links for name, label in link.parameters.items()}
    assert {name: label.origin for name, label in by_name.items()} == own
    assert {name: label.value for name, label in by_name.items()} == values
    return result


def test_every_kind_of_robot(robot: Robot, random_parameters: Parameters) -> None:
    result = check(robot, random_parameters(robot, 2))
    assert all(tuple(link.numbers) == BODY_NUMBERS for link in result.links)
    kinds = {label.origin.kind for link in result.links for label in link.numbers.values()}
    assert "combination" in kinds


def test_in_the_frames_of_a_urdf(tmp_path: Path, random_parameters: Parameters) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
    robot = load_robot(path)
    assert robot.links is not None
    result = check(robot, random_parameters(robot, 4))
    assert [link.link for link in result.links] == list(robot.links.names)


def test_a_link_without_mass_has_no_more(rx90: Robot, random_parameters: Parameters) -> None:
    values = random_parameters(rx90, 1) | {f"{kind}1": 0.0 for kind in INERTIAL}
    base = base_parameters(rx90)
    result = whole_robot(rx90, values, "a table", base, exact(base, values))
    assert tuple(result.links[0].numbers) == ("mass",)
    assert result.links[0].numbers["mass"].value == 0.0
    assert result.groupings[0].startswith("ZZ1R = ZZ1 + IA1")
