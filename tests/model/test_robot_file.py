"""Robots and payloads by name and from files: what is read, and what is said of what cannot be used."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident import model
from dynident.common.errors import InputError
from dynident.common.schema import toml_text
from dynident.model.files.robot_file import robot_toml
from dynident.model.friction import PAPER
from dynident.tests.model.urdf_files import Write
from dynident.tests.model.urdf_files import write as write

FULL = """
name = "own"
title = "Own robot"
payload_frame = "flange"
gravity = [0, 3, -9]
source = "measured"
rated_payload_kg = 7

[flange]
xyz = [0.01, 0, 0.1]
rpy_deg = [180, 0, 0]

[base]
xyz = [0, 0, -0.3]

[lengths]
D2 = 0.3

[[joints]]
alpha_deg = 90
theta_deg = -180
position_deg = [-180, 90]
speed_deg_s = 360
acceleration_deg_s2 = 720
torque = 12

[[joints]]
kind = "prismatic"
alpha_deg = 30
d = "D2"
r = -0.1
position_m = [0, 0.5]
speed_m_s = 0.2
acceleration_m_s2 = 2

[[joints]]

[drives]
offsets = true

[drives.coupling]
joints = [1, 3]
coulomb = "paper"

[drives.spring]
joint = 1
table = [[-90, 1], [90, -1]]

[processing]
rate_hz = 200
cutoff_hz = 10
decimate = 5
still_speed = 0.001
slow_fraction = 0.02
max_mismatch = 0.01

