"""Numbers of JSON documents by their path, and how near a new one must be to the frozen one.

Each rule is a share of something with the number's own unit: of its standard deviation where the document tells
one, else of the largest number beside it. Words are no numbers: of strings only names, kinds and levels count.
"""

import math
from typing import Any, NamedTuple

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
"""A constraint's zero is zero: share of the size of what it belongs to."""
UNDECIDED = 0.05
"""Share of the size, for what the data leave open: how far links that are not at their bound are from it."""
FLOOR = 1e-12
"""Zero, for a solver, in SI units."""
SCORE = 1e-9
"""Tolerance for a motion that is not searched: share of the size."""
WORSE = 0.03
"""The motion a search finds may be worse than the frozen one by this."""
_MANY = 60
"""Longer lists are thinned to about this many numbers."""
_COUNTED = ("robot", "name", "kind", "level", "estimator", "criterion", "segments", "columns", "shape")
"""Keys whose strings are compared."""
_UNCERTAIN_TIMES = "cpu_s"
_MADE_ZERO = ("min_pseudo_inertia_eigenvalue", "min_eigenvalues")
_BY_SOLVER = ("constrained", "quantities", "agreement", "assumed")
_SIGMA = {
    "parameters": "sigma",
    "value": "sigma",
    "values": "sigma",
    "mass": "sigma",
    "com": "com_sigma",
    "inertia_com": "inertia_com_sigma",
    "interval95": "sigma",
}
"""Name of a value -> name of its standard deviation beside it."""
_FIXED = ("robot", "criterion", "limits/met", "limits/max_violation", "seed", "interrupted", "visibility/rank")
"""Leaves of a design that are the same whatever motion is found."""
_SIGMAS = ("predicted_sigma/mass", "predicted_sigma/com/", "predicted_sigma/inertia_com/")


class Change(NamedTuple):
    """One leaf that differs by more than it may."""

    path: str
    old: object
    new: object
    allowed: str


