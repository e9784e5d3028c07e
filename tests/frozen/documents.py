"""Numbers of JSON documents by their path, and how near a new one must be to the frozen one.

Each rule is a share of something with the number's own unit: of its standard deviation where the document tells
one, else of the largest number beside it.
"""

from typing import Any, NamedTuple

from dynident.tests.frozen.texts import same_printed, take_apart

Leaf = float | int | str | bool | None
Leaves = dict[str, Leaf]
"""Path -> value, in reading order."""
FREE = 1e-7
"""Least squares alone: share of sigma, or of the size."""
CONSTRAINED = 1e-3
"""From a solver of cones: share of the free estimate's sigma, or of the size."""
ITERATED = (1e-3, 5e-3)
"""Gains and load found in turns until they stand still: share of sigma, else of the size."""
ZERO = 1e-6
"""What a constraint makes zero is zero: share of the size of what it belongs to."""
UNDECIDED = 0.05
"""Share of the size, for what the data leave open: how far links that are not at their bound are from it."""
FLOOR = 1e-12
"""Zero, for a solver, in SI units."""
SCORE = 1e-9
"""Of a motion that is not searched: share of the size."""
_MANY = 60
"""Longer lists are thinned to about this many numbers."""
_UNCERTAIN_TIMES = ("cpu_s",)
_MADE_ZERO = ("min_pseudo_inertia_eigenvalue", "min_eigenvalues")
_BY_TURNS = "drive_gains/"
_BY_SOLVER = ("constrained", "quantities", "agreement", "assumed")
_SIGMA = {
    "parameters": "sigma",
    "value": "sigma",
    "values": "sigma",
    "mass": "sigma",
    "com": "com_sigma",
    "inertia_com": "inertia_com_sigma",
}
"""Name of a value -> name of its standard deviation beside it."""


class Change(NamedTuple):
    """One leaf that differs by more than it may."""

    path: str
    old: object
    new: object
    allowed: str


