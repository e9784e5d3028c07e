"""Whole robots: simulators read the same numbers back, MuJoCo moves them as the model says, a user's model too."""

import difflib
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from dynident.apps.export.own_model import into
from dynident.apps.export.simulators import FORMATS
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.whole_robot import (
    BODY_NUMBERS,
    WholeRobot,
    robot_prior,
    solve_constrained_prior,
    whole_robot,
)
from dynident.model import (
    Drives,
    Robot,
    Spring,
    base_parameters,
    inverse_dynamics,
    load_robot,
    robot_names,
    standard_columns,
    with_stand_in,
)
from dynident.model.base import random_states
from dynident.tests.model.urdf_files import dressed_urdf
from scipy.spatial.transform import Rotation


class Body(NamedTuple):
    """Mass [kg], centre of mass [m], inertia there in the link's axes [kg m^2]."""

    mass: float
    com: Array
    inertia: Array


class Read(NamedTuple):
    """A robot in a simulator; ``drives``: numbers of each joint by their names."""

    bodies: dict[str, Body]
    drives: dict[str, dict[str, float]]


def by_mujoco(text: str) -> Read:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    bodies = {}
    for k in range(1, model.nbody):
        nine = np.zeros(9)
        mujoco.mju_quat2Mat(nine, model.body_iquat[k])
        R = nine.reshape(3, 3)
        inertia = R @ np.diag(model.body_inertia[k]) @ R.T
        bodies[model.body(k).name] = Body(float(model.body_mass[k]), model.body_ipos[k].copy(), inertia)
    drives = {}
    for k in range(model.njnt):
        joint, dof = model.joint(k), model.jnt_dofadr[k]
        drives[joint.name] = {
            "armature": float(model.dof_armature[dof]),
            "damping": float(np.ravel(model.dof_damping[dof])[0]),
            "friction": float(model.dof_frictionloss[dof]),
        } | ({"low": float(joint.range[0]), "high": float(joint.range[1])} if model.jnt_limited[k] else {})
    for k in range(model.nu):
        limited = bool(model.actuator_ctrllimited[k])
        name = model.joint(int(model.actuator_trnid[k, 0])).name
        drives[name] |= {"torque": float(model.actuator_ctrlrange[k, 1])} if limited else {}
        drives[name]["offset"] = -float(model.actuator_biasprm[k, 0])
    return Read(bodies, drives)


def by_drake(text: str, kind: str) -> Read:
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.001)
    (instance,) = Parser(plant).AddModelsFromString(text, kind)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    bodies, drives = {}, {}
    for index in plant.GetBodyIndices(instance):
        body = plant.get_body(index)
        spatial = body.CalcSpatialInertiaInBodyFrame(context)
        inertia = spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        bodies[body.name()] = Body(
            spatial.get_mass(), np.asarray(spatial.get_com(), dtype=float), np.asarray(inertia, dtype=float)
        )
    for number in plant.GetJointActuatorIndices(instance):
        actuator = plant.get_joint_actuator(number)
        joint = actuator.joint()
        drives[joint.name()] = {
            "armature": actuator.calc_reflected_inertia(context),
            "torque": actuator.effort_limit(),
            "damping": joint.default_damping_vector()[0],
            "low": joint.position_lower_limits()[0],
            "high": joint.position_upper_limits()[0],
            "speed": joint.velocity_upper_limits()[0],
            "acceleration": joint.acceleration_upper_limits()[0],
        }
    return Read(bodies, {name: {k: v for k, v in d.items() if math.isfinite(v)} for name, d in drives.items()})


def by_pinocchio(text: str) -> Read:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(text)
    bodies, drives = {}, {}
    for k in range(1, model.njoints):
        spatial = model.inertias[k]
        name = model.names[k]
        bodies[name] = Body(spatial.mass, spatial.lever.copy(), spatial.inertia.copy())
        place, v = model.joints[k].idx_q, model.joints[k].idx_v
        drives[name] = {
            "speed": model.velocityLimit[v],
            "torque": model.effortLimit[v],
            "damping": model.damping[v],
            "friction": model.friction[v] if hasattr(model, "friction") else model.upperDryFrictionLimit[v],
        }
        if model.joints[k].nq == 1:
            drives[name] |= {"low": model.lowerPositionLimit[place], "high": model.upperPositionLimit[place]}
    return Read(bodies, drives)