def leaves(document: Any, path: str = "") -> Leaves:
    """Numbers and counted names of a document; long lists and matrices thinned, with their shape."""
    if isinstance(document, dict):
        return {k: v for key, value in document.items() for k, v in leaves(value, _join(path, key)).items()}
    if not isinstance(document, list):
        counts = not isinstance(document, str) or _parts(path)[-1] in _COUNTED
        return {path: float(f"{document:.12g}") if isinstance(document, float) else document} if counts else {}
    matrix = all(isinstance(row, list) and row and isinstance(row[0], float | int) for row in document)
    rows, columns = len(document), len(document[0]) if matrix and document else 0
    step, entries = 1, Leaves()
    if columns and rows * columns > _MANY:
        entries[_join(path, "shape")] = f"{rows} x {columns}"
        for i in range(0, rows, -(-rows // _MANY)):
            entries |= leaves(document[i][i % columns], f"{path}/{i}/{i % columns}")
        return entries
    if rows > _MANY and not isinstance(document[0], dict | list):
        entries[_join(path, "shape")], step = str(rows), -(-rows // _MANY)
    for i in range(0, rows, step):
        entries |= leaves(document[i], _join(path, str(i)))
    return entries


def changes(old: Leaves, new: Leaves, share: float = FREE) -> list[Change]:
    """Leaves that differ by more than they may, those that are gone, and new ones."""
    rows = _keys(old, new)
    for path in old.keys() & new.keys():
        was, now = old[path], new[path]
        if path.endswith(_UNCERTAIN_TIMES) or (type(was) is type(now) and was == now):
            continue
        allowed = 0.0
        if isinstance(was, float) and isinstance(now, float | int) and not isinstance(now, bool):
            allowed = tolerance(path, old, share)
            if abs(now - was) <= allowed:
                continue
        rows.append(Change(path, was, now, f"±{allowed:.1e}"))
    return rows


def searched_changes(old: Leaves, new: Leaves) -> list[Change]:
    """Changes of a design: the same keys, settings that hold, and a score that is hardly worse."""
    rows = _keys(old, new)
    rows += [Change(k, old.get(k), new.get(k), "exact") for k in _FIXED if old.get(k) != new.get(k)]
    if not rows and not worse(old, new) <= WORSE:
        rows.append(Change("score", "1", f"{1 + worse(old, new):.4f}", f"at most {1 + WORSE}"))
    return rows


def worse(old: Leaves, new: Leaves) -> float:
    """Share by which a design is worse: its criterion, or the mean sigma near a pose."""
    score = "criterion_value"
    if score in old:
        return math.expm1((_number(new, score) or 0.0) - (_number(old, score) or 0.0))
    ratios = [(_number(new, k) or 0.0) / (_number(old, k) or 1.0) for k in old if k.startswith(_SIGMAS)]
    return sum(ratios) / len(ratios) - 1.0


def tolerance(path: str, frozen: Leaves, share: float = FREE) -> float:
    """Tolerance of a number about the frozen one."""
    parts = path.split("/")
    free, solved = _free_and_solved(parts, frozen)
    scale = (sigma := _sigma(parts, free, frozen)) or _size(parts, frozen)
    if any(sibling.startswith("drive_gains/") for sibling in frozen):
        return ITERATED[0 if sigma else 1] * scale
    if solved and any(name in parts for name in _MADE_ZERO):
        parameters = [
            abs(_number(frozen, k) or 0.0) for k in frozen if free and k.startswith(f"{free}/parameters/")
        ]
        return ZERO * max(parameters, default=1.0) + UNDECIDED * abs(_number(frozen, path) or 0.0)
    by_body = parts[:2] in (["quantities", "centre_of_mass"], ["quantities", "inertia"])  # sigma by its gradients
    if solved and (by_body or not any(part.startswith("sigma") for part in parts)):
        return max(CONSTRAINED * scale, FLOOR)
    return share * scale


def _free_and_solved(parts: list[str], frozen: Leaves) -> tuple[str, bool]:
    """Path of the free estimate by the same method, if any, and whether a solver of cones gave the number."""
    if parts[0] != "estimates":
        return "", parts[0] in _BY_SOLVER and parts[-1] != "free"
    method = frozen.get(f"estimates/{parts[1]}/method")
    stems = [k.removesuffix("/estimator") for k, v in frozen.items() if k.endswith("/estimator") and v == "wls"]
    free = next((stem for stem in stems if frozen.get(f"{stem}/method") == method), "")
    return free, frozen.get(f"estimates/{parts[1]}/estimator") == "constrained"


def _sigma(parts: list[str], free: str, frozen: Leaves) -> float | None:
    """Standard deviation of the value at a path, or of the free estimate's where there is none."""
    for place in (parts, [*free.split("/"), *parts[2:]] if free else parts[1:]):
        for i, part in enumerate(place):
            name = _SIGMA.get(part.removesuffix("_robust").removesuffix("_interval95"))
            for end in range(len(place), i, -1) if name else ():
                sigma = _number(frozen, "/".join([*place[:i], str(name), *place[i + 1 : end]]))
                if sigma:
                    return sigma
    return None


def _size(parts: list[str], frozen: Leaves) -> float:
    """Largest number of the list or matrix that holds the value; of a variance or a single value its own."""
    path, stem = "/".join(parts), _parts("/".join(parts))
    if len(stem) == len(parts) or stem[0].startswith("covariance"):
        return abs(_number(frozen, path) or 0.0)
    return max(abs(_number(frozen, k) or 0.0) for k in frozen if k.startswith("/".join(stem) + "/"))


def _keys(old: Leaves, new: Leaves) -> list[Change]:
    gone = [Change(path, old[path], "(gone)", "exact") for path in old if path not in new]
    return gone + [Change(path, "(not there)", new[path], "exact") for path in new if path not in old]


def _number(frozen: Leaves, path: str) -> float | None:
    value = frozen.get(path)
    return float(value) if isinstance(value, float | int) and not isinstance(value, bool) else None


def _parts(path: str) -> list[str]:
    """The parts of a path, without the numbers of list entries at its end."""
    parts = path.split("/")
    while len(parts) > 1 and parts[-1].isdigit():
        parts.pop()
    return parts


def _join(path: str, key: str) -> str:
    return f"{path}/{key}" if path else key
