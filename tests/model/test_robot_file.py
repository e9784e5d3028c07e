"""Robot files: what is read, and what is said of a file that cannot be used."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters, Joint, Limits, Robot, load_robot, standard_columns

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """``write(text)``: a robot file with this text."""

    def make(text: str) -> Path:
        path = tmp_path / "own.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return make


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


def test_shipped_robots_load(shipped: Robot) -> None:
    assert shipped.n in (6, 7)
    assert shipped.title
    assert shipped.snapped == ()
    assert {joint.revolute for joint in shipped.joints} == {True}
    assert all(np.isfinite(joint.limits.position).all() for joint in shipped.joints)
    assert not set(shipped.parameters) - set(standard_columns(shipped))


def test_rx90_parameters_are_complete_and_possible(rx90: Robot) -> None:
    assert set(rx90.parameters) == set(standard_columns(rx90))
    for link in range(1, 7):
        ten = np.array([rx90.parameters[f"{kind}{link}"] for kind in INERTIAL])
        assert InertialParameters(ten).physically_consistent


def test_everything_a_file_can_say(write: Write) -> None:
    robot = load_robot(write(FULL))
    turn, slide, plain = robot.joints
    assert (robot.name, robot.title, robot.payload_frame) == ("own", "Own robot", "flange")
    assert robot.gravity == (0.0, 3.0, -9.0)
    assert turn == Joint(
        "revolute",
        math.pi / 2,
        theta=-math.pi,
        limits=Limits((-math.pi, math.pi / 2), 2 * math.pi, 4 * math.pi, 12.0),
    )
    assert slide == Joint(
        "prismatic", math.radians(30), 0.3, 0.0, -0.1, Limits((0.0, 0.5), 0.2, 2.0), names=("D2", "")
    )
    assert plain == Joint()
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
    robot = load_robot(str(write('name = "bare"\n[[joints]]\n[[joints]]\n')))
    assert robot.joints == (Joint(), Joint())
    assert robot.gravity == (0.0, 0.0, -9.81)
    assert robot.payload_frame == "frame 2 (modified DH)"
    assert (robot.drives.rotor_inertia, robot.drives.friction, robot.drives.offsets) == (True, True, False)
    assert robot.flange.is_identity
    assert robot.base.is_identity
    assert math.isinf(robot.rated_payload)


def test_sensors_on_the_link_side_see_no_drive(write: Write) -> None:
    """No rotor, no gear: the ten of each link and an offset per joint."""
    robot = load_robot(write('name = "x"\n[[joints]]\n[[joints]]\n[drives]\nside = "link"'))
    assert standard_columns(robot) == tuple(f"{kind}{j}" for j in (1, 2) for kind in (*INERTIAL, "OFF"))
    without = load_robot(write('name = "x"\n[[joints]]\n[drives]\nside = "link"\noffsets = false'))
    assert standard_columns(without) == tuple(f"{kind}1" for kind in INERTIAL)
    rubbing = load_robot(write('name = "x"\n[[joints]]\n[drives]\nside = "link"\nfriction = true'))
    assert standard_columns(rubbing) == (*(f"{kind}1" for kind in INERTIAL), "FS1", "FV1", "OFF1")
    assert rubbing.drives.side == "link"


@pytest.mark.parametrize("degrees", [-270, -180, -90, 0, 90, 180, 270, 30, 12.5])
def test_degrees_are_converted_exactly(write: Write, degrees: float) -> None:
    joint = load_robot(write(f'name = "x"\n[[joints]]\nalpha_deg = {degrees}\ntheta_deg = {degrees}')).joints[0]
    exact = degrees / 90 * (math.pi / 2) if degrees % 90 == 0 else math.radians(degrees)
    assert joint.alpha == joint.theta == exact


def test_nearly_special_geometry_is_snapped_and_noted(write: Write) -> None:
    near = math.degrees(1.5708)
    robot = load_robot(write(f'name = "x"\n[[joints]]\nalpha_deg = {near!r}\nd = 5e-7\nr = -0.25\n'))
    assert (robot.joints[0].alpha, robot.joints[0].d, robot.joints[0].r) == (math.pi / 2, 0.0, -0.25)
    assert robot.snapped == ("alpha1: 1.5708 taken as 1.57079633", "d1: 5e-07 taken as 0")


def test_geometry_that_is_not_special_is_kept(write: Write) -> None:
    robot = load_robot(write('name = "x"\n[[joints]]\nalpha_deg = 90.01\ntheta_deg = 0.006\nd = 2e-6\n'))
    assert robot.joints[0].alpha == math.radians(90.01)
    assert robot.joints[0].theta == math.radians(0.006)
    assert robot.joints[0].d == 2e-6
    assert robot.snapped == ()


def test_file_that_is_not_text(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes('name = "Stäubli"'.encode("latin-1"))
    with pytest.raises(InputError, match=r"latin\.toml: not UTF-8 text: save it as UTF-8"):
        load_robot(path)


def test_syntax_error_tells_the_line(write: Write) -> None:
    with pytest.raises(InputError, match=r"own\.toml: not valid TOML: .*line 3"):
        load_robot(write('name = "x"\n[[joints]]\nalpha_deg == 90\n'))


ONE = 'name = "x"\n[[joints]]\n'


CASES = [
    ("[[joints]]", "name", "missing: must be text"),
    ("name = 3\n[[joints]]", "name", "must be text, got 3"),
    ('name = "x"', "joints", r"give one \[\[joints\]\] table for each joint"),
    ('name = "x"\njoints = []', "joints", "give one"),
    ('name = "x"\njoints = {alpha_deg = 1}', "joints", "give one"),
    ('name = "x"\njoints = [1]', r"joints\[1\]", "must be a table"),
    (
        'nmae = "x"\n[[joints]]',
        "nmae",
        "unknown; known here: base, drives, flange, flange_in_payload_frame, gravity",
    ),
    ('gravity = [0, 0]\nname = "x"\n[[joints]]', "gravity", "list of 3 numbers"),
    ('lengths = 3\nname = "x"\n[[joints]]', "lengths", "must be a table"),
    (ONE + 'alpha_deg = "90"', r"joints\[1\].alpha_deg", "must be a finite number, got '90'"),
    (ONE + "alpha_deg = true", r"joints\[1\].alpha_deg", "must be a finite number, got True"),
    (ONE + "alpha_deg = nan", r"joints\[1\].alpha_deg", "must be a finite number, got nan"),
    (ONE + "alpha = 90", r"joints\[1\].alpha", "unknown; known here: acceleration_deg_s2"),
    (ONE + "[[joints]]\nbeta = 1", r"joints\[2\].beta", "unknown"),
    (ONE + 'd = "D7"', r"joints\[1\].d", r"no length 'D7' in \[lengths\]"),
    (ONE + "[lengths]\nD3 = false", "lengths.D3", "must be a finite number"),
    (ONE + 'kind = "helical"', r"joints\[1\].kind", "must be 'revolute' or 'prismatic'.*, got 'helical'"),
    (
        ONE + 'kind = "prismatic"\nspeed_deg_s = 1',
        r"joints\[1\].speed_deg_s",
        "a prismatic joint takes",
    ),
    (ONE + "position_m = [0, 1]", r"joints\[1\].position_m", "a revolute joint takes position_deg"),
    (ONE + "position_deg = [1]", r"joints\[1\].position_deg", "list of 2 numbers"),
    (ONE + "position_deg = [10, -10]", r"joints\[1\]", "leave no range"),
    (ONE + "speed_deg_s = 0", r"joints\[1\]", "speed limit must be positive"),
    (ONE + "[drives]\nfriction = 1", "drives.friction", "must be true or false"),
    (ONE + "[drives]\nbacklash = 1", "drives.backlash", "unknown"),
    (ONE + "[drives]\nside = 'gear'", "drives.side", "must be 'link' or 'motor'"),
    (ONE + "[drives]\nside = 'link'\nrotor_inertia = true", "drives.rotor_inertia", "link side do not see it"),
    (ONE + "[flange]\nrpy = [0, 0, 0]", "flange.rpy", "unknown; known here: rpy_deg, xyz"),
    (ONE + "[base]\nxyz = [0, 0]", "base.xyz", "list of 3 numbers"),
    ("rated_payload_kg = 0\n" + ONE, "robot", "rated payload must be positive"),
    (ONE + "[drives.coupling]\njoints = [1, 2]", "robot", "drives name joint 2"),
    (ONE + "[drives.coupling]\njoints = [1, 1]", "drives.coupling", "must differ"),
    (ONE + "[drives.coupling]\njoints = [1.5, 2]", r"drives.coupling.joints\[1\]", "whole number"),
    (ONE + "[drives.coupling]\njoints = [1, 2]\ncoulomb = 'x'", "drives.coupling.coulomb", "'paper' or 'sum'"),
    (ONE + "[drives.spring]\njoint = 1", "drives.spring", "either a table or"),
    (ONE + "[drives.spring]\njoint = 1.5\ntable = [[0, 0], [1, 1]]", "drives.spring.joint", "whole number"),
    (ONE + "[drives.spring]\nstiffness = 1", "drives.spring.joint", "missing: must be a whole number"),
    (ONE + "[drives.spring]\njoint = 1\ntable = [[0, 1, 2]]", r"drives.spring.table\[1\]", "list of 2 numbers"),
    (ONE + "[processing]\ncutoff = 5", "processing.cutoff", "unknown; known here: cutoff_hz"),
    (ONE + "[processing]\ncutoff_hz = -5", "processing", "cutoff must be positive"),
    (ONE + "[processing]\ndecimate = 2.5", "processing.decimate", "must be a whole number, got 2.5"),
    (ONE + '[parameters]\nM1 = "3"', "parameters.M1", "must be a finite number"),
    (ONE + "[parameters]\nM2 = 3", "parameters.M2", "not a standard parameter"),
    (ONE + "[parameters]\nXXR1 = 3", "parameters.XXR1", "not a standard parameter"),
]


@pytest.mark.parametrize(("text", "key", "problem"), CASES, ids=[key for _, key, _ in CASES])
def test_error_names_the_key(write: Write, text: str, key: str, problem: str) -> None:
    with pytest.raises(InputError, match=rf"own\.toml: key '{key}': .*{problem}") as error:
        load_robot(write(text))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"joints": ()}, "has no joints"),
        ({"gravity": (0.0, 0.0, math.inf)}, "three finite numbers"),
        ({"joints": (Joint(),), "gravity": (0.0, 0.0)}, "three finite numbers"),
    ],
)
def test_robots_that_cannot_be(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Robot(**{"name": "x", "joints": (Joint(),), **arguments})  # type: ignore[arg-type]


def test_joint_numbers_are_finite() -> None:
    with pytest.raises(ValueError, match="must be finite"):
        Joint(alpha=math.nan)


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("", (0.0, 0.05)),
        ("slow_fraction = 0.01", (0.01, 0.0)),
        ("slow_speed = 0.03", (0.0, 0.03)),
        ("slow_fraction = 0.01\nslow_speed = [0.03]", (0.01, (0.03,))),
    ],
)
def test_slow_rows_of_a_file(write: Write, lines: str, expected: tuple[float, float]) -> None:
    """A file that says nothing of slow rows leaves out those that friction is not known of."""
    settings = load_robot(write(f'name = "x"\n[processing]\n{lines}\n[[joints]]\n')).processing
    assert (settings.slow_fraction, settings.slow_speed) == expected


def test_slow_rows_of_a_joint_that_slides(write: Write) -> None:
    robot = load_robot(write('name = "x"\n[[joints]]\n[[joints]]\nkind = "prismatic"\n'))
    assert robot.processing.slow_speed == (0.05, 0.02)
