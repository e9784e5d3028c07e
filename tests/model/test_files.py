"""Files and folders on POSIX and on Windows: names, line ends, what is in use."""

import sys
from collections.abc import Callable
from pathlib import Path, PurePath, PurePosixPath, PureWindowsPath

import pytest
from dynident.common.errors import InputError
from dynident.common.files import write_bytes, write_text
from dynident.model import load_robot
from dynident.model.kernel import cache

NAMES = ("result.json", "with space.json", "Größe.json", "C:\\logs\\result.json", "..hidden", "a" * 200)
"""Names that a system may have: the fourth is a path on Windows and a plain name on POSIX."""
FOURTH = pytest.mark.skipif(sys.platform == "win32", reason="a path there, not a name")


@pytest.mark.parametrize("name", [pytest.param(n, marks=FOURTH) if ":" in n else n for n in NAMES])
@pytest.mark.parametrize("kind", [str, Path])
def test_text_is_whole_and_ends_lines_alike_everywhere(
    tmp_path: Path, name: str, kind: Callable[[Path], str | Path]
) -> None:
    path = tmp_path / name
    write_text(kind(path), "first\n")
    write_text(kind(path), "ä\nb\n")
    assert path.read_bytes() == b"\xc3\xa4\nb\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_in_use_stays_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows refuses to replace a file that another program has open: the old one stays, no other is left."""
    path = tmp_path / "result.json"
    write_bytes(path, b"old")

    def refuse(self: Path, target: Path) -> Path:
        raise PermissionError(13, "The process cannot access the file", str(target))

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(InputError, match=r"result\.json: cannot be written: The process cannot access"):
        write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_a_link_keeps_its_place(tmp_path: Path) -> None:
    target, link = tmp_path / "real.txt", tmp_path / "link.txt"
    target.write_bytes(b"old")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "new"


@pytest.mark.parametrize("path", [PureWindowsPath(r"C:\robots\mine.toml"), PurePosixPath("/robots/mine.toml")])
def test_a_robot_file_that_is_not_there_is_named_as_it_was_given(path: PurePath) -> None:
    with pytest.raises(InputError, match="no such file") as refused:
        load_robot(str(path))
    assert repr(str(path)) in str(refused.value)


def test_a_robot_by_a_path_with_spaces(tmp_path: Path) -> None:
    source = Path(__file__).parents[2] / "model" / "robots" / "rx90.toml"
    copy = tmp_path / "my robots" / "arm é.toml"
    copy.parent.mkdir()
    copy.write_bytes(source.read_bytes().replace(b"\n", b"\r\n"))  # as an editor on Windows saves it
    assert load_robot(copy) == load_robot(str(copy)) == load_robot("rx90")


@pytest.mark.parametrize(
    ("platform", "path", "expected"),
    [
        ("win32", PureWindowsPath, r"C:\Users\Jo Ann\AppData\Local\dynident"),
        ("linux", PurePosixPath, "/home/jo/cache/dynident"),
        ("darwin", PurePosixPath, "/home/jo/cache/dynident"),
    ],
)
def test_where_each_system_keeps_caches(
    monkeypatch: pytest.MonkeyPatch, platform: str, path: type[PurePath], expected: str
) -> None:
    monkeypatch.delenv("DYNIDENT_CACHE", raising=False)
    monkeypatch.setenv("LOCALAPPDATA", r"C:\Users\Jo Ann\AppData\Local")
    monkeypatch.setenv("XDG_CACHE_HOME", "/home/jo/cache")
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(cache, "Path", path)
    assert str(cache._wanted_folder()) == expected
    assert cache._suffix() == (".dll" if platform == "win32" else ".so")