[parameters]
M1 = 3
FSM3 = 0.5
"""


def test_everything_a_file_can_say(write: Write) -> None:
    robot = model.load_robot(write(FULL))
    turn, slide, plain = robot.joints
    assert (robot.name, robot.title, robot.payload_frame) == ("own", "Own robot", "flange")
    assert robot.gravity == (0.0, 3.0, -9.0)
    assert turn == model.Joint(
        "revolute",
        math.pi / 2,
        theta=-math.pi,
        limits=model.Limits((-math.pi, math.pi / 2), 2 * math.pi, 4 * math.pi, 12.0),
    )
    assert slide == model.Joint(
        "prismatic", math.radians(30), 0.3, 0.0, -0.1, model.Limits((0.0, 0.5), 0.2, 2.0), names=("D2", "")
    )
    assert plain == model.Joint()
    assert robot.drives.offsets
    assert robot.coupling is not None
    assert (robot.coupling.joints, robot.coupling.coulomb) == ((1, 3), "paper")
    assert robot.spring is not None
    assert robot.spring.table == ((-math.pi / 2, 1.0), (math.pi / 2, -1.0))
    settings = robot.processing
    assert (settings.rate, settings.cutoff, settings.decimate) == (200.0, 10.0, 5)
    assert (settings.still_speed, settings.slow_fraction, settings.max_mismatch) == (0.001, 0.02, 0.01)
    assert robot.parameters == {"M1": 3.0, "FSM3": 0.5}


def test_defaults(write: Write) -> None:
    robot = model.load_robot(str(write('name = "bare"\n[[joints]]\n[[joints]]\n')))
    assert robot.joints == (model.Joint(), model.Joint())
    assert robot.gravity == (0.0, 0.0, -9.81)
    assert robot.payload_frame == "frame 2 (modified DH)"
    assert (robot.drives.rotor_inertia, robot.drives.friction, robot.drives.offsets) == (True, PAPER, False)
    assert robot.flange.is_identity
    assert robot.base.is_identity
    assert math.isinf(robot.rated_payload)


def test_sensors_on_the_link_side_see_no_drive(write: Write) -> None:
    """No rotor, no gear: the ten of each link and an offset per joint."""
    robot = model.load_robot(write('name = "x"\n[[joints]]\n[[joints]]\n[drives]\nside = "link"'))
    assert model.standard_columns(robot) == tuple(f"{kind}{j}" for j in (1, 2) for kind in (*model.INERTIAL, "OFF"))
    without = model.load_robot(write('name = "x"\n[[joints]]\n[drives]\nside = "link"\noffsets = false'))
    assert model.standard_columns(without) == tuple(f"{kind}1" for kind in model.INERTIAL)
    rubbing = model.load_robot(write('name = "x"\n[[joints]]\n[drives]\nside = "link"\nfriction = true'))
    assert model.standard_columns(rubbing) == (*(f"{kind}1" for kind in model.INERTIAL), "FS1", "FV1", "OFF1")
    assert rubbing.drives.side == "link"


def test_nearly_special_geometry_is_snapped_and_noted(write: Write) -> None:
    near = math.degrees(1.5708)
    robot = model.load_robot(write(f'name = "x"\n[[joints]]\nalpha_deg = {near!r}\nd = 5e-7\nr = -0.25\n'))
    assert (robot.joints[0].alpha, robot.joints[0].d, robot.joints[0].r) == (math.pi / 2, 0.0, -0.25)
    assert robot.snapped == ("alpha1: 1.5708 taken as 1.57079633", "d1: 5e-07 taken as 0")


def test_geometry_that_is_not_special_is_kept(write: Write) -> None:
    robot = model.load_robot(write('name = "x"\n[[joints]]\nalpha_deg = 90.01\ntheta_deg = 0.006\nd = 2e-6\n'))
    assert robot.joints[0].alpha == math.radians(90.01)
    assert robot.joints[0].theta == math.radians(0.006)
    assert robot.joints[0].d == 2e-6
    assert robot.snapped == ()


ONE = 'name = "x"\n[[joints]]\n'


CASES = [
    ('name = "x"', "joints", r"give one \[\[joints\]\] table for each joint"),
    ('name = "x"\njoints = []', "joints", "give one"),
    (
        ONE + "alpha = 90",
        r"joints\[1\].alpha",
        "did you mean .alpha_deg., with its value in that unit. known here: acceleration_deg_s2",
    ),
    (ONE + 'd = "D7"', r"joints\[1\].d", r"no length 'D7' in \[lengths\]"),
    (ONE + 'kind = "helical"', r"joints\[1\].kind", "must be 'revolute' or 'prismatic'.*, got 'helical'"),
    (ONE + 'kind = "prismatic"\nspeed_deg_s = 1', r"joints\[1\].speed_deg_s", "a prismatic joint takes"),
    (ONE + "position_m = [0, 1]", r"joints\[1\].position_m", "a revolute joint takes position_deg"),
    (ONE + "position_deg = [10, -10]", r"joints\[1\]", "leave no range"),
    (ONE + "speed_deg_s = 0", r"joints\[1\]", "speed limit must be positive"),
    (ONE + "[drives]\nside = 'link'\nrotor_inertia = true", "drives.rotor_inertia", "link side do not see it"),
    ("rated_payload_kg = 0\n" + ONE, "robot", "rated payload must be positive"),
    (ONE + "[drives.coupling]\njoints = [1, 2]", "robot", "drives name joint 2"),
    (ONE + "[drives.coupling]\njoints = [1, 1]", "drives.coupling", "must differ"),
    (ONE + "[drives.spring]\njoint = 1", "drives.spring", "either a table or"),
    (ONE + "[processing]\ncutoff_hz = -5", "processing", "cutoff must be above 0 Hz"),
    (ONE + "[sources]\nmas = 'x'", "sources.mas", r"unknown: did you mean .mass.\? known here: "),
    (ONE + "[parameters]\nM2 = 3", "parameters.M2", "not a standard parameter"),
    (ONE + "[parameters]\nXXR1 = 3", "parameters.XXR1", "not a standard parameter"),
]


@pytest.mark.parametrize(("text", "key", "problem"), CASES, ids=[key for _, key, _ in CASES])
def test_error_names_the_key(write: Write, text: str, key: str, problem: str) -> None:
    with pytest.raises(InputError, match=rf"own\.toml: key '{key}': .*{problem}") as error:
        model.load_robot(write(text))
    assert "\n" not in str(error.value)


def test_robots_are_found_as_people_write_their_names(root: Path) -> None:
    assert model.robot_names() == tuple(sorted(path.stem for path in (root / "model/robots").glob("*.toml")))
    assert {"rx90", "tx40", "ur10e"} <= set(model.robot_names())
    for name in model.robot_names():
        assert model.load_robot(name).name == name
        for written in (name.upper(), name.replace("_", "-"), name.replace("_", " "), f"{name[:2]} {name[2:]}"):
            assert model.load_robot(written) == model.load_robot(name), written


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rx91", r"did you mean 'rx90'\? give one of .*rx90, .*tx40, ur10e, .*or the path"),
        ("toaster", "give one of fr3"),
        *((name, f"did you mean .*'{meant}'") for name, meant in (
            ("ur10", "ur10e"), ("UR10E2", "ur10e"), ("Pandda", "panda"), ("kr10", "kr10_r1100"),
            ("kuka", "kr6_r900"), ("Franka", "fr3"), ("stäubli", "rx90"),
        )),
    ],
)  # fmt: skip
def test_a_name_that_is_none_tells_what_may_be_meant(name: str, words: str) -> None:
    with pytest.raises(InputError, match=f"no robot '{name}': {words}"):
        model.load_robot(name)


@pytest.mark.parametrize(
    "path", ["ur10e.toml", "arms/ur10e", "ur10e.urdf", r"C:\robots\mine.toml", "/robots/mine.toml"]
)
def test_a_missing_file_is_called_missing(path: str) -> None:
    """Its name is told as it was given, on POSIX and on Windows."""
    with pytest.raises(InputError, match="no such file") as refused:
        model.load_robot(path)
    assert repr(path) in str(refused.value)


def test_a_robot_by_a_path_with_spaces(root: Path, tmp_path: Path) -> None:
    copy = tmp_path / "my robots" / "arm é.toml"
    copy.parent.mkdir()
    source = (root / "model/robots/rx90.toml").read_bytes()
    copy.write_bytes(source.replace(b"\n", b"\r\n"))  # as an editor on Windows saves it
    assert model.load_robot(copy) == model.load_robot(str(copy)) == model.load_robot("rx90")


SEEN = ("[/x] [bold]", "<b>&\"'</b>-->", "Ünï 日本 \U0001f916", "a/b\\c", "*/ x", "%s{}", "-x", '"""', "x" * 3000)
UNSEEN = ("", "  ", "a\x00", "a\x01b", "a\x1b[31mb", "a\x07", "a\rb", "a\x7f", "a\x9bb")
"""Characters that are no name; the first two, and ends of lines, are fine in a text."""


