"""Files of xacro, and names of robot_descriptions, from a cache laid out as that package lays out its own."""

import sys
from math import pi
from pathlib import Path

import pytest
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.tests.model.urdf_files import dressed_urdf

pytest.importorskip("robot_descriptions")
pytest.importorskip("xacro")

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
