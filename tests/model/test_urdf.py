"""URDF in, of xacro and of robot_descriptions too: against Pinocchio, and what is said of what cannot be used."""

import math
import sys
from math import pi
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from dynident.common.errors import InputError
from dynident.model import (
    Robot,
    base_parameters,
    closed_form_base_parameters,
    forward_kinematics,
    inverse_dynamics,
    load_robot,
    standard_columns,
)
from dynident.model.base import random_states
from dynident.tests.model.urdf_files import ARMS, REFERENCE, Write, dressed_urdf, rigid
from dynident.tests.model.urdf_files import write as write


def check_against_pinocchio(text: str, robot: Robot) -> None:
    """Pose of the flange and joint torques by Pinocchio's own reading of the same text."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    tip = model.getFrameId("tool0")
    robot = rigid(robot)
    chi = np.array([robot.parameters[name] for name in standard_columns(robot)])
    ours, torque = forward_kinematics(robot), inverse_dynamics(robot)
    for q, qd, qdd in zip(*random_states(robot, 20, seed=3), strict=True):
        place, theirs = pinocchio_state(model, q)
        pin.framesForwardKinematics(model, data, place)
        R, p = (np.array(value) for value in ours(q))
        to_base = robot.base.inverse()
        base_R, base_p = to_base.R @ R, to_base.R @ p.ravel() + to_base.p
        np.testing.assert_allclose(base_R @ robot.flange.R, data.oMf[tip].rotation, atol=1e-9)
        np.testing.assert_allclose(base_R @ robot.flange.p + base_p, data.oMf[tip].translation, atol=1e-9)
        expected = pin.rnea(model, data, place, qd, qdd)[theirs]
        np.testing.assert_allclose(
            np.array(torque(q, qd, qdd, chi)).ravel(), expected, atol=1e-9 * np.abs(expected).max()
        )


def pinocchio_state(model: pin.Model, q: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Joint positions as Pinocchio counts them (a continuous joint by cosine and sine) and speeds' places."""
    place = np.zeros(model.nq)
    order = []
    for k in range(len(q)):
        joint = model.joints[model.getJointId(f"joint{k + 1}")]
        place[joint.idx_q : joint.idx_q + joint.nq] = [q[k]] if joint.nq == 1 else [np.cos(q[k]), np.sin(q[k])]
        order.append(joint.idx_v)
    return place, order


@pytest.mark.parametrize("path", ARMS, ids=[path.stem for path in ARMS])
def test_arms_against_pinocchio(path: Path, write: Write) -> None:
    """Kinematics and inverse dynamics of known arms, dressed in link frames of any kind, to 1e-9."""
    text = dressed_urdf(load_robot(path), seed=len(path.stem))
    check_against_pinocchio(text, load_robot(write(text)))


@pytest.mark.parametrize("seed", range(6))
def test_continuous_and_prismatic_joints(prismatic: dict[str, Robot], seed: int, write: Write) -> None:
    arm = list(prismatic.values())[seed % 3]
    text = dressed_urdf(arm, seed, limits=False)
    robot = load_robot(write(text))
    assert [joint.kind for joint in robot.joints] == [joint.kind for joint in arm.joints]
    check_against_pinocchio(text, robot)


@pytest.mark.parametrize("path", REFERENCE, ids=[path.stem for path in REFERENCE])
def test_base_parameters_survive_the_dress(path: Path, write: Write) -> None:
    """The number of base parameters is the plain table's: nothing special is lost in rounding."""
    plain, dressed = load_robot(path), load_robot(write(dressed_urdf(load_robot(path), seed=7)))
    assert len(base_parameters(rigid(dressed)).columns) == len(base_parameters(rigid(plain)).columns)
    assert len(closed_form_base_parameters(rigid(dressed)).columns) == len(base_parameters(rigid(plain)).columns)


