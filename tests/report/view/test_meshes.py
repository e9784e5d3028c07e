"""A URDF's meshes in the view: where they stand, how large the page gets, what is said where one is missing."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.view import view_of
from dynident.apps.view.shapes import coarse, ellipsoid
from dynident.model import Motion, Robot
from dynident.model.files.urdf import load_urdf

trimesh = pytest.importorskip("trimesh")
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


def still(q: list[float]) -> Motion:
    at = np.array([q])
    return Motion(np.zeros(1), at, np.zeros_like(at), np.zeros_like(at))


def test_meshes_stand_where_the_links_are(described: Callable[[str], Robot], tmp_path: Path) -> None:
    """By the URDF's own transforms with both joints turned, to the millimetre's rounding of the files."""
    robot = described(f"file://{tmp_path}/arm_description/meshes/ball.stl")
    view = view_of(robot, still([0.5 * np.pi, -0.5 * np.pi]))
    assert view.notes == ()
    assert not any("along" in shape.name or "flange" in shape.name for shape in view.shapes)
    middle, size = {}, {}
    for shape in view.shapes:
        if "mesh" in shape.name:
            pose = view.frames[0][shape.frame]
            places = shape.vertices @ pose.R.T + pose.p
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
    sphere = trimesh.creation.icosphere(subdivisions=6, radius=0.1)
    vertices, faces = coarse(np.asarray(sphere.vertices), np.asarray(sphere.faces, dtype=np.uint32), 6000)
    assert 1000 < len(faces) <= 6000
    radius = np.linalg.norm(vertices, axis=1)
    assert 0.098 < radius.min() <= radius.max() <= 0.1 + 1e-9
    few = ellipsoid(np.zeros(3), np.eye(3))
    assert coarse(*few, len(few[1])) is not None
    assert np.array_equal(coarse(*few, len(few[1]))[0], few[0])
