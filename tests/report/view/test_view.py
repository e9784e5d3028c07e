"""The view in three dimensions without a browser: links, meshes, sizes of bodies, what the file holds."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from dynident.apps.view import html_of
from dynident.apps.view.moving import Shape, box, capsule, coarse, ellipsoid, inertia_axes, plane, view_of
from dynident.cli import main
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import InertialParameters, Motion, Pose, Robot, load_robot, robot_names
from dynident.model.files.urdf import load_urdf
from dynident.model.frames import link_frames
from dynident.tests.conftest import PRISMATIC

pytestmark = pytest.mark.filterwarnings("ignore:Setting the shape on a NumPy array")  # pycollada, from NumPy 2.5 on
DRAW = np.random.default_rng(3)
BODY = InertialParameters.from_com(4.0, [0.01, 0.02, 0.1], [0.03, 0.02, 0.01])
PAYLOAD = np.array([[0.0, 0.02], [0.017, 0.023], [0.09, 0.112]]), BODY


def motion(robot: Robot, count: int = 5) -> Motion:
    """Random positions within the ranges, a turn or a metre where there are none."""
    low, high = np.clip(np.array([joint.limits.position for joint in robot.joints]), -1.0, 1.0).T
    q = DRAW.uniform(low, high, (count, robot.n))
    return Motion(np.arange(float(count)), q, np.zeros_like(q), np.zeros_like(q))


def ends(shape: Shape) -> tuple[Array, Array]:
    """End and start of a capsule's axis, from its first corner, the start's pole, and the other pole."""
    last = shape.mesh.vertices[0]
    first = shape.mesh.vertices[np.argmax(np.linalg.norm(shape.mesh.vertices - last, axis=1))]
    z = (first - last) / np.linalg.norm(first - last)
    below = (first - shape.mesh.vertices)[(first - shape.mesh.vertices) @ z > 1e-6]
    radius = (np.sum(below**2, axis=1) / (2.0 * below @ z)).min()  # of the sphere through the pole and a corner
    return first - radius * z, last + radius * z


def positions(robot: Robot, q: Array) -> list[Array]:
    """Origins of frames 0 to n and of the payload's, by the symbolic chain of the dynamics."""
    base = robot.base.inverse()
    frames = [(np.array(ca.DM(R)), np.array(ca.DM(p)).ravel()) for R, p in link_frames(robot, ca.SX(q.tolist()))]
    places = [base.p + base.R @ p for _, p in frames]
    return [*places, places[-1] + base.R @ frames[-1][0] @ robot.flange.p]


@pytest.mark.parametrize(
    "robot", [*map(load_robot, robot_names()), *PRISMATIC.values()], ids=lambda robot: robot.name
)
def test_links_reach_from_each_frame_to_the_next(robot: Robot) -> None:
    """Within 1 um of forward kinematics; the rail of a sliding joint goes by it."""
    moving = motion(robot)
    view = view_of(robot, moving)
    links = {shape.name: shape for shape in view.shapes if shape.name.startswith("link")}
    for frames, q in zip(view.frames, moving.q, strict=True):
        expected = positions(robot, q)
        for j in range(robot.n):
            corner, start = ends(links[f"link {j}/along x"])
            assert np.abs(at(frames[j], start) - expected[j]).max() < 1e-6
            near = [ends(links[f"link {j}/along axis {j + 1}"])[k] for k in (0, 1)]
            gap = apart(expected[j + 1], *(at(frames[j], end) for end in near))
            assert gap < 1e-6, "the next frame lies on the part along its axis"
            assert apart(at(frames[j], corner), *(at(frames[j], end) for end in near)) < 1e-6
        assert np.abs(view.path - expected[-1]).max(axis=1).min() < 1e-9, "the path goes through it"
        tip = links[f"link {robot.n}/flange"]
        assert min(np.abs(at(frames[robot.n], end) - expected[-1]).max() for end in ends(tip)) < 1e-6