def test_plain_numbers_come_back(write: Write) -> None:
    """A URDF in the modified DH frames themselves gives the table back, its flange as frame n."""
    robot = load_robot(REFERENCE[1])
    lines = ['<robot name="iiwa14"><link name="base"/>']
    for j, joint in enumerate(robot.joints):
        lines.append(f'<link name="link{j + 1}"/>')
        origin = f"{joint.d!r} {-math.sin(joint.alpha) * joint.r!r} {math.cos(joint.alpha) * joint.r!r}"
        lines.append(
            f'<joint name="joint{j + 1}" type="continuous"><parent link="{f"link{j}" if j else "base"}"/>'
            f'<child link="link{j + 1}"/><origin xyz="{origin}" rpy="{joint.alpha!r} 0 0"/><axis xyz="0 0 1"/>'
            "</joint>"
        )
    read = load_robot(write("".join([*lines, "</robot>"])))
    for ours, table in zip(read.joints, robot.joints, strict=True):
        assert (ours.alpha, ours.theta) == (table.alpha, table.theta)
        assert (ours.d, ours.r) == pytest.approx((table.d, table.r), abs=1e-12)
    assert read.flange.is_identity
    assert read.base.is_identity
    assert read.links is not None
    assert read.links.names == tuple(f"link{j}" for j in range(1, 8))
    assert (read.links.base, read.links.tip) == ("base", "link7")
    assert read.payload_frame == "link link7 of arm.urdf"


def test_limits_and_friction_are_read(write: Write) -> None:
    text = dressed_urdf(load_robot(REFERENCE[1]), seed=2)
    text = text.replace('effort="40"/>', 'effort="40"/><dynamics damping="0.5" friction="2"/>', 1)
    robot = load_robot(write(text))
    limits = robot.joints[0].limits
    assert (limits.position, limits.speed, limits.torque) == ((-2.0, 1.5), 3.0, 40.0)
    assert math.isinf(limits.acceleration)
    assert (robot.parameters["FV1"], robot.parameters["FS1"]) == (0.5, 2.0)


def test_short_angles_are_snapped_and_said(write: Write) -> None:
    """1.5708 for 90 degrees (FACTS: 3.7e-6 rad off) gives the very same robot as pi / 2 does."""
    text = dressed_urdf(load_robot(REFERENCE[1]), seed=0)
    short = text.replace(repr(math.pi / 2), "1.5708").replace(repr(math.pi), "3.1416")
    assert short != text
    exact, snapped = load_robot(write(text)), load_robot(write(short))
    assert snapped.joints == exact.joints
    assert not exact.snapped
    assert any("1.5708 taken as 1.57079633" in note for note in snapped.snapped)
    texts = [note.rpartition(": ")[2] for note in snapped.snapped]
    assert len(set(texts)) == len(texts), "what holds for several joints is said once"


@pytest.mark.parametrize(
    ("mass", "moments", "words"),
    [
        ("-2", "0.01 0.01 0.01", "a mass of -2 kg"),
        ("0", "0.01 0.01 0.01", "a mass of 0 kg"),
        ("2", "0.01 0.02 0.05", "principal moments of inertia: 0.01, 0.02, 0.05"),
        ("2", "-0.01 0.02 0.02", "-0.01, 0.02, 0.02"),
        ("2", "0.01 0.02 0.03001", ""),
        ("2", "0.01 0.02 0.0299", ""),
        ("0", "0 0 0", ""),
    ],
)
def test_a_body_that_cannot_exist_is_named_by_its_link(write: Write, mass: str, moments: str, words: str) -> None:
    """A note, for the parameters are a prior only; what rounding leaves, and links without a body, get none."""
    xx, yy, zz = moments.split()
    numbers = f'ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"'
    inertial = f'<inertial><mass value="{mass}"/><inertia {numbers}/></inertial>'
    robot = load_robot(
        write(
            f'<robot name="r"><link name="a"/><link name="elbow">{inertial}</link>'
            '<joint name="j" type="continuous"><parent link="a"/><child link="elbow"/><axis xyz="0 0 1"/></joint>'
            "</robot>"
        )
    )
    notes = [note for note in robot.snapped if "no body" in note]
    assert len(notes) == bool(words)
    assert all(note.startswith("link 'elbow': ") and words in note for note in notes)


