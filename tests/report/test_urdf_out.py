"""URDF out: Pinocchio and MuJoCo read the same robot back, with equal torques."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Estimate
from dynident.estimation.fit import Fit
from dynident.estimation.possible import Gauge, cylinder_prior, origins, robot_origins, solve_constrained_prior
from dynident.estimation.possible.origin import BODY_NUMBERS
from dynident.model import (
    INERTIAL,
    Drives,
    InertialParameters,
    Pose,
    Robot,
    base_parameters,
    base_regressor,
    inverse_dynamics,
    load_robot,
    standard_columns,
    with_tool,
)
from dynident.model.base.rank import random_states
from dynident.report.urdf import robot_urdf
from dynident.tests.model.urdf_files import dressed_urdf

GAUGE = "all links by a table."
RandomBodies = Callable[[int, int], list[InertialParameters]]
RandomParameters = Callable[[Robot, int], dict[str, float]]


def rigid(robot: Robot) -> Robot:
    return replace(robot, drives=Drives(rotor_inertia=False, friction=False))


def torques(robot: Robot, parameters: dict[str, float], states: tuple[Array, ...]) -> Array:
    chi = np.array([parameters[name] for name in standard_columns(robot)])
    function = inverse_dynamics(robot)
    return np.array([np.array(function(*state, chi)).ravel() for state in zip(*states, strict=True)])


def by_pinocchio(text: str, states: tuple[Array, ...]) -> Array:
    model = pin.buildModelFromXML(text)
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(*states, strict=True)])


def by_mujoco(text: str, states: tuple[Array, ...]) -> Array:
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    rows = []
    for state in zip(*states, strict=True):
        data.qpos, data.qvel, data.qacc = state
        mujoco.mj_inverse(model, data)
        rows.append(data.qfrc_inverse.copy())
    return np.array(rows)


READERS = {"pinocchio": by_pinocchio, "mujoco": by_mujoco}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("name", ["rx90", "kr6_r900", "panda", "tx2_90"])
def test_whole_robot_and_payload(
    name: str,
    reader: str,
    random_parameters: RandomParameters,
    random_bodies: RandomBodies,
) -> None:
    robot = rigid(with_tool(load_robot(name), Pose.from_rpy((0.02, 0.0, 0.1), (0.3, -0.5, 1.0)), "tool"))
    values, payload = random_parameters(robot, 3), random_bodies(1, 5)[0]
    on_link = payload.moved(robot.flange.R, robot.flange.p).named(str(robot.n))
    loaded = values | {key: values[key] + value for key, value in on_link.items()}
    states = random_states(robot, 20, seed=2)
    expected = torques(robot, loaded, states)
    text = robot_urdf(robot, values, GAUGE, payload)
    np.testing.assert_allclose(READERS[reader](text, states), expected, atol=1e-9 * np.abs(expected).max())
    assert GAUGE in text


@pytest.mark.parametrize("reader", READERS)
def test_a_urdf_comes_back_in_its_own_frames(reader: str, tmp_path: Path) -> None:
    """Read, written and read again: same links, joints and flange, equal torques."""
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
    robot = rigid(load_robot(path))
    text = robot_urdf(robot, robot.parameters, GAUGE)
    path.write_text(text, encoding="utf-8")
    again = rigid(load_robot(path))
    assert again.links is not None
    assert robot.links is not None
    assert (again.links.names, again.links.joints, again.links.tip) == (
        robot.links.names, robot.links.joints, robot.links.tip
    )  # fmt: skip
    np.testing.assert_allclose(again.flange.R, robot.flange.R, atol=1e-12)
    np.testing.assert_allclose(again.flange.p, robot.flange.p, atol=1e-9)
    assert [joint.limits for joint in again.joints] == [joint.limits for joint in robot.joints]
    states = random_states(robot, 20, seed=2)
    expected = torques(robot, dict(robot.parameters), states)
    np.testing.assert_allclose(READERS[reader](text, states), expected, atol=1e-9 * np.abs(expected).max())


def test_friction_and_what_has_no_place(rx90: Robot) -> None:
    text = robot_urdf(rx90, rx90.parameters, "a -- b <c>")
    model = pin.buildModelFromXML(text)
    assert '<dynamics damping="29.3" friction="21.7"/>' in text
    assert "IA1 = 4.00019851" in text
    assert "a - - b &lt;c&gt;" in text
    assert model.effortLimit.tolist() == [joint.limits.torque for joint in rx90.joints]
    assert model.velocityLimit[0] == pytest.approx(np.radians(236))


@pytest.mark.parametrize("gauge", ["base", "prior"])
@pytest.mark.parametrize("name", ["rx90", "kr6_r900"])
def test_a_labelled_robot_has_the_torques_that_were_identified(
    name: str, gauge: Gauge, random_parameters: RandomParameters
) -> None:
    """The base parameters' torques, less drives that URDF has no place for; labels beside every link."""
    robot = load_robot(name)
    base = base_parameters(robot)
    chi = base.value(random_parameters(robot, 6))
    sigma = 0.2 * (np.abs(chi) + 0.1)
    off = chi + sigma * np.random.default_rng(6).standard_normal(len(chi))
    estimate = Estimate(base.columns, off, np.diag(sigma**2), np.inf, Fit(np.ones(1), np.ones(1), (1,)), np.ones(1))
    found = solve_constrained_prior(robot, base, estimate, cylinder_prior(robot, 50.0))
    values, parameters = (
        (found.values, found.parameters) if gauge == "prior" else (found.nearest.values, found.nearest.parameters)
    )
    told = robot_origins(robot, base, parameters, gauge)
    text = robot_urdf(robot, parameters, GAUGE, None, told)
    states = random_states(robot, 20, seed=2)
    function = base_regressor(robot, base)
    expected = np.array([np.array(function(*state)) @ values for state in zip(*states, strict=True)])
    ten = {f"{kind}{j}" for kind in INERTIAL for j in range(1, robot.n + 1)}
    drives = torques(robot, {k: 0.0 if k in ten else v for k, v in parameters.items()}, states)
    rigid_text = "".join(line for line in text.splitlines(keepends=True) if "<dynamics " not in line)
    assert rigid_text.count("\n") == text.count("\n") - robot.n
    for reader in READERS.values():
        np.testing.assert_allclose(
            reader(rigid_text, states) + drives, expected, atol=1e-7 * np.abs(expected).max()
        )
    read = labels_of(text)
    assert [name for name, _ in read] == [f"link{j}" for j in range(1, 7)]
    own = origins(robot, base)
    alone = {"base": "convention", "prior": "prior"}[gauge]
    words = {"identified": "data", "combination": "combination", "prior": alone}
    model = pin.buildModelFromXML(text)
    for j, (_, lines) in enumerate(read, start=1):
        mass, *place = (float(lines[key][0]) for key in ("mass", "x", "y", "z"))
        assert mass == pytest.approx(model.inertias[j].mass, rel=1e-12)
        np.testing.assert_allclose(model.inertias[j].lever, place, atol=1e-12)
        body = InertialParameters.from_com(mass, place, model.inertias[j].inertia)
        assert body.min_pseudo_inertia_eigenvalue > (0.0 if gauge == "prior" else -1e-9)
        for key in (key for key in lines if key in own):
            value, who, share, part_of = lines[key]
            assert (float(value), who) == (parameters[key], words[own[key].kind])
            assert float(share) == pytest.approx(own[key].share, abs=1e-3)
            assert part_of == (",".join(own[key].base) or "none")
    assert {key for _, lines in read for key in lines} == set(base.standard) | set(BODY_NUMBERS)
    assert f"Base parameters: {'; '.join(base.groupings())}." in text


