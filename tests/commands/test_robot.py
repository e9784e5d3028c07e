"""``dynident robot``: arms listed, shown, described and checked; one's own, and every shipped one, at work."""

import json
import re
from dataclasses import astuple, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from dynident.apps.logs import ToolColumns, read_tool_poses
from dynident.apps.logs.map import LogMap
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters, Recording, Robot, load_robot, robot_names, with_stand_in
from dynident.tests.commands.typed import answered, refused, typed
from dynident.tests.frozen.inputs import EXAMPLES
from dynident.trajectories import Simulator, random_via_points
from scipy.spatial.transform import Rotation

NEW = (
    "robot new --name kr --joint=-z,0,0,0.4 --joint y,0.025,0,0.4 --joint y,0.025,0,0.855 --joint=-x,0.025,0,0.89 "
    "--joint y,0.445,0,0.89 --joint=-x,0.525,0,0.89 --flange 0.525,0,0.89,x,-z drawn-at=0,-90,90,0,0,0 "
    "--limits=-170:170:360,-190:45:300,-120:156:360,-185:185:381,-120:120:388,-350:350:615 --rated-payload 6"
)


def test_new_robot_is_the_shipped_one(here: Path) -> None:
    """Described in the home pose of the sheet, it is the arm that was read from a description at zero."""
    ended = typed(f"{NEW} --out kr.toml")
    assert ended.status == 0
    assert "Compare the drawing" in ended.out
    ElementTree.parse("kr.svg")
    robot, shipped = load_robot("kr.toml"), load_robot("kr6_r900")
    assert robot.rated_payload == 6.0
    np.testing.assert_allclose(robot.flange.R, shipped.flange.R, atol=1e-12)
    for ours, theirs in zip(robot.joints, shipped.joints, strict=True):
        numbers = ((j.alpha, j.theta, j.d, j.r, *j.limits.position, j.limits.speed) for j in (ours, theirs))
        assert next(numbers) == pytest.approx(next(numbers), abs=1e-12)
    assert "is there already" in refused(f"{NEW} --out kr.toml")
    assert typed(f"{NEW} --out kr.toml --overwrite").status == 0


def test_the_template_loads_as_it_stands(here: Path) -> None:
    """Printed or written, it is a robot, and options beside it are refused."""
    line = "robot new --template"
    assert typed(f"{line} --out arm.toml").status == 0
    assert Path("arm.toml").read_text(encoding="utf-8") == typed(line).out
    robot = load_robot("arm.toml")
    assert (robot.name, robot.n, robot.joints[2].kind, robot.rated_payload) == ("my_arm", 3, "prismatic", 5.0)
    assert typed("robot show --robot arm.toml").status == 0
    assert "is there already" in refused(f"{line} --out arm.toml")
    assert "--name belongs to a robot by options" in refused(f"{line} --name kr")


@pytest.fixture(scope="module")
def recorded() -> Recording:
    """An RX90's unloaded recording."""
    robot = load_robot("rx90")
    return Simulator(robot).record(random_via_points(robot, 8, seed=5).motion(100.0), None, [0.5] * 6, 1)


def write(log: Recording, positions: Array, names: str = "x,y,z") -> None:
    """A log of joints and of more columns, without torques."""
    header = ",".join(["t", *(f"q{j}" for j in range(1, 7)), names])
    table = np.column_stack([log.t, log.q, positions])
    np.savetxt("log.csv", table, delimiter=",", header=header, comments="", fmt="%.12g")


SHEET = (
    "robot new --name own --joint z,0,0,0 --joint=y,0.05,0,0.4 --joint=y,0.05,0,0.8 --joint=x,0.2,0,0.85 "
    "--joint=y,0.45,0,0.85 --joint=x,0.45,0,0.85 --flange 0.53,0,0.85,x,-z --out own.toml"
)
KNOWN = (
    "--limits=-170:170:220:900:300,-90:120:200:900:300,-100:80:220:900:150,-190:190:320:1500:50,"
    "-115:115:320:1500:40,-350:350:420:2000:30 --rated-payload 5"
)
URDF = EXAMPLES / "robots/six_axis.urdf"


