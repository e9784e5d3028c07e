"""What a long command shows: words, the share that is done, and names of files as they are."""

import pytest
from dynident.apps.commands.progress import Manner, bar, speaking, status
from dynident.common.progress import each


def test_each_item_is_told_with_the_share_before_it() -> None:
    heard: list[tuple[str, float | None]] = []
    items = list(
        each(["a", "b"], lambda name: f"reading {name}", lambda words, share=None: heard.append((words, share)))
    )
    assert items == ["a", "b"]
    assert heard == [("reading a", 0.0), ("reading b", 0.5)]


def test_a_single_item_has_no_share() -> None:
    heard: list[float | None] = []
    assert list(each(["a"], str, lambda words, share=None: heard.append(share))) == ["a"]
    assert heard == [None]


def test_a_terminal_shows_words_and_the_share(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    with status("reading [/x].csv") as progress:
        progress("filtering [a].csv", 0.0)
        progress("filtering [b].csv", 0.5)
    shown = capsys.readouterr().err
    assert "filtering [b].csv" in shown
    assert "50%" in shown
    assert "progress.percentage" not in shown


def test_work_without_a_share_has_no_percentage(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with status("estimating"):
        pass
    shown = capsys.readouterr().err
    assert "estimating" in shown
    assert "%" not in shown


@pytest.mark.parametrize("manner", ["quiet", "plain"])
def test_nothing_is_drawn_where_nobody_looks(capsys: pytest.CaptureFixture[str], manner: Manner) -> None:
    with speaking(manner), bar("reducing") as progress:
        progress(0.5)
        progress(1.0)
    assert "50" not in capsys.readouterr().err


def test_a_file_gets_no_line_of_it(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not an empty one either."""
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    with bar("reading") as progress:
        progress(0.5)
    assert capsys.readouterr().err == ""
