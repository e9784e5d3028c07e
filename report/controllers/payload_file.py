"""Reads back what ``dynident payload --json`` wrote, and picks the estimate to be exported."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...model import INERTIAL, InertialParameters
from .load import ControllerLoad

PREFERRED = (4, 3, 1, 2)
"""Which method counts where none is named: 4 uses every recording, 2 is the least accurate."""
_FLANGES = ("tool0", "flange")
"""First word of a payload frame that is the flange's."""
_LEVELS = ("use", "mass_and_com_only", "do_not_use")


def read_load(path: str | Path, method: int | None = None, despite_verdict: bool = False) -> ControllerLoad:
    """The payload of a JSON file; see ``load_of_document``.

    Raises:
        InputError: if the file is no such document, or the estimate is not of a body that can exist.
    """
    path = Path(path)
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"{path}: cannot be read as JSON ({error})") from None
    return load_of_document(document, path.name, method, despite_verdict)


def load_of_document(
    document: dict[str, Any], name: str, method: int | None = None, despite_verdict: bool = False
) -> ControllerLoad:
    """The payload of a document, in the frame it was identified in.

    Of the methods the one that is asked for, else the one that the document recommends, else the first of
    ``PREFERRED`` that is there; of its estimates the constrained one, which can exist, else the weighted
    least-squares one.

    Args:
        document: what ``dynident payload --json`` writes.
        name: of the document, for messages.
        method: 1 to 4.
        despite_verdict: take the inertia although the verdict is that only mass and centre of mass may be used.

    Raises:
        InputError: if it is no such document, or the estimate is not of a body that can exist.
    """
    try:
        level = document["verdict"]["level"]
        reasons = tuple(str(reason) for reason in document["verdict"]["reasons"])
        recommended = (document.get("recommended") or {}).get("method")
        estimate = _chosen(document["estimates"], method or recommended, name)
        if level not in _LEVELS:
            raise InputError(f"{name}: verdict {level!r} is none of {', '.join(_LEVELS)}")
        source = f"{name}, method {estimate['method']} ({estimate['estimator']})"
        frame = str(document["frame"])
        assumed = document.get("assumed") if method in (None, recommended) else None
        if assumed:
            label = f"inertia ASSUMED, not measured: {assumed['inertia']}"
            body = _body(assumed["parameters"], name, False)
            return ControllerLoad(body, frame, f"{source}, {label}", level, (*reasons, label))
        point_mass = level == "mass_and_com_only" and not despite_verdict
        body = _body(estimate["parameters"], name, point_mass)
    except InputError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{name}: not a document of 'dynident payload --json' ({error!r})") from None
    return ControllerLoad(body, frame, source, level, reasons, point_mass)


def is_flange(frame: str) -> bool:
    """Whether the frame of a payload is the flange: it begins with "tool0", "flange" or "the bare flange"."""
    words = frame.lower().replace(":", " ").replace(",", " ").split()
    first = next((word for word in words if word not in ("the", "bare")), "")
    return first in _FLANGES


def _body(parameters: dict[str, float | None], name: str, point_mass: bool) -> InertialParameters:
    """The ten as a body; a point mass where the inertia is not to be used and may be missing.

    Raises:
        InputError: if a number that is needed was not measured.
    """
    needed = INERTIAL[6:] if point_mass else INERTIAL
    missing = [kind for kind in needed if parameters[kind] is None]
    if missing:
        raise InputError(
            f"{name}: {', '.join(missing)} was not measured: move more joints, or assume an inertia by 'dynident "
            "weigh --inertia box:AxBxC'"
        )
    if any(parameters[kind] is None for kind in INERTIAL):
        *h, mass = (float(parameters[kind] or 0.0) for kind in needed)
        return InertialParameters.from_com(mass, np.array(h) / mass, np.zeros((3, 3)))
    return InertialParameters(np.array([parameters[kind] for kind in INERTIAL], dtype=float))


def _chosen(estimates: list[dict[str, Any]], method: int | None, name: str) -> dict[str, Any]:
    there = sorted({int(estimate["method"]) for estimate in estimates})
    wanted = next((m for m in PREFERRED if m in there), None) if method is None else method
    of_method = [estimate for estimate in estimates if estimate["method"] == wanted]
    if not of_method:
        raise InputError(
            f"{name}: no estimate of method {wanted}; there are {', '.join(map(str, there)) or 'none'}"
        )
    return next((estimate for estimate in of_method if estimate["estimator"] == "constrained"), of_method[0])