def bodiless(text: str, *links: str) -> str:
    """A URDF without the bodies of some links, or of all."""
    for link in links or ("link[1-6]",):
        text = re.sub(rf'(<link name="{link}">)\s*<inertial>.*?</inertial>', r"\1", text, flags=re.DOTALL)
    return text


OF_URDF = {"acceleration", "torque", "parameters"}
WHOLE = URDF.read_text()
ARMS: dict[str, tuple[str, str, set[str]]] = {
    "all known but bodies": (f"{KNOWN} --mass 30", "", {"parameters"}),
    "mass alone": ("--mass 30", "", {"position", "speed", *OF_URDF}),
    "mass given to the command": (KNOWN, "--arm-mass 30", {"parameters"}),
    "a URDF": (WHOLE, "", OF_URDF),
    "a URDF without some bodies": (bodiless(WHOLE, "link2", "link6"), "", OF_URDF),
    "a URDF without bodies": (bodiless(WHOLE), "--arm-mass 60", OF_URDF),
}
"""Knowledge of an arm: by ``robot new``, or a URDF; what is told to a command beside it; what is assumed."""


def described(arm: str) -> str:
    """The arm's file."""
    if arm.startswith("--"):
        assert typed(f"{SHEET} {arm}").status == 0
        return "own.toml"
    Path("own.urdf").write_text(arm, encoding="utf-8")
    return "own.urdf"


@pytest.mark.parametrize("name", ARMS)
def test_what_is_known_stays_and_the_rest_can_exist(here: Path, name: str) -> None:
    """Every limit is finite, every link a body; a number of the file is never replaced."""
    arm, more, lacking = ARMS[name]
    known = load_robot(described(arm))
    robot = with_stand_in(replace(known, mass=float(more.split()[1])) if more else known)
    assert set(robot.assumed()) == lacking
    assert known.parameters.items() <= robot.parameters.items()
    for link, (joint, before) in enumerate(zip(robot.joints, known.joints, strict=True), start=1):
        numbers, stated = (np.hstack(astuple(limits)) for limits in (joint.limits, before.limits))
        assert np.isfinite(numbers).all()
        np.testing.assert_array_equal(numbers[np.isfinite(stated)], stated[np.isfinite(stated)])
        body = InertialParameters(np.array([robot.parameters[f"{kind}{link}"] for kind in INERTIAL]))
        assert body.min_pseudo_inertia_eigenvalue > 0.0
        assert robot.parameters[f"IA{link}"] > 0.0
    if "acceleration" in lacking:
        speeds, accelerations = np.array([(j.limits.speed, j.limits.acceleration) for j in robot.joints]).T
        np.testing.assert_allclose(accelerations, 10.0 * speeds)


@pytest.mark.parametrize("line", ["simulate --out out", "near --pose=0,-45,60,0,45,0 --joints 2,3,5,6"])
def test_without_a_mass_one_line_names_the_option(here: Path, line: str) -> None:
    for arm in (re.sub(r":\d+:\d+(?=,| )", "", KNOWN), bodiless(WHOLE)):
        assert "--arm-mass KG" in refused(f"{line} --robot {described(arm)}")