def at(pose: Pose, point: Array) -> Array:
    return np.asarray(pose.p + pose.R @ point)


def apart(point: Array, a: Array, b: Array) -> float:
    """Distance from a point to the line between two others."""
    way = b - a
    share = np.clip((point - a) @ way / max(float(way @ way), 1e-30), 0.0, 1.0)
    return float(np.linalg.norm(point - a - share * way))


def test_shapes_are_closed_and_as_large_as_they_should_be() -> None:
    start, end, axes = np.array([0.1, 0.0, 0.2]), np.array([0.4, -0.3, 0.1]), np.diag([0.1, 0.2, 0.3])
    full = np.pi * 0.05**2 * np.linalg.norm(end - start) + 4.0 / 3.0 * np.pi * 0.05**3
    assert capsule(start, end, 0.05).volume == pytest.approx(full, rel=0.05)
    assert capsule(start, start, 0.05).volume == pytest.approx(4.0 / 3.0 * np.pi * 0.05**3, rel=0.05)
    assert ellipsoid(start, axes).volume == pytest.approx(4.0 / 3.0 * np.pi * 0.006, rel=0.05)
    assert box(start, axes).volume == pytest.approx(8.0 * 0.006)
    corners = plane((0.0, 0.6, 0.8), 0.5, 1.0).vertices
    assert (corners @ [0.0, 0.6, 0.8]).max() == pytest.approx(0.5)


def test_the_payloads_ellipsoids_are_to_scale() -> None:
    """Half axes are half the 95 % interval; a homogeneous ellipsoid of the drawn axes has the inertia."""
    view = view_of(load_robot("ur10e"), motion(load_robot("ur10e"), 2), payload=PAYLOAD)
    drawn = {shape.name: shape for shape in view.shapes}
    centre = drawn["centre of mass, 95 %"]
    assert np.allclose(centre.mesh.vertices[:, 2].min(), 0.09, atol=1e-12)
    assert np.allclose(centre.mesh.vertices[:, 2].max(), 0.112, atol=1e-12)
    assert np.allclose(np.ptp(centre.mesh.vertices, axis=0), [0.02, 0.006, 0.022], rtol=0.01)
    body = InertialParameters.from_com(3.0, [0, 0, 0], [[0.03, 0.004, 0], [0.004, 0.02, 0.001], [0, 0.001, 0.04]])
    axes = inertia_axes(3.0, body.inertia_com)
    second = 3.0 / 5.0 * axes @ axes.T
    assert np.allclose(np.trace(second) * np.eye(3) - second, body.inertia_com, atol=1e-12)
    unknown = np.full((3, 2), np.nan), None
    names = [
        shape.name for shape in view_of(load_robot("ur10e"), motion(load_robot("ur10e"), 2), payload=unknown).shapes
    ]
    assert not any("mass" in name or "inertia" in name for name in names)


def test_without_the_extra_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Any
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r"pip install 'dynident\[view\]'"):
        html_of(view_of(load_robot("ur10e"), motion(load_robot("ur10e"), 2)))
    for option in ("--view=-", f"--view={tmp_path / 'a.html'}"):
        assert main(["robot", "show", "--robot", "ur10e", option]) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


LINKS = {
    "base": ('<origin xyz="0 0 .1"/>', "package://arm_description/meshes/ball.stl", ""),
    "upper": ('<origin xyz=".5 0 0" rpy="0 0 1.5707963"/>', "../meshes/beam.obj", 'scale=".001 .001 .001"'),
    "lower": ("", "{file}", ""),
    "tool0": ("", "../meshes/gripper.dae", ""),
}
JOINTS = {"shoulder": ("base", "upper", "0 0 .2", "0 0 1"), "elbow": ("upper", "lower", "1 0 0", "0 1 0")}


