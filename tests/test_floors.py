"""The floors of a room: imports go down, and no file imports itself through others."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = {
    "estimation": (
        "recordings",
        "signals",
        "equations",
        "fit",
        "possible",
        "robot",
        "rollout",
        "payload",
        "gains",
        "files",
        "diagnosis",
        "answers",
    ),
    "trajectories": ("motions", "design", "simulation"),
    "live": ("packets", "fields", "connection", "client", "record", "script"),
    "fleet": (
        "passport",
        "hints",
        "codec",
        "files",
        "answers",
        "comparing",
        "merging",
        "catalog",
        "store",
        "engine",
        "worker",
        "results",
        "reduction",
        "identity",
        "nights",
        "drawing",
        "simulated",
        "series",
        "alarms",
        "trends",
    ),
    "report": (
        "blocks",
        "numbers",
        "provenance",
        "npz",
        "recordings",
        "motions",
        "controllers",
        "simulators",
        "documents",
        "figures",
        "view",
        "sections",
        "render",
        "speech",
    ),
}
"""From the cellar to the roof; a file on one floor imports that floor and those below."""
KNOWN: set[tuple[str, str]] = set()
"""Steps up that the fold has not removed yet."""


def modules() -> dict[str, Path]:
    """Every module of the product by its dotted name."""
    rooms = ("common", "model", "estimation", "trajectories", "live", "fleet", "report", "commands")
    paths = [path for room in rooms
             for path in (ROOT / room).rglob("*.py")]  # fmt: skip
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in paths
    }


MODULES = modules()


def imported(name: str) -> set[str]:
    """Modules that one imports, in functions and type checks too."""
    package = name.split(".") if MODULES[name].name == "__init__.py" else name.split(".")[:-1]
    targets = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = [*package[: len(package) + 1 - node.level], *(node.module.split(".") if node.module else ())]
            for alias in node.names:
                full = ".".join([*base, alias.name])
                targets.add(full if full in MODULES else ".".join(base))
    return targets & set(MODULES)


@pytest.mark.parametrize("room", FLOORS)
def test_imports_go_down(room: str) -> None:
    """Each floor imports itself and those below it; nothing stands between the floors."""
    floors = {floor: height for height, floor in enumerate(FLOORS[room])}
    steps_up = set()
    for name in MODULES:
        if name.startswith(f"{room}.") and name.split(".")[1] in floors:
            height = floors[name.split(".")[1]]
            inside = {target for target in imported(name) if target.split(".")[0] == room}
            steps_up |= {(name, to) for to in inside if to == room or floors[to.split(".")[1]] > height}
        elif name.startswith(f"{room}."):
            steps_up |= {(name, to) for to in imported(name) if to.split(".")[0] == room}
    assert steps_up == {step for step in KNOWN if step[0].startswith(room)}


def test_no_file_imports_itself() -> None:
    """No circle of files anywhere in the house; a package's contents page counts as none."""
    graph = {name: imported(name) - {name} for name, path in MODULES.items() if path.name != "__init__.py"}
    list(TopologicalSorter(graph).static_order())
