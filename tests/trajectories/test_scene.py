"""Scenes from TOML; distances of their bodies against brute force, and their slopes."""

from pathlib import Path

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import load_robot, robot_names
from dynident.model.frames import frames_at
from dynident.trajectories import Scene, read_scene
from dynident.trajectories.design.scene import Capsule, HalfSpace, clearance, usual_scene
from dynident.trajectories.motions.family import Samples

ROBOT = load_robot("rx90")
SCENE = Scene(
    (
        Capsule("column", 0, 0.2, (0.0, 0.0, -0.42), (0.0, 0.0, 0.1)),
        Capsule("upper arm", 2, 0.12, (0.0, 0.0, 0.0), (0.45, 0.0, 0.0)),
        Capsule("forearm", 4, 0.1, (0.0, 0.0, -0.45), (0.0, 0.0, 0.0)),
        Capsule("tool", 6, 0.12, (0.0, 0.0, 0.2)),
        Capsule("ball", 0, 0.05, (0.5, 0.5, 0.5)),
    ),
    (HalfSpace("floor", (0.0, 0.0, 2.0), -0.42),),
    (("tool", "column"), ("forearm", "column"), ("column", "forearm"), ("tool", "ball")),
    (("upper arm", "floor"),),
)


def state(q: Array) -> Samples:
    return Samples(np.ones(len(q)), q, 0 * q, 0 * q)


def axis_points(body: Capsule, q: Array) -> Array:
    pose = frames_at(ROBOT, q.tolist())[body.link]
    start, end = np.array(body.start), np.array(body.end or body.start)
    return np.asarray(pose.p + (start + np.linspace(0, 1, 401)[:, None] * (end - start)) @ pose.R.T)


def test_distances_are_those_of_dense_points() -> None:
    q = np.random.default_rng(0).uniform(-2.5, 2.5, (20, 6))
    limit = clearance(ROBOT, SCENE)
    distances = dict(zip(limit.labels, (0.1 * limit.values(state(q))).T, strict=True))
    bodies = {body.name: body for body in SCENE.bodies}
    for a, b in SCENE.pairs:
        for k, pose in enumerate(q):
            gap = axis_points(bodies[a], pose)[:, None] - axis_points(bodies[b], pose)[None]
            apart = np.linalg.norm(gap, axis=2).min() - bodies[a].radius - bodies[b].radius
            assert distances[f"{a} to {b}"][k] == pytest.approx(apart, abs=1e-3)
    heights = [axis_points(bodies["forearm"], pose)[[0, -1], 2] + 0.42 - 0.1 for pose in q]
    assert np.allclose(distances["forearm, start, to floor"], np.array(heights)[:, 0])
    assert np.allclose(distances["forearm, end, to floor"], np.array(heights)[:, 1])
    assert not any("upper arm" in label and "floor" in label for label in limit.labels)
    assert not any(label.startswith("column") and "floor" in label for label in limit.labels)


def test_slopes_are_derivatives() -> None:
    draw, step = np.random.default_rng(1), 1e-6
    q, limit = draw.uniform(-2.0, 2.0, (15, 6)), clearance(ROBOT, SCENE)
    seed, direction = draw.standard_normal((15, len(limit.labels))), draw.standard_normal(q.shape)
    slopes = Samples(*map(np.zeros_like, state(q)))
    limit.measure(state(q))[1](seed, slopes)
    change = limit.values(state(q + step * direction)) - limit.values(state(q - step * direction))
    assert np.sum(slopes.q * direction) == pytest.approx(np.sum(seed * change) / (2 * step), rel=1e-6)


WHOLE = """
clearance = 0.02
pairs = [["tool", "column"]]
may_touch = [["upper arm", "floor"]]

[[surfaces]]
name = "floor"
offset = -0.42

[[surfaces]]
name = "wall"
normal = [0, -1.0, 0]
offset = -1.5

[[bodies]]
name = "column"
link = 0
radius = 0.2
start = [0, 0, -0.42]
end = [0, 0, 0.1]

[[bodies]]
name = "upper arm"
link = 2
radius = 0.12
end = [0.45, 0, 0]

[[bodies]]
name = "tool"
link = 6
radius = 0.12
start = [0, 0, 0.2]
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text)
    return path


def test_everything_is_read(tmp_path: Path) -> None:
    assert read_scene(write(tmp_path, WHOLE)) == Scene(
        (
            Capsule("column", 0, 0.2, (0.0, 0.0, -0.42), (0.0, 0.0, 0.1)),
            Capsule("upper arm", 2, 0.12, (0.0, 0.0, 0.0), (0.45, 0.0, 0.0)),
            Capsule("tool", 6, 0.12, (0.0, 0.0, 0.2)),
        ),
        (HalfSpace("floor", (0.0, 0.0, 1.0), -0.42), HalfSpace("wall", (0.0, -1.0, 0.0), -1.5)),
        (("tool", "column"),),
        (("upper arm", "floor"),),
        0.02,
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("radius = 0.2\n", "radius = -1\n", "'column'"),
        ("[0, -1.0, 0]", "[0, 0, 0]", "'wall' needs a normal"),
        ('[["tool", "column"]]', '[["tool", "post"]]', "no body or surface 'post'"),
        ('[["upper arm", "floor"]]', "7", "'may_touch': must be pairs"),
        ('name = "wall"', 'name = "floor"', "the same name"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in WHOLE
    with pytest.raises(InputError, match=words) as caught:
        read_scene(write(tmp_path, WHOLE.replace(old, new)))
    assert "scene.toml" in str(caught.value)


@pytest.mark.parametrize("name", [name for name in robot_names() if name != "rx90"])
def test_an_arm_without_a_floor_still_keeps_off_itself(name: str) -> None:
    robot = load_robot(name)
    at_rest = np.mean([joint.limits.position for joint in robot.joints], axis=1)[None]
    with_floor, without = filter(None, (usual_scene(robot, at_rest, floor) for floor in (True, False)))
    assert (without.pairs, without.surfaces) == (with_floor.pairs, ())