def by_usd(text: str, folder: Path) -> Read:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdPhysics

    path = folder / "robot.usda"
    path.write_text(text, encoding="utf-8")
    stage = Usd.Stage.Open(str(path))
    bodies, drives = {}, {}
    for prim in stage.Traverse():
        custom = prim.GetCustomDataByKey("dynident")
        if prim.HasAPI(UsdPhysics.MassAPI):
            mass = UsdPhysics.MassAPI(prim)
            q = mass.GetPrincipalAxesAttr().Get()
            R = Rotation.from_quat([*q.GetImaginary(), q.GetReal()]).as_matrix()
            inertia = R @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ R.T
            com = np.array(mass.GetCenterOfMassAttr().Get())
            bodies[custom["name"]] = Body(mass.GetMassAttr().Get(), com, inertia)
        elif prim.IsA(UsdPhysics.RevoluteJoint) or prim.IsA(UsdPhysics.PrismaticJoint):
            axis, unit = ("angular", math.pi / 180.0) if prim.IsA(UsdPhysics.RevoluteJoint) else ("linear", 1.0)
            own = f"physxJointAxis:{axis}"
            scaled = {
                "low": ("physics:lowerLimit", unit),
                "high": ("physics:upperLimit", unit),
                "speed": (f"{own}:maxJointVelocity", unit),
                "torque": (f"drive:{axis}:physics:maxForce", 1.0),
                "armature": (f"{own}:armature", 1.0),
                "friction": (f"{own}:dynamicFrictionEffort", 1.0),
                "damping": (f"{own}:viscousFrictionCoefficient", 1.0 / unit),
            }
            attributes = {
                quantity: (prim.GetAttribute(name), factor) for quantity, (name, factor) in scaled.items()
            }
            drives[custom["name"]] = {
                quantity: attribute.Get() * factor
                for quantity, (attribute, factor) in attributes.items()
                if attribute and attribute.HasAuthoredValue()
            }
    return Read(bodies, drives)


RandomParameters = Callable[[Robot, int], dict[str, float]]
SPRING = Spring(2, 4000.0, 0.2, (0.35, 0.15), 0.4)
ARMS = [*robot_names(), "rx90 with spring", "crooked", "stanford", "from a URDF"]
SINGLE = 1e-6
"""Relative: what single precision leaves."""


@pytest.fixture
def whole(arm: str, prismatic: dict[str, Robot], random_parameters: RandomParameters, tmp_path: Path) -> WholeRobot:
    """A robot of every kind with a number for everything."""
    if arm in robot_names():
        robot = load_robot(arm).with_offsets(True)
    elif arm == "rx90 with spring":
        rx90 = load_robot("rx90").with_offsets(True)
        robot = replace(rx90, drives=replace(rx90.drives, spring=SPRING), base=rx90.base)
    elif arm == "from a URDF":
        path = tmp_path / "arm.urdf"
        path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
        robot = load_robot(path).with_offsets(True)
    else:
        robot = prismatic[arm]
    if arm in robot_names():
        robot = with_stand_in(robot)
        offsets = {f"OFF{j}": 0.1 * j for j in range(1, robot.n + 1)}
        return whole_robot(robot, dict(robot.parameters) | offsets, "a stand-in")
    values = random_parameters(robot, 3)
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        values |= {f"{kind}{j}": values[f"{kind}{j}"] + 3.0 for kind in ("IA", "FV")} | {f"FV{k}": 4.0}
    return whole_robot(robot, values, "a table")