LINKS = "".join(f'<link name="{name}"/>' for name in "abcd")


def joint(name: str, parent: str, child: str, kind: str = "revolute", more: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/>{more}</joint>'
    )


def file(*joints: str) -> str:
    return f'<robot name="x">{LINKS}{"".join(joints)}</robot>'


CHAIN = (joint("j1", "a", "b"), joint("j2", "b", "c"), joint("j3", "c", "d", "fixed"))
BAD = {
    "bomb": ('<!DOCTYPE r [<!ENTITY a "aaaa">]><robot/>', "DOCTYPE is not accepted"),
    "not XML": ("<robot", "not valid XML"),
    "xacro": ('<robot xmlns:xacro="x" name="${n}"/>', "xacro"),
    "not a robot": ("<sdf/>", "outermost element is <sdf>"),
    "mimic": (file(CHAIN[0], joint("j2", "b", "c", more='<mimic joint="j1"/>'), CHAIN[2]), "'j2' mimics 'j1'"),
    "floating": (file(CHAIN[0], joint("j2", "b", "c", "floating"), CHAIN[2]), "'j2' is 'floating'"),
    "planar": (file(CHAIN[0], joint("j2", "b", "c", "planar"), CHAIN[2]), "'j2' is 'planar'"),
    "several tips": (file(CHAIN[0], CHAIN[1], joint("j3", "b", "d")), "set chain to :TIP, TIP one of c, d"),
    "several roots": (file(CHAIN[0], joint("j2", "c", "d")), "set chain to BASE:, BASE one of a, c"),
    "nothing moves": (file(*(joint(f"j{p}", p, c, "fixed") for p, c in ("ab", "bc", "cd"))), "no joint moves"),
    "closed loop": (file(*CHAIN, joint("j4", "a", "d")), "'d' is the child of joints 'j3' and 'j4'"),
    "endless": (file(joint("j1", "a", "b"), joint("j2", "b", "a"), joint("j3", "c", "d")), "own ancestor"),
    "all in a ring": ('<robot name="x"><link name="a"/>' + joint("j", "a", "a") + "</robot>", "own ancestor"),
    "empty": ("<robot/>", "no links"),
    "unknown link": (file(joint("j1", "a", "z")), "no link 'z'"),
    "no name": ("<robot><link/></robot>", "name is missing"),
    "twice": ('<robot><link name="a"/><link name="a"/></robot>', "given twice"),
    "letters": (file(joint("j1", "a", "b", more='<origin xyz="0 0 x"/>')), "'0 0 x' is not a number"),
    "two numbers": (file(joint("j1", "a", "b", more='<origin xyz="0 0"/>')), "three numbers are needed"),
    "infinite": (file(joint("j1", "a", "b", more='<origin xyz="0 0 inf"/>')), "reasonable size"),
    "no axis": (file(CHAIN[0].replace("0 0 1", "0 0 0"), *CHAIN[1:]), "axis has no direction"),
    "no parent": (file(CHAIN[0].replace('<parent link="a"/>', "")), "<parent link=...> is missing"),
    "half a body": ('<robot><link name="a"><inertial><mass value="1"/></inertial></link></robot>', "<inertia>"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "problem"), BAD.values(), ids=BAD.keys())
def test_what_cannot_be_used(write: Write, text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem) as error:
        load_robot(write(text))
    assert "\n" not in str(error.value)
    assert "arm.urdf" in str(error.value)


def test_files_that_are_no_descriptions(write: Write, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="larger than 5 MB"):
        load_robot(write(f"<robot>{' ' * 5_000_000}</robot>"))
    (tmp_path / "utf16.urdf").write_bytes('<robot name="x"/>'.encode("utf-16"))
    with pytest.raises(InputError, match="UTF-8"):
        load_robot(tmp_path / "utf16.urdf")


