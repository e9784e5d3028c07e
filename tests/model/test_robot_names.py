"""Robots are found as people write their names; near names are asked back."""

from pathlib import Path

import pytest
from dynident.common.errors import InputError
from dynident.model import load_robot, robot_names


def test_names_of_shipped_robots(root: Path) -> None:
    assert robot_names() == tuple(sorted(path.stem for path in (root / "model/robots").glob("*.toml")))
    assert {"rx90", "tx40", "ur10e"} <= set(robot_names())
    assert [load_robot(name).name for name in robot_names()] == list(robot_names())


def test_unknown_robot_lists_the_known_ones() -> None:
    with pytest.raises(
        InputError, match=r"no robot 'rx91': did you mean 'rx90'\? give one of .*rx90, .*tx40, ur10e, .*or the path"
    ):
        load_robot("rx91")


@pytest.mark.parametrize("name", ["UR10e", "UR 10e", "ur-10e", "ur10e"])
def test_a_name_as_people_write_it(name: str) -> None:
    assert load_robot(name).name == "ur10e"


@pytest.mark.parametrize(("name", "meant"), [("ur10", "ur10e"), ("Pandda", "panda"), ("kr10", "kr10_r1100")])
def test_a_name_that_is_nearly_one(name: str, meant: str) -> None:
    with pytest.raises(InputError, match=rf"no robot '{name}': did you mean .*'{meant}'"):
        load_robot(name)


def test_folder_is_no_robot(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no robot"):
        load_robot(tmp_path)


@pytest.mark.parametrize("name", robot_names())
def test_a_shipped_name_is_found_as_people_write_it(name: str) -> None:
    for written in (name.upper(), name.replace("_", "-"), name.replace("_", " "), f"{name[:2]} {name[2:]}"):
        assert load_robot(written) == load_robot(name), written


@pytest.mark.parametrize(
    ("name", "meant"),
    [("ur10", "ur10e"), ("UR10E2", "ur10e"), ("kuka", "kr6_r900"), ("Franka", "fr3"), ("stäubli", "rx90")],
)
def test_a_name_that_is_none_tells_what_may_be_meant(name: str, meant: str) -> None:
    with pytest.raises(InputError, match=f"did you mean .*'{meant}'"):
        load_robot(name)


def test_a_name_far_from_all_is_not_guessed() -> None:
    with pytest.raises(InputError, match="no robot 'toaster': give one of fr3"):
        load_robot("toaster")


@pytest.mark.parametrize("path", ["ur10e.toml", "arms/ur10e", "ur10e.urdf"])
def test_a_missing_file_is_called_missing(path: str) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_robot(path)
