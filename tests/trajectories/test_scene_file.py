"""Scenes from TOML: read whole, or refused with the key at fault."""

from pathlib import Path

import pytest
from dynident.common.errors import InputError
from dynident.trajectories import Scene, read_scene
from dynident.trajectories.design.scene import Capsule, HalfSpace

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
        (
            "clearance = 0.02",
            "clearence = 0.02",
            "'clearence': unknown; known here: bodies, .*; did you mean 'clearance'",
        ),
        ("clearance = 0.02", "clearance = '2 cm'", "'clearance': must be a number"),
        ("radius = 0.2\n", "", r"'bodies\[1\].radius': missing: must be a number"),
        ("radius = 0.2\n", "radius = -1\n", "'column'"),
        ("radius = 0.2\n", "radius = 0.2\ncolour = 'red'\n", r"'bodies\[1\].colour': unknown"),
        ("link = 2", "link = 2.5", r"'bodies\[2\].link': must be a whole number"),
        ("link = 2", "link = true", r"'bodies\[2\].link': must be a whole number"),
        ("end = [0.45, 0, 0]", "end = [0.45, 0]", r"'bodies\[2\].end': must be a list of 3 numbers"),
        ("[0, -1.0, 0]", "[0, 0, 0]", "'wall' needs a normal"),
        ('name = "wall"', "name = 3", r"'surfaces\[2\].name': must be text"),
        ('[["tool", "column"]]', '[["tool", "post"]]', "no body or surface 'post'"),
        ('[["tool", "column"]]', '["tool", "column"]', r"'pairs\[1\]': must be a list of 2 texts"),
        ('[["upper arm", "floor"]]', "7", "'may_touch': must be pairs"),
        ('name = "wall"', 'name = "floor"', "the same name"),
        ("[[surfaces]]", "[surfaces", "not valid TOML"),
        ("[[bodies]]", "[bodies]", "not valid TOML"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in WHOLE
    with pytest.raises(InputError, match=words) as caught:
        read_scene(write(tmp_path, WHOLE.replace(old, new)))
    assert "scene.toml" in str(caught.value)
