"""Files that would break or stall a parser: nested by the thousand, endless keys, numbers of endless digits."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest
from dynident.common.errors import InputError
from dynident.common.schema import TOML_BYTES, read_json
from dynident.model import load_robot, read_payload
from dynident.model.files.robot_file import BodyTable
from dynident.trajectories import read_scene

READERS = [load_robot, read_payload, read_scene]
SECONDS = 5.0  # on a busy machine; without the checks some of them take minutes
FILES = {
    "lists in lists": ("a = " + 3000 * "[" + 3000 * "]", "nested too deeply"),
    "tables in tables": ("a = " + 3000 * "{a = " + "1" + 3000 * "}", "nested too deeply"),
    "a key of 50,000 dots": ("a" + 50_000 * ".a" + " = 1", "twenty parts"),
    "a key of quoted parts": ('"a b"' + 50_000 * ' . "a b"' + " = 1", "twenty parts"),
    "a table of 50,000 dots": ("[a" + 50_000 * ".a" + "]", "twenty parts"),
    "an inline key of dots": ("a = {b" + 50_000 * ".'b'" + " = 1}", "twenty parts"),
    "5,000 digits": ("a = " + 5000 * "9", "thousands of digits"),
    "long": ("# " + TOML_BYTES * "x", "larger than 1 MB"),
}


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("name", FILES)
def test_no_toml_file_breaks_or_stalls_a_reader(name: str, read: Callable[[Path], object], tmp_path: Path) -> None:
    text, words = FILES[name]
    path, begun = tmp_path / "a.toml", time.monotonic()
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read(path)
    assert len(str(caught.value).splitlines()) == 1
    assert time.monotonic() - begun < SECONDS


@pytest.mark.parametrize("key", ["rated_payload_kg = ", "gravity = [0, 0, "])
def test_a_number_that_cannot_be_shown_is_named_by_its_key(key: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(f"{key}0x{5000 * 'f'}{']' * key.count('[')}\n[[joints]]\n")
    with pytest.raises(InputError, match=key.split()[0]):
        load_robot(tmp_path / "a.toml")


def test_long_numbers_and_names_that_are_fine(tmp_path: Path) -> None:
    """Texts and comments hold no key, and a list of many numbers is no key either."""
    words = ".".join(40 * ["word"])
    numbers = ", ".join(f"[{k / 7:.6f}, {k / 3:.6f}]" for k in range(500))
    text = f'# {", ".join(40 * ["e.g. a.b"])}\nname = "x"\ntitle = "{words[:60]}"\n[[joints]]\n'
    (tmp_path / "a.toml").write_text(f"{text}[drives.spring]\njoint = 1\ntable = [{numbers}]\n")
    assert load_robot(tmp_path / "a.toml").spring is not None


@pytest.mark.parametrize(
    "text",
    [
        3000 * "[" + 3000 * "]",
        3000 * '{"mass": ' + "1" + 3000 * "}",
        '{"mass": ' + 5000 * "9" + "}",
        "9" * 5000,
        "\ufeff",
    ],
)
def test_no_json_file_breaks_a_reader(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(InputError, match=r"a\.json: .*: give another"):
        read_json(tmp_path / "a.json", BodyTable, "give another")
