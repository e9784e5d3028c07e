"""The report shows values: it imports no function that estimates, and no figure before one is drawn."""

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
ALLOWED = {
    "array",  # numbers of a result, nan where there is none
    "bounds",
    "mass_by_joints",  # rows of a table
    "numbers",
    "student95",  # a quantile
}
"""Functions of what an answer holds; none looks at data."""


def functions() -> set[str]:
    """Functions that the room imports from estimation, types apart."""
    names = set()
    for path in (ROOT / "apps/report").rglob("*.py"):
        depth = len(path.parent.relative_to(ROOT).parts)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.ImportFrom)
                and node.level > depth
                and (node.module or "").startswith("estimation")
            ):
                module = importlib.import_module(f"dynident.{node.module}")
                names |= {each.name for each in node.names if inspect.isroutine(getattr(module, each.name))}
    return names


def test_no_estimator_is_imported() -> None:
    assert functions() <= ALLOWED


def test_figures_are_imported_without_matplotlib() -> None:
    code = "import dynident.apps.report.sections.payload, dynident.apps.report.page, sys; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert "dynident.apps.report.figures.payload" in loaded.split()
    assert not {"matplotlib", "jinja2"} & set(loaded.split())