@pytest.mark.parametrize("arm", ARMS)
def test_mujoco_moves_it_as_the_regressor_says(whole: WholeRobot) -> None:
    """Motors' torques by mj_inverse and actuators against Newton-Euler, dry friction apart; in N·m."""
    mujoco = pytest.importorskip("mujoco")
    robot = whole.robot
    model = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(whole))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    assert model.dof_frictionloss.any() == bool(robot.drives.friction)
    model.dof_frictionloss[:] = 0.0
    model.tendon_frictionloss[:] = 0.0
    values = {name: label.value for link in whole.links for name, label in link.parameters.items()}
    dry = {name: 0.0 for name in values if name.startswith("FS")}
    chi = np.array([(values | dry)[name] for name in standard_columns(robot)])
    dynamics, data = inverse_dynamics(robot), mujoco.MjData(model)
    for state in zip(*random_states(robot, 20, seed=2), strict=True):
        expected = np.array(dynamics(*state, chi)).ravel()
        data.qpos, data.qvel, data.qacc = state
        mujoco.mj_inverse(model, data)
        inverse = data.qfrc_inverse.copy()
        model.actuator_ctrlrange[:] = 1e9 * np.array([-1.0, 1.0])
        data.ctrl = expected
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(inverse, data.qfrc_actuator, rtol=0.0, atol=1e-9)


READERS: dict[str, tuple[str, Callable[[str, Path], Read], float]] = {
    "mujoco reads mjcf": ("mjcf", lambda text, _: by_mujoco(text), 1e-9),
    "mujoco reads urdf": ("urdf", lambda text, _: by_mujoco(text), 1e-9),
    "drake reads urdf": ("urdf", lambda text, _: by_drake(text, "urdf"), 1e-9),
    "drake reads sdf": ("sdf", lambda text, _: by_drake(text, "sdf"), 1e-9),
    "pinocchio reads urdf": ("urdf", lambda text, _: by_pinocchio(text), 1e-9),
    "usd-core reads usd": ("usd", by_usd, SINGLE),
}
HELD = {
    "mujoco reads mjcf": {"armature", "damping", "friction", "offset", "low", "high", "torque"},
    "mujoco reads urdf": {"damping", "friction", "low", "high"},
    "drake reads urdf": {"armature", "damping", "torque", "low", "high", "speed", "acceleration"},
    "drake reads sdf": {"armature", "damping", "torque", "low", "high", "speed", "acceleration"},
    "pinocchio reads urdf": {"damping", "friction", "torque", "low", "high", "speed"},
    "usd-core reads usd": {"armature", "damping", "friction", "torque", "low", "high", "speed"},
}
"""Numbers that each simulator is to hold of a joint."""


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("arm", ARMS)
def test_simulators_read_the_same_numbers_back(whole: WholeRobot, reader: str, tmp_path: Path) -> None:
    form, read, tolerance = READERS[reader]
    content = read(FORMATS[form].text(whole), tmp_path)
    by_joint = reader.startswith("pinocchio")
    for joint, link in zip(whole.joint_names, whole.links, strict=True):
        body = content.bodies[joint if by_joint else link.link]
        np.testing.assert_allclose(body.mass, link.body.mass, rtol=tolerance)
        np.testing.assert_allclose(body.com, link.body.com, atol=tolerance)
        size = float(np.abs(link.body.inertia_com).max())
        np.testing.assert_allclose(body.inertia, link.body.inertia_com, atol=tolerance * max(size, 1e-3))
    drives = whole.drives if form == "mjcf" else whole.apart
    for j, (name, drive) in enumerate(zip(whole.joint_names, drives, strict=True)):
        expected = {quantity: max(label.value, 0.0) for quantity, label in drive.items() if quantity != "offset"}
        expected |= {"offset": drive["offset"].value} if "offset" in drive else {}
        expected |= limits(whole.robot, j)
        for quantity in HELD[reader] & expected.keys():
            assert content.drives[name][quantity] == pytest.approx(
                expected[quantity], rel=tolerance, abs=tolerance
            ), quantity