@pytest.fixture
def described(tmp_path: Path) -> Callable[[str], Robot]:
    """``described(file)``: an arm of two joints whose last link looks like ``file``, with a gripper fixed to it."""
    trimesh = pytest.importorskip("trimesh")
    root = tmp_path / "arm_description"
    (root / "meshes").mkdir(parents=True)
    (root / "urdf").mkdir()
    trimesh.creation.icosphere(subdivisions=3, radius=0.1).export(root / "meshes/ball.stl")
    trimesh.creation.box((1000.0, 100.0, 100.0)).export(root / "meshes/beam.obj")
    trimesh.creation.cylinder(0.05, 0.3).export(root / "meshes/gripper.dae")
    (root / "meshes/broken.stl").write_text("no mesh")

    def arm(file: str) -> Robot:
        links = "".join(
            f'<link name="{name}"><visual>{origin}<geometry><mesh filename="{mesh.format(file=file)}" {more}/>'
            "</geometry></visual></link>"
            for name, (origin, mesh, more) in LINKS.items()
        )
        joints = "".join(
            f'<joint name="{name}" type="revolute"><parent link="{above}"/><child link="{below}"/>'
            f'<origin xyz="{at}"/><axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="9"/></joint>'
            for name, (above, below, at, axis) in JOINTS.items()
        )
        fixed = (
            '<joint name="f" type="fixed"><parent link="lower"/><child link="tool0"/><origin xyz=".4 0 0"/></joint>'
        )
        (root / "urdf/arm.urdf").write_text(f'<robot name="arm">{links}{joints}{fixed}</robot>')
        return load_urdf(root / "urdf/arm.urdf")

    return arm


def test_meshes_stand_where_the_links_are(described: Callable[[str], Robot], tmp_path: Path) -> None:
    """By the URDF's own transforms with both joints turned, to the millimetre's rounding of the files."""
    robot = described(f"file://{tmp_path}/arm_description/meshes/ball.stl")
    q = np.array([[0.5 * np.pi, -0.5 * np.pi]])
    view = view_of(robot, Motion(np.zeros(1), q, 0.0 * q, 0.0 * q))
    assert view.notes == ()
    assert not any("along" in shape.name or "flange" in shape.name for shape in view.shapes)
    middle, size = {}, {}
    for shape in view.shapes:
        if "mesh" in shape.name:
            pose = view.frames[0][shape.frame]
            places = shape.mesh.vertices @ pose.R.T + pose.p
            middle[shape.name] = 0.5 * (places.min(axis=0) + places.max(axis=0))
            size[shape.name] = np.ptp(places, axis=0)
    # The upper link points along y, the lower one, turned by -90 degrees about its own y, upwards.
    expected = {
        "link 0/mesh 1": ([0.0, 0.0, 0.1], [0.2, 0.2, 0.2]),
        "link 1/mesh 1": ([0.0, 0.5, 0.2], [1.0, 0.1, 0.1]),
        "link 2/mesh 1": ([0.0, 1.0, 0.2], [0.2, 0.2, 0.2]),
        "link 2/mesh 2": ([0.0, 1.0, 0.6], [0.1, 0.3, 0.1]),
    }
    assert set(middle) == set(expected)
    for name, (place, extent) in expected.items():
        assert middle[name] == pytest.approx(place, abs=2e-3), name
        assert sorted(size[name]) == pytest.approx(sorted(extent), abs=4e-3), name


def test_a_coarse_mesh_keeps_its_form() -> None:
    trimesh = pytest.importorskip("trimesh")
    sphere = trimesh.creation.icosphere(subdivisions=6, radius=0.1)
    fewer = coarse(sphere, 6000)
    assert 1000 < len(fewer.faces) <= 6000
    radius = np.linalg.norm(fewer.vertices, axis=1)
    assert 0.098 < radius.min() <= radius.max() <= 0.1 + 1e-9
    few = ellipsoid(np.zeros(3), np.eye(3))
    assert np.array_equal(coarse(few, len(few.faces)).vertices, few.vertices)