def half_the_rating(robot: Robot) -> str:
    """A payload file."""
    mass = 0.5 * robot.rated_payload
    moments = ", ".join(f"{value * mass:.6g}" for value in (0.004, 0, 0, 0.003, 0, 0.002))
    return f"mass = {mass:g}\ncom = [0.02, -0.02, 0.08]\ninertia_com = [{moments}]\n"


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name in ("panda", "ur10e") else name for name in robot_names()],
)
@pytest.mark.usefixtures("hasty")
def test_an_arm_goes_through_every_command(name: str, here: Path) -> None:
    """With noise: shown, moved, simulated, checked, weighed, identified, written for a controller."""
    robot = load_robot(name)
    (here / "load.toml").write_text(half_the_rating(robot), encoding="utf-8")
    shown = typed(f"robot show --robot {name}")
    assert shown.status == 0
    assert "assumed" in shown.out
    assert "Mass of the arm" in shown.out
    ranges = np.degrees([joint.limits.position for joint in robot.joints])
    pose = ",".join(f"{value:.1f}" for value in ranges.mean(axis=1) + 0.075 * np.ptp(ranges, axis=1))
    joints = "2,4,6,7" if robot.n == 7 else "2,3,5,6"
    assumed = robot.assumed("acceleration", "torque") | with_stand_in(robot).assumed("parameters")
    for line in (
        f"near --pose={pose} --joints {joints} --range 20 --duration 5 --samples near.csv",
        "design --fourier 3 --duration 8 --speed-override 0.8 --starts 1 --samples wide.csv",
    ):
        document, text = answered(f"{line} --robot {name} sample-rate=100", status=(0, 1))
        assert document["assumed"] == assumed
        assert not robot.assumed("torque") or "torque limits" in text
    motions = "--trajectory wide.csv --trajectory near.csv --payload load.toml"
    simulated = typed(f"simulate --robot {name} {motions} --rate 100 --noise 0.02 --out logs")
    assert simulated.status == 0, simulated.err
    assert robot.parameters or "Assumed" in simulated.out
    # The TX40's own recording comes at 1 kHz.
    arm = f"--robot {name}" + (" equation-rate=20" if robot.processing.decimate > 50 else "")
    wide, near = (f"--unloaded logs/{x}_unloaded.csv --loaded logs/{x}_loaded.csv" for x in ("wide", "near"))
    # A page is drawn of the same numbers whatever arm they are of: one of seven joints, and one of coupled drives.
    page = "--report payload.html" if name in ("panda", "rx90") else ""
    answered(f"check {arm} logs/wide_unloaded.csv logs/wide_loaded.csv", status=(0, 1))
    payload, weighed = (
        answered(line, status=(0, 1)).document for line in (f"payload {arm} {wide} {page}", f"weigh {arm} {near}")
    )
    answered(f"identify {arm} --data logs/wide_unloaded.csv --constrained base", status=(0, 1))
    for document in (payload, weighed):
        method = document["recommended"]["method"]
        best = [estimate for estimate in document["estimates"] if estimate["method"] == method][-1]
        assert best["parameters"]["M"] == pytest.approx(0.5 * robot.rated_payload, rel=0.15)
    (here / "payload.json").write_text(json.dumps(payload))
    controller = {"ur10e": "ur", "panda": "franka", "tx40": "staubli", "rx90": "staubli"}.get(name, "kuka")
    exported = typed(f"export payload.json --to {controller} --despite-verdict")
    assert exported.status == 0, exported.err
    assert exported.out


def test_a_still_tool_is_refused(recorded: Recording, here: Path) -> None:
    write(recorded, np.full((len(recorded.t), 3), 0.4))
    assert "moves by less than 50 mm" in refused("robot check --robot rx90 --data log.csv")


def test_tool_poses_in_millimetres_and_degrees(rx90: Robot, recorded: Recording, here: Path) -> None:
    values = np.random.default_rng(0).uniform(-1.0, 1.0, (len(recorded.t), 6))
    write(recorded, values * np.repeat([1000.0, 180.0 / np.pi], 3), "x,y,z,a,b,c")
    columns = ToolColumns(("x", "y", "z"), "mm", ("a", "b", "c"), "rotation_vector", "deg")
    poses = read_tool_poses("log.csv", rx90, LogMap(pose=columns))
    assert poses is not None
    assert poses.rotations is not None
    assert np.allclose(poses.positions, values[:, :3])
    assert np.allclose(poses.rotations, Rotation.from_rotvec(values[:, 3:]).as_matrix())


def test_logs_that_do_not_hold_the_pose(rx90: Robot, recorded: Recording, here: Path) -> None:
    write(recorded, np.zeros((len(recorded.t), 1)), "other")
    assert read_tool_poses("log.csv", rx90) is None
    with pytest.raises(InputError, match="column a is missing"):
        read_tool_poses("log.csv", rx90, LogMap(pose=ToolColumns(("a", "q1", "q2"))))
    write(recorded, np.zeros((len(recorded.t), 7)), "x,y,z,qx,qy,qz,qw")
    with pytest.raises(InputError, match="line 2, columns qx, qy, qz, qw: a quaternion of length 0"):
        read_tool_poses("log.csv", rx90)