def limits(robot: Robot, j: int) -> dict[str, float]:
    """Limits that a joint has."""
    limit = robot.joints[j].limits
    low, high = limit.position
    both = {"low": low, "high": high} if math.isfinite(low) and math.isfinite(high) else {}
    values = {"speed": limit.speed, "acceleration": limit.acceleration, "torque": limit.torque}
    return both | {quantity: value for quantity, value in values.items() if math.isfinite(value)}


@pytest.mark.parametrize("arm", ["rx90 with spring"])
def test_what_a_format_cannot_hold_is_said(whole: WholeRobot) -> None:
    for name, form in FORMATS.items():
        text = " ".join(form.head(form, whole))
        assert ("This format has no spring on joint_2" in text) == (name != "mjcf")
        assert ("This format has no drive that turns with the sum of joint_5 and joint_6" in text) == (
            name != "mjcf"
        )
        assert ("This format has no offset" in text) == (name != "mjcf")
        assert ("This format has no acceleration limits" in text) == (name in ("mjcf", "usd"))
        assert ("This format has no speed limits" in text) == (name == "mjcf")
    table = replace(whole.robot.drives, spring=Spring(2, table=((-2.0, 1.0), (2.0, 3.0))))
    tabled = replace(whole, robot=replace(whole.robot, drives=table))
    assert "This format has no spring on joint_2 (a table)" in " ".join(
        FORMATS["mjcf"].head(FORMATS["mjcf"], tabled)
    )
    assert "<spatial" not in FORMATS["mjcf"].text(tabled)
    printed = replace(whole, robot=whole.robot.with_coulomb("paper"))
    assert "as the paper prints it: it is left out" in " ".join(FORMATS["mjcf"].head(FORMATS["mjcf"], printed))
    assert len(re.findall('name="coupled_drive"[^>]*frictionloss', FORMATS["mjcf"].text(printed))) == 0


@pytest.mark.parametrize("arm", ["ur10e"])
def test_what_is_not_known_is_left_out_with_a_line(whole: WholeRobot) -> None:
    """No rotor, no friction and no negative number is made up."""
    blind = replace(whole.robot, drives=Drives.on_link_side())
    values = {name: label.value for link in whole.links for name, label in link.parameters.items()}
    known = {name: values[name] for name in standard_columns(blind)}
    bare = whole_robot(blind, known, "a table")
    negative = whole_robot(whole.robot, values | {"FV2": -3.0}, "a table")
    for form in FORMATS.values():
        text = " ".join(form.head(form, bare))
        assert "Rotor inertias (armature) are left out: torque sensors behind the gears do not show them" in text
        assert "Friction is left out" in text
        assert "armature=" not in form.text(bare)
        text = " ".join(form.head(form, negative))
        assert "written as zero: shoulder_lift_joint damping" in text
        assert 'damping="-' not in form.text(negative)
        assert "<damping>-" not in form.text(negative)


def test_a_urdf_comes_back_in_its_own_frames(tmp_path: Path) -> None:
    """Read, written and read again: same links, joints, flange and limits, equal parameters."""
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(load_robot("irb120"), seed=1), encoding="utf-8")
    robot = load_robot(path)
    path.write_text(FORMATS["urdf"].text(whole_robot(robot, robot.parameters, "its file")), encoding="utf-8")
    again = load_robot(path)
    assert again.links is not None
    assert robot.links is not None
    assert (again.links.names, again.links.joints, again.links.tip) == (
        robot.links.names, robot.links.joints, robot.links.tip
    )  # fmt: skip
    np.testing.assert_allclose(again.flange.R, robot.flange.R, atol=1e-12)
    np.testing.assert_allclose(again.flange.p, robot.flange.p, atol=1e-9)
    assert [joint.limits for joint in again.joints] == [joint.limits for joint in robot.joints]
    assert dict(again.parameters) == pytest.approx(dict(robot.parameters), rel=1e-9, abs=1e-9)