def leaves(document: Any, path: str = "") -> Leaves:
    """All leaves of a document; long lists and matrices thinned, with their shape."""
    entries: Leaves = {}
    if isinstance(document, dict):
        for key, value in document.items():
            entries |= leaves(value, _join(path, key))
        return entries or {path: "{}"}
    if not isinstance(document, list):
        return {path: _shortened(document)}
    if _is_matrix(document) and len(document) * len(document[0]) > _MANY:
        rows, columns = len(document), len(document[0])
        entries[_join(path, "shape")] = f"{rows} x {columns}"
        step = -(-rows // _MANY)
        return entries | {
            f"{path}/{i}/{i % columns}": _shortened(document[i][i % columns]) for i in range(0, rows, step)
        }
    step = 1
    if len(document) > _MANY and not isinstance(document[0], dict | list):
        step = -(-len(document) // _MANY)
        entries[_join(path, "shape")] = str(len(document))
    for i in range(0, len(document), step):
        entries |= leaves(document[i], _join(path, str(i)))
    return entries or {path: "[]"}


def changes(old: Leaves, new: Leaves, share: float = FREE) -> list[Change]:
    """Leaves that differ by more than they may, those that are gone, and new ones."""
    rows = []
    for path, was in old.items():
        if path not in new:
            rows.append(Change(path, was, "(gone)", "exact"))
        elif not path.endswith(_UNCERTAIN_TIMES):
            now = new[path]
            if was is now or (type(was) is type(now) and was == now):
                continue
            if isinstance(was, float) and isinstance(now, float | int) and not isinstance(now, bool):
                allowed = tolerance(path, old, share)
                if not abs(now - was) <= allowed:
                    rows.append(Change(path, was, now, f"±{allowed:.1e}"))
            elif not _same_words(was, now):
                rows.append(Change(path, was, now, "exact"))
    return rows + [Change(path, "(not there)", now, "exact") for path, now in new.items() if path not in old]


def tolerance(path: str, frozen: Leaves, share: float = FREE) -> float:
    """How far a number may be from the frozen one."""
    value = abs(_number(frozen, path) or 0.0)
    parts = path.split("/")
    estimate = _estimate(parts, frozen)
    sigma = _sigma(parts, frozen)
    if any(sibling.startswith(_BY_TURNS) for sibling in frozen):
        return ITERATED[0] * sigma if sigma else ITERATED[1] * _size(parts, frozen)
    solved = _solved(parts, frozen)
    if solved and any(name in parts for name in _MADE_ZERO):
        return ZERO * _largest_parameter(estimate, frozen) + UNDECIDED * value
    if solved and not any(part.startswith("sigma") for part in parts):
        return max(CONSTRAINED * (sigma or _size(parts, frozen)), FLOOR)
    return share * (sigma or _size(parts, frozen))


def _same_words(old: Leaf, new: Leaf) -> bool:
    if not isinstance(old, str) or not isinstance(new, str):
        return type(old) is type(new) and old == new
    was, now = take_apart(old), take_apart(new)
    return was.words == now.words and all(map(same_printed, was.numbers, now.numbers))


def _solved(parts: list[str], frozen: Leaves) -> bool:
    """Whether a constrained estimate's."""
    if parts[0] == "estimates":
        return frozen.get(f"estimates/{parts[1]}/estimator") == "constrained"
    return parts[0] in _BY_SOLVER and parts[-1] != "free"


def _estimate(parts: list[str], frozen: Leaves) -> str:
    """Path of the free estimate by the same method."""
    if parts[0] != "estimates":
        return ""
    method = frozen.get(f"estimates/{parts[1]}/method")
    for path, value in frozen.items():
        if path.startswith("estimates/") and path.endswith("/estimator") and value == "wls":
            stem = path.removesuffix("/estimator")
            if frozen.get(f"{stem}/method") == method:
                return stem
    return ""


def _sigma(parts: list[str], frozen: Leaves) -> float | None:
    """Standard deviation of the value at a path, of the free estimate where there is one."""
    free = _estimate(parts, frozen).split("/")
    free_place = [*free, *parts[2:]] if len(free) == 2 else parts[1:]
    for place in (parts, free_place):
        for i, part in enumerate(place):
            name = _SIGMA.get(part.removesuffix("_interval95").removesuffix("_robust"))
            if part.startswith("interval95"):
                name = "sigma"
            for end in range(len(place), i, -1) if name else ():
                sigma = _number(frozen, "/".join([*place[:i], str(name), *place[i + 1 : end]]))
                if sigma:
                    return sigma
    return None


def _size(parts: list[str], frozen: Leaves) -> float:
    """Largest number of the list or matrix that holds the value; of a variance or a single value its own."""
    stem = list(parts)
    while stem and stem[-1].isdigit():
        stem.pop()
    if len(stem) == len(parts) or stem[0].startswith("covariance"):
        return abs(_number(frozen, "/".join(parts)) or 0.0)
    start = "/".join(stem) + "/"
    numbers = (_number(frozen, path) for path in frozen if path.startswith(start))
    return max(abs(number) for number in numbers if number is not None)


def _largest_parameter(estimate: str, frozen: Leaves) -> float:
    """Largest parameter of an estimate, or 1 where there is none."""
    start = f"{estimate}/parameters/"
    numbers = [abs(_number(frozen, path) or 0.0) for path in frozen if estimate and path.startswith(start)]
    return max(numbers, default=1.0)


def _number(frozen: Leaves, path: str) -> float | None:
    value = frozen.get(path)
    return float(value) if isinstance(value, float | int) and not isinstance(value, bool) else None


def _is_matrix(document: list[Any]) -> bool:
    return bool(document) and all(
        isinstance(row, list) and row and isinstance(row[0], float | int) for row in document
    )


def _shortened(value: Leaf) -> Leaf:
    """Twelve digits are enough for every rule."""
    return float(f"{value:.12g}") if isinstance(value, float) else value


def _join(path: str, key: str) -> str:
    return f"{path}/{key}" if path else key