@pytest.mark.parametrize("text", SEEN)
def test_a_name_that_can_be_seen_comes_back(text: str, rx90: model.Robot, tmp_path: Path) -> None:
    named = replace(rx90, name=text, title=text, payload_frame=text, joint_names=((text,) * 6,))
    (tmp_path / "own.toml").write_text(robot_toml(named, text), encoding="utf-8")
    again = model.load_robot(tmp_path / "own.toml")
    assert (again.name, again.title, again.payload_frame) == (text, text, text)
    assert again.joint_names == named.joint_names


@pytest.mark.parametrize("text", UNSEEN)
def test_a_name_that_cannot_be_seen_is_refused(text: str, rx90: model.Robot, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="is not a valid name"):
        replace(rx90, name=text)
    with pytest.raises(ValueError, match="is not a valid name"):
        replace(rx90, joint_names=((*"abcde", text),))
    (tmp_path / "own.toml").write_text(toml_text({"name": text, "joints": [{"alpha_deg": 0}]}), encoding="utf-8")
    fault = r"own\.toml: key 'robot': .* is not a valid name: it(s character .*)? is (empty|U\+.* invisible): del"
    with pytest.raises(InputError, match=fault):
        model.load_robot(tmp_path / "own.toml")


def payload(folder: Path, text: str) -> model.InertialParameters:
    path = folder / "p.toml"
    path.write_text(text)
    return model.read_payload(path)


def test_both_forms_are_one_body(tmp_path: Path) -> None:
    inertia = np.array([[0.03, 0.001, 0.002], [0.001, 0.04, 0.003], [0.002, 0.003, 0.05]])
    body = model.InertialParameters.from_com(2.0, [0.01, 0.02, 0.1], inertia)
    com = payload(
        tmp_path, "mass = 2\ncom = [0.01, 0.02, 0.1]\ninertia_com = [0.03, 0.001, 0.002, 0.04, 0.003, 0.05]\n"
    )
    ten = payload(
        tmp_path, "[payload]\n" + "\n".join(f"{name} = {value!r}" for name, value in body.named().items())
    )
    assert np.allclose(com.vector, body.vector, atol=1e-15)
    assert np.allclose(ten.vector, body.vector, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("M = -1", "no body has such parameters"),
        ("M = 1\nXX = 1.0", "no body has such parameters"),
        ("mass = 1\ncom = [0, 0]", "key 'com': must be a list of 3 numbers"),
        ("M = inf", "key 'M': must be a finite number"),
    ],
)
def test_what_is_no_payload_is_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        payload(tmp_path, text)
