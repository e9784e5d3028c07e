"""A user's own model gets a robot's numbers: the torques are the robot's, and all else stays as it was."""

import difflib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.export.own_model import into
from dynident.apps.export.simulators import FORMATS
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.possible.whole_robot import WholeRobot, whole_robot
from dynident.model import Robot, inverse_dynamics, load_robot, standard_columns, with_stand_in
from dynident.model.base.rank import random_states
from dynident.tests.model.urdf_files import dressed_urdf

ARM = "irb120"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A URDF with link frames, names and bodies of its own."""
    path = tmp_path / "own.urdf"
    path.write_text(dressed_urdf(load_robot(ARM), seed=1), encoding="utf-8")
    return path


@pytest.fixture
def whole(own: Path) -> WholeRobot:
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


def by_mujoco(path: Path, states: tuple[Array, ...], names: tuple[str, ...]) -> Array:
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
def test_a_users_model_moves_as_the_robot(kind: str, own: Path, whole: WholeRobot) -> None:
    path = written_as(kind, own)
    before = path.read_text(encoding="utf-8")
    changed = into(kind, str(path), whole, ["a head"])
    path.write_text(changed.text, encoding="utf-8")
    states = random_states(whole.robot, 10, seed=2)
    expected = torques(whole.robot, states)
    if kind == "urdf":  # which MuJoCo reads without rotors
        rotors = np.array([whole.robot.parameters.get(f"IA{j}", 0.0) for j in range(1, 7)])
        expected = expected - rotors * states[2]
    torque = by_mujoco(path, states, whole.joint_names)
    np.testing.assert_allclose(torque, expected, atol=1e-6 * np.abs(expected).max())
    assert stripped(changed.text) == stripped(before)


def stripped(text: str) -> list[str]:
    """What must stay, tag by tag: all but comments, inertials, marks and the drives' attributes."""
    text = re.sub(r"<!--.*?-->|<custom>.*?</custom>|<inertial>.*?</inertial>", "", text, flags=re.DOTALL)
    text = re.sub(r"<inertial [^>]*/>|<dynamics [^>]*/>", "", text)
    text = re.sub(r'\s(armature|damping|frictionloss)="[^"]*"', "", text)
    text = re.sub(r"(<[^<>/]*)>\s*</\w+>", r"\1/>", text)  # an element without content is written either way
    return [" ".join(tag.split()) for tag in text.split(">")]


def test_comments_and_namespaces_of_the_user_stay(own: Path, whole: WholeRobot) -> None:
    """Before, in and after the outermost element; a commented element stays as it was written."""
    text = own.read_text(encoding="utf-8").replace(
        "<robot ", '<robot xmlns:xacro="http://x" xmlns:own="urn:own" ', 1
    )
    inner = '<!-- <link name="old" /> -->\n<own:thing own:key="a &lt; b"/>\n'
    text = text.replace("</robot>", f"{inner}</robot>\n<!-- the end -->\n").replace(
        "<robot ", "<!-- mine -->\n<robot ", 1
    )
    own.write_text(text, encoding="utf-8")
    changed = into("urdf", str(own), whole, []).text
    begin, end = text.index("<robot"), len("<!-- the end -->\n")
    assert (changed[:begin], changed[-end:]) == (text[:begin], text[-end:])
    assert inner in changed
    assert 'xmlns:xacro="http://x"' in changed


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_what_does_not_change_stays_byte_for_byte(kind: str, own: Path, whole: WholeRobot) -> None:
    """Odd blanks, quotes, entities and line ends: what is put in or replaced are whole elements or attributes."""
    path = written_as(kind, own)
    odd = "\n <!-- a > b -->  <custom\t>\r\n<text name = 'odd&quot;s'   data=\"damping='3' >\"  />\n</custom >\n"
    end = "</robot>" if kind == "urdf" else "</mujoco>"
    text = path.read_text(encoding="utf-8").replace("><", ">\n<")  # a tag a line
    path.write_bytes(text.replace(end, f"{odd}{end}").encode())
    before = path.read_bytes().decode()
    changed = into(kind, str(path), whole, ["a head"]).text
    assert odd in changed
    lines = difflib.ndiff(before.splitlines(keepends=True), changed.splitlines(keepends=True))
    gone = [line[2:].strip() for line in lines if line.startswith("- ")]
    assert gone
    assert all(re.match("<(/?inertial|origin|mass|inertia|dynamics|joint)\\b", line) for line in gone), gone


def test_what_does_not_match_is_listed_or_refused(own: Path, whole: WholeRobot, tmp_path: Path) -> None:
    text = own.read_text(encoding="utf-8")
    last = whole.joint_names[5]
    target = tmp_path / "other.urdf"
    target.write_text(text.replace(f'"{last}"', '"wrist"'), encoding="utf-8")
    notes = " ".join(into("urdf", str(target), whole, []).notes)
    assert f"Joints of {ARM} that are not in {target}: {last}." in notes
    assert f"Joints of {target} that are left alone: wrist." in notes
    for k, name in enumerate(whole.joint_names):
        text = text.replace(f'"{name}"', f'"other{k}"')
    target.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="none of its joints"):
        into("urdf", str(target), whole, [])
    kuka = with_stand_in(replace(load_robot("kr6_r900"), joint_names=whole.robot.joint_names))
    with pytest.raises(InputError, match="its geometry, zero or sense is not kr6_r900's"):
        into("urdf", str(own), whole_robot(kuka, dict(kuka.parameters), "a stand-in"), [])


@pytest.mark.parametrize("arm", ["rx90"])
def test_a_coupled_drive_becomes_a_tendon(arm: str, tmp_path: Path) -> None:
    """Into the robot's own export, whose numbers were taken out: the same numbers again."""
    mujoco = pytest.importorskip("mujoco")
    robot = load_robot(arm)
    whole = whole_robot(robot, dict(robot.parameters), "its file")
    path = tmp_path / "bare.xml"
    bare = re.sub(r"  <(tendon|custom)>.*?</\1>\n", "", FORMATS["mjcf"].text(whole), flags=re.DOTALL)
    bare = re.sub(r'\s(armature|damping|frictionloss)="[^"]*"', "", bare)
    path.write_text(bare.replace('mass="', 'mass="7'), encoding="utf-8")
    again = mujoco.MjModel.from_xml_string(into("mjcf", str(path), whole, []).text)
    first = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(whole))
    for name in ("body_mass", "body_ipos", "dof_armature", "dof_damping", "dof_frictionloss", "tendon_armature"):
        np.testing.assert_allclose(getattr(again, name), getattr(first, name), atol=1e-9)