def test_choosing_base_and_tip(write: Write) -> None:
    path = write(file(CHAIN[0], CHAIN[1], joint("j3", "b", "d")))
    links = load_robot(path, tip="d").links
    assert links is not None
    assert (links.names, links.joints, links.base, links.tip) == (("b", "d"), ("j1", "j3"), "a", "d")
    assert load_robot(path, base="b", tip="c").n == 1
    assert load_robot(path, tip="c").snapped == (
        "joint 'j3' is not of the chain: it and what hangs on it are left out",
    )
    with pytest.raises(InputError, match="no link 'e': the links are a, b, c, d"):
        load_robot(path, tip="e")
    with pytest.raises(InputError, match="no chain leads from 'c' down to 'a'"):
        load_robot(path, base="c", tip="a")
    with pytest.raises(InputError, match="links of a URDF"):
        load_robot("rx90", tip="tool0")


@pytest.mark.parametrize("element", ['<link name="${p}e"/>', "<x:if xmlns:x='http://ros.org/xacro'/>"])
def test_an_element_that_xacro_cannot_expand_is_refused(write: Write, element: str) -> None:
    with pytest.raises(InputError, match=r"expand it first \(xacro FILE"):
        load_robot(write(file(*CHAIN).replace("</robot>", f"{element}</robot>")))
    load_robot(write(file(*CHAIN).replace("</robot>", "<gazebo>${x}</gazebo></robot>")))  # a tag that nobody reads


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("more", "tip"),
    [(("tool0", "ft_frame"), "tool0"), (("flange", "tool0"), "tool0"), (("flange", "camera"), "flange"),
     (("x_tool0", "ee_link"), "x_tool0"), (("panda_link8", "finger"), "panda_link8")],
)  # fmt: skip
def test_the_flange_wins_by_its_name_and_is_told(write: Write, more: tuple[str, str], tip: str, seed: int) -> None:
    """Among several ends, and with a gripper's fingers beyond it."""
    grasps = ("left", "right") if seed == 1 else ()
    links = "".join(f'<link name="{name}"/>' for name in (*more, *grasps))
    fixed = [joint(f"f{k}", "d", name, "fixed") for k, name in enumerate(more)]
    fingers = [joint(name, tip, name, "prismatic") for name in grasps]
    joints = np.random.default_rng(seed).permutation([*CHAIN, *fixed, *fingers])
    text = file(*joints.tolist()).replace("</robot>", f"{links}</robot>")
    robot = load_robot(write(text))
    assert robot.links is not None
    assert robot.links.tip == tip
    assert any(f"{tip!r} is taken as the flange by its name" in note for note in robot.snapped)
    assert robot.payload_frame.startswith("flange:") == (tip != "flange")
    arm = load_robot(write(text), tip=tip)
    assert not any("by its name" in note for note in arm.snapped)


def test_axes_almost_parallel_are_told(write: Write) -> None:
    """A calibrated description: 1 mrad off parallel, the common normal far from the arm."""
    lean = '<origin xyz="0.5 0 0" rpy="0 0.001 0"/>'
    robot = load_robot(write(file(joint("j1", "a", "b"), joint("j2", "b", "c", more=lean), CHAIN[2])))
    assert any("axes 1 and 2 are almost parallel" in note for note in robot.snapped)


HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="$(arg name)">'
ARM = """<xacro:macro name="arm" params="prefix turn:=${pi/2}">
  <link name="${prefix}base"/><link name="${prefix}upper"/><link name="${prefix}tool0"/>
  <joint name="${prefix}pan" type="revolute">
    <parent link="${prefix}base"/><child link="${prefix}upper"/><axis xyz="0 0 1"/>
    <origin xyz="0 0 ${2 * 0.1}" rpy="${turn} 0 0"/><limit lower="-2" upper="2" velocity="1" effort="10"/>
  </joint>
  <joint name="${prefix}lift" type="revolute">
    <parent link="${prefix}upper"/><child link="${prefix}tool0"/><axis xyz="0 0 1"/>
    <origin xyz="0.4 0 0" rpy="0 0 0"/><limit lower="-2" upper="2" velocity="1" effort="10"/>
  </joint>
</xacro:macro>"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache; whoever would clone into it fails at once."""
    pytest.importorskip("robot_descriptions")
    pytest.importorskip("xacro")
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("ROBOT_DESCRIPTION_COMMIT", raising=False)
    monkeypatch.setenv("PATH", "")
    return tmp_path / "cache"