def identified(robot: Robot, truth: dict[str, float], seed: int) -> WholeRobot:
    """A robot nearest to cylinders, from base parameters with a fifth of their size as noise."""
    base = base_parameters(robot)
    chi = base.value(truth)
    sigma = 0.2 * (np.abs(chi) + 0.1)
    values = chi + sigma * np.random.default_rng(seed).standard_normal(len(chi))
    values[base.columns.index("FV3")] = -3.0 * sigma[base.columns.index("FV3")]
    estimate = Estimate(
        base.columns, values, np.diag(sigma**2), np.inf, Fit(np.ones(1), np.ones(1), (1,)), np.ones(1)
    )
    nearest = solve_constrained_prior(robot, base, estimate, robot_prior(robot, 50.0))
    return whole_robot(robot, nearest.parameters, "noise", base, estimate, nearest.prior.source)


@pytest.mark.parametrize("name", ["rx90", "kr6_r900"])
def test_an_identified_robot_is_one_that_can_exist(name: str, random_parameters: RandomParameters) -> None:
    """Every link has some margin, and who decided each number is told."""
    robot = load_robot(name)
    whole = identified(robot, random_parameters(robot, 6), 6)
    for link in whole.links:
        assert link.moments[0] > 0.0
        assert link.margin > 0.0
    drives = [label for drive in (*whole.drives, whole.coupled) for label in drive.values()]
    bound = [label for label in drives if label.bound]
    assert whole.drives[2]["damping"].bound
    assert all(label.mark == "rule" for label in bound)
    assert all(label.value < 1e-2 for label in bound)
    text = FORMATS["mjcf"].text(whole)
    assert "At their bound of zero: " in text
    for words in (" mark=data share=1.000 sigma=", " mark=rule ", " mark=prior share=0.000 sigma=none"):
        assert words in text
    lines = re.findall(
        r"^ +(\w+) (\S+) (data|rule|prior) ([\d.]+) (\S+) (\S+) (\S+) (\S+)$", text, flags=re.MULTILINE
    )
    assert {line[0] for line in lines} >= set(BODY_NUMBERS) | {"armature", "damping", "friction", "FV1", "XX6"}


ARM = "irb120"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A URDF with link frames, names and bodies of its own."""
    path = tmp_path / "own.urdf"
    path.write_text(dressed_urdf(load_robot(ARM), seed=1), encoding="utf-8")
    return path


@pytest.fixture
def known(own: Path) -> WholeRobot:
    """The shipped robot, in modified DH frames, that knows the names of the user's joints."""
    links = load_robot(own).links
    assert links is not None
    robot = with_stand_in(replace(load_robot(ARM), joint_names=(links.joints,)))
    return whole_robot(robot, dict(robot.parameters), "a stand-in")


def torques(robot: Robot, states: tuple[Array, ...]) -> Array:
    """Torques without dry friction [N·m]."""
    dry = {name: 0.0 for name in robot.parameters if name.startswith("FS")}
    chi = np.array([(dict(robot.parameters) | dry)[name] for name in standard_columns(robot)])
    function = inverse_dynamics(robot)
    return np.array([np.array(function(*state, chi)).ravel() for state in zip(*states, strict=True)])