def labels_of(text: str) -> list[tuple[str, dict[str, list[str]]]]:
    """Lines of the comments beside the links, as a program of the user would read them."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    found = []
    for link in ElementTree.fromstring(text, parser).iter("link"):
        lines = [
            line.split() for part in link if not isinstance(part.tag, str) for line in str(part.text).splitlines()
        ]
        if lines:
            found.append((link.get("name", ""), {words[0]: words[1:] for words in lines if len(words) == 5}))
    return found


def test_prismatic_joints(prismatic: dict[str, Robot], random_parameters: RandomParameters) -> None:
    for arm in prismatic.values():
        robot = replace(rigid(arm), gravity=(0.0, 0.0, -9.81))
        values = random_parameters(robot, 4)
        model = pin.buildModelFromXML(robot_urdf(robot, values, GAUGE))
        data = model.createData()
        for q, qd, qdd in zip(*random_states(robot, 5, seed=2), strict=True):
            place = np.concatenate([[np.cos(x), np.sin(x)] if j.revolute else [x]
                                    for x, j in zip(q, robot.joints, strict=True)])  # fmt: skip
            expected = torques(robot, values, (q[None], qd[None], qdd[None]))[0]
            theirs = pin.rnea(model, data, place, qd, qdd)
            np.testing.assert_allclose(theirs, expected, atol=1e-9 * np.abs(expected).max())


def test_links_without_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="no XX1"):
        robot_urdf(load_robot("ur5e"), {}, GAUGE)
