"""Files that are written: whole or not at all, none over another of the run, with the user's modes."""

import io
import os
import stat
import sys
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.report.figures import save_figure
from dynident.common.errors import InputError
from dynident.common.files import keeping, write_bytes, write_text
from matplotlib.figure import Figure


def test_what_a_folder_gets_overwrites_nothing_either(tmp_path: Path) -> None:
    """Names within a folder are known late: the write itself refuses."""
    target, link = tmp_path / "mine.csv", tmp_path / "link.csv"
    target.write_text("mine")
    link.symlink_to(target)
    with keeping([target]):
        for path in (target, link, tmp_path / "x" / ".." / "mine.csv"):
            with pytest.raises(InputError, match="read or written it already"):
                write_text(path, "other")
        write_text(tmp_path / "new", "first")
        with pytest.raises(InputError, match="read or written it already"):
            write_text(tmp_path / "new", "second")
        write_text(os.devnull, "as often")
        write_text(os.devnull, "as one likes")
    assert target.read_text() == "mine"
    assert (tmp_path / "new").read_text() == "first"
    write_text(target, "another run")
    assert target.read_text() == "another run"


@pytest.mark.skipif(os.name == "nt", reason="modes are POSIX's")
@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_modes_are_the_users(tmp_path: Path, umask: int) -> None:
    old = os.umask(umask)
    try:
        write_text(tmp_path / "new", "x")
        save_figure(Figure(figsize=(1.0, 1.0)), tmp_path / "new.png")
        (tmp_path / "there").write_text("y")
        (tmp_path / "there").chmod(0o640)
        write_bytes(tmp_path / "there", b"z")
    finally:
        os.umask(old)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes == {"new": 0o666 & ~umask, "new.png": 0o666 & ~umask, "there": 0o640}


def test_a_full_disk_leaves_the_old_file_and_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.BytesIO):
        def write(self, _: Any, /) -> int:
            raise OSError(28, "No space left on device")

    def full(descriptor: int, _: str) -> Full:
        os.close(descriptor)
        return Full()

    path = tmp_path / "figure.png"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "fdopen", full)
    with pytest.raises(InputError, match=r"figure\.png: cannot be written: No space left on device"):
        save_figure(Figure(figsize=(1.0, 1.0)), path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_text_is_whole_and_ends_lines_alike_everywhere(tmp_path: Path) -> None:
    path = tmp_path / "with space, Größe.json"
    write_text(path, "first\n")
    write_text(str(path), "ä\nb\n")
    assert path.read_bytes() == b"\xc3\xa4\nb\n"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_a_link_keeps_its_place(tmp_path: Path) -> None:
    target, link = tmp_path / "real.txt", tmp_path / "link.txt"
    target.write_bytes(b"old")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "new"
