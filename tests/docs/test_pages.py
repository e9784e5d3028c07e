"""The README and the documentation stay true: every block does what the page says, every link leads somewhere."""

import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import shown_name
from dynident.estimation.diagnosis.verdict import table
from dynident.tests.commands.typed import options
from dynident.tests.docs.pages import LANGUAGES, ROOT, Reader, blocks, pages
from dynident.tests.frozen.inputs import NAMES as NAMES_OF_COMMANDS
from dynident.tests.frozen.inputs import arguments
from dynident.tests.selection import cases

PAGES = pages()
NAMES = [page.relative_to(ROOT).as_posix() for page in PAGES]
LONG = {"README", "currents", "cut-off", "design", "drake", "export", "fleet", "known-mass", "rollout", "weigh",
        "unknown-payload", "wall-mounted"}  # fmt: skip
"""Pages whose commands take longest."""
NEEDS = {"mujoco": "mujoco", "isaac": "pxr", "drake": "pydrake"}
"""Packages that the programs of a page import."""
BEGIN, END = "<!-- table -->\n", "<!-- /table -->\n"
RUN = [page for page in PAGES if any(block.language in ("console", "python") for block in blocks(page))]


@pytest.fixture(scope="module")
def simulated_folders() -> dict[str, Path]:
    """Simulated folders, shared by the pages."""
    return {}


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("simulated")


@pytest.mark.parametrize(
    "page", cases(RUN, lambda page: page.stem not in LONG), ids=[page.relative_to(ROOT).as_posix() for page in RUN]
)
def test_page_does_what_it_says(
    page: Path, simulated_folders: dict[str, Path], store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if page.stem in NEEDS:
        pytest.importorskip(NEEDS[page.stem])
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "116")
    if page.stem not in ("rollout", "design"):  # to compile takes longer than the few runs of other pages
        monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    monkeypatch.setattr("sys.argv", ["example.py"])
    reader = Reader(simulated_folders, store)
    reader.follow(page)
    assert reader.ran


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_blocks_say_what_they_are(page: Path) -> None:
    """A block that is not run is marked by its language; no command hides in an indented block."""
    source = page.read_text(encoding="utf-8")
    assert source.count("```") == 2 * len(blocks(page))
    for block in blocks(page):
        assert block.language in LANGUAGES, f"{page.name}:{block.line}: language {block.language!r}"
    outside = re.sub(r"```.*?```", "", source, flags=re.DOTALL)
    assert not re.search(r"^ {4}(dynident|python|pip|make|import|from) ", outside, flags=re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_somewhere(page: Path) -> None:
    source = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", source):
        if not target.startswith("http"):
            assert (page.parent / target).resolve().exists(), target


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "mistakes.md"], ids=lambda page: page.name)
def test_commands_in_the_text_exist(page: Path) -> None:
    """`dynident X --option` anywhere in the text: X and --option are there."""
    outside = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for text in re.findall(r"`dynident ([^`]+)`", outside):
        words = text.split()
        name = " ".join(words[: 2 if words[0] in ("robot", "fleet") else 1])
        if not name.startswith("-"):
            known = {"--help", *(options(name) if name in NAMES_OF_COMMANDS else ())}
            assert name in COMMANDS, text
            assert set(re.findall(r"--[a-z][a-z0-9-]*", text)) <= known, text


def test_every_page_is_in_the_table_of_contents() -> None:
    listed = set(re.findall(r"([\w/-]+\.md)", (ROOT / "mkdocs.yml").read_text(encoding="utf-8")))
    assert listed == {page.relative_to(ROOT / "docs").as_posix() for page in PAGES if page.name != "README.md"}
    doors = set(re.findall(r"\((how-to/[\w-]+\.md)\)", (ROOT / "docs/index.md").read_text(encoding="utf-8")))
    assert doors == {name for name in listed if name.startswith("how-to/")}, "the front page leads to each how-to"


def test_every_example_is_run_by_a_page() -> None:
    commands = "".join(block.text for page in RUN for block in blocks(page) if block.language == "console")
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for example in sorted((ROOT / "examples").glob("*.py")):
        if example.stem == "__init__" or f"`python -m dynident.examples.{example.stem} --out docs`" in texts:
            continue
        assert f"python examples/{example.name}\n" in commands


NOTEBOOKS: dict[str, Callable[[dict[str, Any]], bool]] = {
    "engineer": lambda seen: seen["weighed"].mass.low < 2.5 < seen["weighed"].mass.high,
    "researcher": lambda seen: abs(seen["found"].mass - 7.025) < 0.3 and seen["found"].physically_consistent,
    "maintainer": lambda seen: seen["acme"].text(seen["load_of"](seen["result"], "x")).count("PAYLOAD 1.50") == 1,
}
"""Notebooks by name, and what must be true of what their cells leave."""


@pytest.mark.parametrize("name", cases(NOTEBOOKS, lambda name: name != "engineer"))
def test_notebook_does_what_it_says(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path / "examples")
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
    seen: dict[str, Any] = {"__name__": "__main__"}
    for cell in json.loads(Path(f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            assert not cell["outputs"], "outputs grow stale: clear them"
            exec(compile("".join(cell["source"]), name, "exec"), seen)
    assert NOTEBOOKS[name](seen)


def test_the_page_on_the_method_shows_pieces_of_its_example() -> None:
    example = (ROOT / "examples/the_method.py").read_text(encoding="utf-8")
    pieces = [block for block in blocks(ROOT / "docs/the-method.md") if block.language == "python"]
    assert len(pieces) == 8
    at = 0
    for piece in pieces:
        assert piece.text in example[at:], f"the-method.md:{piece.line}: not in the example, or not there"
        at = example.index(piece.text, at) + len(piece.text)


def settings_table() -> list[str]:
    """Every setting of every command."""
    commands: dict[tuple[str, str, str], list[str]] = {}
    for name in NAMES_OF_COMMANDS:
        for argument in arguments(name):
            if not argument.show:
                text = " ".join((argument.parameter.help or "").split())
                value = argument.parameter.metavar or "true"
                commands.setdefault((shown_name(argument), value, text), []).append(name)
    most = len(NAMES_OF_COMMANDS) - 1
    rows = []
    for (key, value, text), of in sorted(commands.items()):
        where = "all" if len(of) == most else ", ".join(of)
        words = f"<code>{value.replace('|', '&#124;')}</code>" if "|" in value else f"`{value}`"
        rows.append(f"| `{key}` | {words} | {text} | {where} |\n")
    return ["| key | value | what it does | commands |\n", "|---|---|---|---|\n", *rows]


def verdict_table() -> list[str]:
    rows = [f"| {what.rstrip('.')} | {limits} |\n" for what, limits in table()]
    return ["| check | limit and verdict |\n", "|---|---|\n", *rows]


@pytest.mark.parametrize(("page", "lines"), [("verdict", verdict_table), ("settings", settings_table)])
def test_a_page_holds_the_table_as_the_code_prints_it(page: str, lines: Callable[[], list[str]]) -> None:
    """Run with WRITE_DOCS=1 to write it anew."""
    path, printed = ROOT / f"docs/{page}.md", "".join(lines())
    text = path.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    shown, _, after = rest.partition(END)
    if os.environ.get("WRITE_DOCS"):
        path.write_text(f"{before}{BEGIN}{printed}{END}{after}", encoding="utf-8")
        return
    assert shown == printed
