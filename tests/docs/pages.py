"""Reads the blocks of a page of the documentation, and runs them in order in one folder, as a reader would.

- ``console``: commands, one a line. Those of ``dynident`` run here; ``make X`` must be a target of the Makefile.
  A command that does not exit with 0 says so: ``# exit status 1``.
- ``python``: runs in one namespace per page.
- ``toml``: a file, if its first line is its name (``# name.toml``): written, or compared where it is there.
- ``output``: lines that what ran just before has printed, numbers to 1 %; a line ``...`` stands for any lines.
  ``output searched``: what a search found, numbers to 30 %: rounding, other on each processor, leads it astray.
- ``text``, ``bibtex``: not run: needs the network, a robot, a licence or recordings that are not here.
"""

import contextlib
import io
import math
import re
import shlex
import shutil
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dynident.cli import main

ROOT = Path(__file__).parents[2]
LANGUAGES = {"console", "python", "toml", "output", "text", "bibtex"}
_FENCE = re.compile(r"^(`{3,})(\S*)([^\n]*)\n(.*?)^\1[ ]*$", flags=re.DOTALL | re.MULTILINE)
_STATUS = re.compile(r"\s+#\s*exit status (\d)\s*$")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_RELATIVE = 0.01
_SEARCHED = 0.3
"""Tolerance of numbers that a search found; the words, and what limits are kept, are the same everywhere."""


@dataclass(frozen=True)
class Block:
    """A fenced block: where it starts, its language and its text, and how near printed numbers must come."""

    line: int
    language: str
    text: str
    within: float = _RELATIVE


def pages() -> list[Path]:
    """The README and every page of the site, to which the paper does not belong."""
    docs = ROOT / "docs"
    return [ROOT / "README.md", *sorted({*docs.rglob("*.md")} - {*docs.glob("paper/*")})]


def blocks(page: Path) -> list[Block]:
    """The page's fenced blocks, in order."""
    source = page.read_text(encoding="utf-8")
    return [
        Block(
            source.count("\n", 0, match.start()) + 1,
            match[2],
            match[4],
            _SEARCHED if match[3].strip() == "searched" else _RELATIVE,
        )
        for match in _FENCE.finditer(source)
    ]


@dataclass
class Reader:
    """Somebody who types a page's blocks into a folder, the current one.

    ``kept`` holds folders that earlier readers simulated, by command and payload: the same again is copied.
    """

    kept: dict[str, Path]
    store: Path
    printed: str = ""
    ran: int = 0
    namespace: dict[str, Any] = field(default_factory=dict)

    def follow(self, page: Path) -> None:
        """Do what the page says.

        Raises:
            AssertionError: names the block that does not do what the page says.
        """
        name = page.relative_to(ROOT).as_posix()
        for block in blocks(page):
            where = f"{name}:{block.line}"
            if block.language == "toml":
                self._file(block.text, where)
            elif block.language == "console":
                self.printed = "".join(self._command(line, where) for line in _lines(block.text))
            elif block.language == "python":
                self.printed = self._python(block.text, where)
            elif block.language == "output":
                missing = first_missing(block.text, self.printed, block.within)
                assert missing is None, f"{where}: not printed: {missing!r}; printed was\n{self.printed}"

    @staticmethod
    def _file(text: str, where: str) -> None:
        name = re.match(r"# (\w[\w./-]*\.toml)\b", text)
        if name and Path(name[1]).exists():
            assert Path(name[1]).read_text(encoding="utf-8") == text, f"{where}: the file says something else"
        elif name:
            Path(name[1]).write_text(text, encoding="utf-8")

    def _command(self, line: str, where: str) -> str:
        status = _STATUS.search(line)
        expected = int(status[1]) if status else 0
        words = shlex.split(line, comments=True)
        if words[0] == "make":
            makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
            assert re.search(rf"^{re.escape(words[1])}:", makefile, flags=re.MULTILINE), f"{where}: {line}"
            return ""
        if words[0] == "python":
            self.ran += 1
            return self._python(Path(words[1]).read_text(encoding="utf-8"), where)
        assert words[0] == "dynident", f"{where}: {line}: cannot be run here; its block's language should be text"
        self.ran += 1
        return self._cached(words[1:]) if words[1] == "simulate" else _answer(words[1:], expected, where)

    def _cached(self, words: Sequence[str]) -> str:
        """Simulations take most of the time, and many pages begin with the same one."""
        out = Path(words[words.index("--out") + 1])
        inputs = [Path(word).read_text(encoding="utf-8") for word in words if Path(word).is_file()]
        key = "\n".join((*words, *inputs))
        if key in self.kept:
            shutil.copytree(self.kept[key], out, dirs_exist_ok=True)
            return ""
        printed = _answer(words, 0, " ".join(words))
        self.kept[key] = self.store / str(len(self.kept))
        shutil.copytree(out, self.kept[key])
        return printed

    def _python(self, text: str, where: str) -> str:
        self.ran += 1
        self.namespace.setdefault("__name__", "__main__")
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(text, where, "exec"), self.namespace)
        return out.getvalue()


def _answer(words: Sequence[str], expected: int, where: str) -> str:
    """Output of a command.

    Raises:
        AssertionError: if it ends with another status.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as stop:
            status = int(stop.code or 0)
    assert status == expected, f"{where}: dynident {shlex.join(words)}: exit status {status}\n{err.getvalue()}"
    return out.getvalue() + err.getvalue()


def _lines(text: str) -> list[str]:
    joined = text.replace("\\\n", " ")
    return [line.strip() for line in joined.splitlines() if line.strip() and not line.startswith("#")]


def first_missing(expected: str, printed: str, within: float = _RELATIVE) -> str | None:
    """The first line of ``expected`` that does not follow in ``printed``; None where all do."""
    lines, at = printed.splitlines(), 0
    for expected_line in (line for line in expected.splitlines() if line.strip() not in ("", "...")):
        place = next((k for k in range(at, len(lines)) if alike(expected_line, lines[k], within)), None)
        if place is None:
            return expected_line
        at = place + 1
    return None


def alike(expected: str, line: str, within: float = _RELATIVE) -> bool:
    """Compare texts: words exactly, numbers to a share of them, or to one of the last digit that the page shows."""
    return _words(expected) == _words(line) and all(
        math.isclose(float(a), float(b), rel_tol=within, abs_tol=1.01 * _last_digit(a))
        for a, b in zip(_NUMBER.findall(_plain(expected)), _NUMBER.findall(_plain(line)), strict=True)
    )


def _plain(line: str) -> str:
    return unicodedata.normalize("NFKC", line)


def _words(line: str) -> list[str]:
    return _NUMBER.sub("#", _plain(line)).split()


def _last_digit(number: str) -> float:
    mantissa, _, exponent = number.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))