def torques_by_mujoco(path: Path, states: tuple[Array, ...], names: tuple[str, ...]) -> Array:
    """Torques by mj_inverse [N·m], joints in the robot's order."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.dof_frictionloss[:] = 0.0
    data, rows = mujoco.MjData(model), []
    places = [int(model.joint(name).qposadr[0]) for name in names]
    for state in zip(*states, strict=True):
        for values, vector in zip((data.qpos, data.qvel, data.qacc), state, strict=True):
            values[places] = vector
        mujoco.mj_inverse(model, data)
        rows.append(data.qfrc_inverse[places].copy())
    return np.array(rows)


def written_as(kind: str, own: Path) -> Path:
    """The user's URDF, or MuJoCo's model of it."""
    if kind == "urdf":
        return own
    mujoco = pytest.importorskip("mujoco")
    path = own.with_suffix(".xml")
    spec = mujoco.MjSpec.from_file(str(own))
    spec.compile()
    path.write_text(spec.to_xml(), encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_a_users_model_moves_as_the_robot(kind: str, own: Path, known: WholeRobot) -> None:
    path = written_as(kind, own)
    before = path.read_text(encoding="utf-8")
    changed, _ = into(kind, str(path), known, ["a head"])
    path.write_text(changed, encoding="utf-8")
    states = random_states(known.robot, 10, seed=2)
    expected = torques(known.robot, states)
    if kind == "urdf":  # which MuJoCo reads without rotors
        rotors = np.array([known.robot.parameters.get(f"IA{j}", 0.0) for j in range(1, 7)])
        expected = expected - rotors * states[2]
    torque = torques_by_mujoco(path, states, known.joint_names)
    np.testing.assert_allclose(torque, expected, atol=1e-6 * np.abs(expected).max())
    assert stripped(changed) == stripped(before)


def stripped(text: str) -> list[str]:
    """Parts that must stay, tag by tag: all but comments, inertials, marks and the drives' attributes."""
    text = re.sub(r"<!--.*?-->|<custom>.*?</custom>|<inertial>.*?</inertial>", "", text, flags=re.DOTALL)
    text = re.sub(r"<inertial [^>]*/>|<dynamics [^>]*/>", "", text)
    text = re.sub(r'\s(armature|damping|frictionloss)="[^"]*"', "", text)
    text = re.sub(r"(<[^<>/]*)>\s*</\w+>", r"\1/>", text)  # an element without content is written either way
    return [" ".join(tag.split()) for tag in text.split(">")]


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_what_does_not_change_stays_byte_for_byte(kind: str, own: Path, known: WholeRobot) -> None:
    """Odd blanks, quotes, entities, line ends, a namespace: whole elements or attributes are put in or replaced."""
    path = written_as(kind, own)
    odd = "\n <!-- a > b -->  <custom\t>\r\n<text name = 'odd&quot;s'   data=\"damping='3' >\"  />\n</custom >\n"
    end = "</robot>" if kind == "urdf" else "</mujoco>"
    text = path.read_text(encoding="utf-8").replace("><", ">\n<")  # a tag a line
    text = text.replace("<mujoco ", '<mujoco xmlns="urn:own" ')  # which MuJoCo reads; a URDF has none
    path.write_bytes(text.replace(end, f"{odd}{end}").encode())
    before = path.read_bytes().decode()
    changed, _ = into(kind, str(path), known, ["a head"])
    assert odd in changed
    lines = difflib.ndiff(before.splitlines(keepends=True), changed.splitlines(keepends=True))
    gone = [line[2:].strip() for line in lines if line.startswith("- ")]
    assert gone
    assert all(re.match("<(/?inertial|origin|mass|inertia|dynamics|joint)\\b", line) for line in gone), gone


def test_what_does_not_match_is_listed_or_refused(own: Path, known: WholeRobot, tmp_path: Path) -> None:
    text = own.read_text(encoding="utf-8")
    last = known.joint_names[5]
    target = tmp_path / "other.urdf"
    target.write_text(text.replace(f'"{last}"', '"wrist"'), encoding="utf-8")
    notes = " ".join(into("urdf", str(target), known, [])[1])
    assert f"Joints of {ARM} that are not in {target}: {last}." in notes
    assert f"Joints of {target} that are left alone: wrist." in notes
    for k, name in enumerate(known.joint_names):
        text = text.replace(f'"{name}"', f'"other{k}"')
    target.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="none of its joints"):
        into("urdf", str(target), known, [])
    kuka = with_stand_in(replace(load_robot("kr6_r900"), joint_names=known.robot.joint_names))
    with pytest.raises(InputError, match="its geometry, zero or sense is not kr6_r900's"):
        into("urdf", str(own), whole_robot(kuka, dict(kuka.parameters), "a stand-in"), [])
