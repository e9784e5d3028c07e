"""A screen is 25 lines of 80 columns, whatever is in it; the details hold the rest."""

import pytest
from dynident.apps.report.blocks import Block, Notes, Report, Section, Table
from dynident.apps.report.terminal import COLUMNS, LINES, screen_text
from rich.cells import cell_len

LONG = "a reason that goes on and on, " * 40
WIDE = Table("wide", ("", "unit", *(f"method {k}" for k in range(20))), [("M", "kg", *["-1234.567"] * 20)])
FOLDING = Table("words", ("", "value", "rests on"), [("joint 1", "1.25", "gravity " * 40)])
SEVEN = Table("seven", ("", "value"), [(f"row {k}", "1.0") for k in range(7)])


def within(text: str) -> bool:
    return max(map(cell_len, text.split("\n"))) <= COLUMNS


@pytest.mark.parametrize("count", [0, 1, 5, 40])
@pytest.mark.parametrize("line", ["short", LONG, "/a/path/" + "x" * 200])
def test_a_screen_never_grows_beyond_its_lines(count: int, line: str) -> None:
    first: list[Block] = [
        Notes(["Verdict: use."]),
        Notes([line] * count, optional=True),
        SEVEN,
        Notes(["Next: go."]),
    ]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])], "more")
    lines = screen_text(screen).split("\n")
    assert len(lines) <= LINES
    assert within("\n".join(lines))
    assert any(line.startswith("Next") for line in lines), "what must be seen is not pushed out by remarks"
    assert lines[-1].startswith("--details: ")


def test_details_hold_every_word() -> None:
    first = [Notes([f"{LONG} {k}" for k in range(40)], optional=True)]
    screen = Report("", first, [Section("wide", "Wide", [WIDE])])
    words = screen_text(screen, details=True).split()
    assert words.count("goes") == 40 * 40
    assert words.count("-1234.567") == 20
    assert "--details:" not in words


@pytest.mark.parametrize("table", [WIDE, FOLDING, SEVEN], ids=["wide", "folding", "narrow"])
def test_a_table_is_as_wide_as_the_terminal_at_most(table: Table) -> None:
    shown = screen_text(Report("", [table]))
    assert within(shown)
    for row in table.rows:
        for cell in row:
            assert str(cell).split()[0] in shown
    assert "…" not in shown


@pytest.mark.parametrize("name", ["[/x]", "[bold]x", ":warning:", "[red", "a\\[b", "{x}"])
def test_names_are_text(name: str) -> None:
    """Brackets and colons of names of robots and files are no markup."""
    table = Table(f"Robot {name}", (name, f"[{name}]"), [(name, "1")])
    shown = screen_text(
        Report("", [Notes([f"{name}: read"]), Notes([f"note of {name}"], optional=True), table], [], name)
    )
    assert shown.count(name) == 7


def test_words_of_several_rows_stand_beside_all_of_them() -> None:
    rows = [("mass", "1", "use"), *((f"com {x}", "2", "not measured well enough, by far") for x in "xyz")]
    table = Table("t", ("", "value", "use"), rows, ends=("mass",), merged=True, spare=("com z",))
    _, _, mass, *com = screen_text(Report("", [table]), details=True).split("\n")
    assert mass.split() == ["mass", "1", "use"]
    assert [line.split()[3] for line in com] == ["┐", "│", "┘"]
    assert " ".join(word for line in com for word in line.split()[4:]) == "not measured well enough, by far"
    assert len(screen_text(Report("", [table])).split("\n")) == 5, "the first screen leaves a row out"
