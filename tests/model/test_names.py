"""Names and texts of robots: what cannot be seen is refused, all else goes into every file as it is."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from dynident.common.errors import InputError
from dynident.common.schema import toml_text
from dynident.model import Robot, load_robot
from dynident.model.files.robot_file import robot_toml

SEEN = ("[/x] [bold]", "<b>&\"'</b>-->", "Ünï 日本 \U0001f916", "a/b\\c", "*/ x", "%s{}", "-x", '"""', "x" * 3000)
UNSEEN = ("", "  ", "a\x00", "a\x01b", "a\x1b[31mb", "a\x07", "a\rb", "a\x7f", "a\x9bb")
"""Of which the first two, and ends of lines, are fine in a text."""


@pytest.mark.parametrize("text", SEEN)
def test_a_name_that_can_be_seen_comes_back(text: str, rx90: Robot, tmp_path: Path) -> None:
    named = replace(rx90, name=text, title=text, payload_frame=text, joint_names=((text,) * 6,))
    (tmp_path / "own.toml").write_text(robot_toml(named, text), encoding="utf-8")
    again = load_robot(tmp_path / "own.toml")
    assert (again.name, again.title, again.payload_frame) == (text, text, text)
    assert again.joint_names == named.joint_names


@pytest.mark.parametrize("text", UNSEEN)
def test_a_name_that_cannot_be_seen_is_refused(text: str, rx90: Robot, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="is no name"):
        replace(rx90, name=text)
    with pytest.raises(ValueError, match="is no name"):
        replace(rx90, joint_names=((*"abcde", text),))
    (tmp_path / "own.toml").write_text(toml_text({"name": text, "joints": [{"alpha_deg": 0}]}), encoding="utf-8")
    with pytest.raises(InputError, match=r"own\.toml: key 'robot': .* is no name: give letters that can be seen"):
        load_robot(tmp_path / "own.toml")


@pytest.mark.parametrize("text", UNSEEN[2:])
def test_a_text_with_control_letters_is_refused(text: str, rx90: Robot) -> None:
    with pytest.raises(ValueError, match="holds control letters"):
        replace(rx90, title=text)
    with pytest.raises(ValueError, match="holds control letters"):
        replace(rx90, payload_frame=text)
    with pytest.raises(ValueError, match="holds control letters"):
        replace(rx90, sources={"mass": text})
    assert replace(rx90, title="two\nlines\tof it", payload_frame="two\nlines").title


def test_xml_reads_what_is_not_refused(rx90: Robot) -> None:
    """Each single letter that a title may hold, but for halves of letters."""
    letters = [chr(code) for code in (*range(0x300), 0x2028, 0x202E, 0xFEFF)]
    for letter in letters:
        try:
            title = replace(rx90, title=f"a{letter}b").title
        except ValueError:
            continue
        ElementTree.fromstring(f"<r>{title.replace('&', '').replace('<', '')}</r>".encode())