def put(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_urdf_of_the_cache(cache: Path) -> None:
    place = cache / "example-robot-data/robots/panda_description/urdf/panda.urdf"
    path = put(place, dressed_urdf(load_robot("panda"), seed=1))
    for _ in range(2):
        robot, own = load_robot("panda_description"), load_robot(path)
        assert robot.joints == own.joints
        assert robot.links == own.links
        assert robot.n == 7
    assert load_robot("panda_description", tip=own.links.tip if own.links else None).joints == own.joints


def test_a_xacro_file_of_the_cache_with_its_arguments(cache: Path, tmp_path: Path) -> None:
    """Its macro in another file, found by the package's name, and the type as an argument, as UR5e has it."""
    folder = cache / "ur_description/urdf"
    put(folder / "inc/arm.xacro", f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro">{ARM}</robot>')
    include = '<xacro:include filename="$(find ur_description)/urdf/inc/arm.xacro"/>'
    declared = '<xacro:arg name="name" default="x"/><xacro:arg name="ur_type" default="ur3"/>'
    put(folder / "ur.urdf.xacro", f'{HEAD}{declared}{include}<xacro:arm prefix="$(arg ur_type)_"/></robot>')
    robot = load_robot("ur5e_description")
    assert robot.name == "ur5e"
    assert robot.links is not None
    assert robot.links.joints == ("ur5e_pan", "ur5e_lift")
    plain = ARM.partition("\n")[2].rpartition("\n")[0].replace("${prefix}", "").replace("${2 * 0.1}", "0.2")
    plain = plain.replace("${turn}", repr(pi / 2))
    own = load_robot(put(tmp_path / "plain.urdf", f'<robot name="x">{plain}</robot>'))
    assert (robot.joints, robot.base, robot.flange) == (own.joints, own.base, own.flange)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pandda_description", "did you mean 'panda_description'"),
        ("ur5e_mj_description", "nor a URDF of that name in robot_descriptions"),
        ("zzzzzzzzzzzzzzzz_description", "'robot_descriptions list' shows them"),
    ],
)
@pytest.mark.usefixtures("cache")
def test_names_that_are_none(name: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_robot(name)


def test_without_the_packages(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = put(tmp_path / "arm.xacro", f'{HEAD}<xacro:arg name="name" default="x"/></robot>')
    for package, name in (("robot_descriptions", "panda_description"), ("xacro", str(path))):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(InputError, match=r"pip install 'dynident\[robots\]'"):
            load_robot(name)


def test_a_xacro_file_by_its_path(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    head = HEAD.replace("$(arg name)", "own")
    text = f'{head}<xacro:arg name="side" default="my"/>{ARM}<xacro:arm prefix="$(arg side)_" turn="0"/></robot>'
    robot = load_robot(put(tmp_path / "arm.urdf.xacro", text))
    assert robot.links is not None
    assert (robot.name, robot.links.joints) == ("own", ("my_pan", "my_lift"))
    assert not any(capsys.readouterr())
    for wrong, words in (
        (text.replace('"side"', '"other"'), "Undefined substitution argument side"),
        (text.replace("$(arg side)_", "$(find nowhere)"), "package 'nowhere' is not found"),
        (text.replace("${2 * 0.1}", "${2 * none}"), "none"),
        (text.replace("</xacro:macro>", ""), "not valid XML"),
    ):
        with pytest.raises(InputError, match=words.replace("(", r"\(")) as error:
            load_robot(put(tmp_path / "wrong.xacro", wrong))
        assert "wrong.xacro" in str(error.value)
        assert "\n" not in str(error.value)
