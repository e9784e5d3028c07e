"""Picks the estimate of a payload's document that is to be exported."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....common.schema import present
from ....estimation.payload.result import PREFERRED
from ....model import INERTIAL, InertialParameters, Pose
from ...results import StoredPayload, read_stored_payload
from ...results.stored_payload import FreeEstimate, PossibleEstimate
from .load import ControllerLoad, HalfWidths


def read_load(path: str | Path, method: int | None = None, despite_verdict: bool = False) -> ControllerLoad:
    """The payload of a JSON file; see ``load_of_document``.

    Raises:
        InputError: if the file is no such document, or the estimate is not of a body that can exist.
    """
    return load_of_document(read_stored_payload(path), Path(path).name, method, despite_verdict)


def load_of_document(
    document: StoredPayload, name: str, method: int | None = None, despite_verdict: bool = False
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
        InputError: if the estimate is not of a body that can exist.
    """
    verdict, rated = document.verdict, present(document.rated_payload_kg) or math.inf
    recommended = document.recommended.method if document.recommended else None
    estimate = _chosen(document.estimates, method or recommended, name)
    source = f"{name}, method {estimate.method} ({_estimator(estimate)})"
    assumed = (document.assumed or None) if method in (None, recommended) else None
    if assumed:
        label = f"inertia ASSUMED, not measured: {assumed.inertia}"
        body = _body(assumed.parameters, name, False)
        reasons = (*verdict.reasons, label)
        load = ControllerLoad(body, document.frame, f"{source}, {label}", verdict.level, reasons, rated=rated)
        widths = _half_widths(estimate)
        load = replace(load, half_widths=widths and widths._replace(inertia=math.inf))
        return _with_flange(load, document)
    point_mass = verdict.level == "mass_and_com_only" and not despite_verdict
    body = _body(estimate.parameters, name, point_mass)
    load = ControllerLoad(body, document.frame, source, verdict.level, verdict.reasons, point_mass, rated=rated)
    load = replace(load, half_widths=_half_widths(estimate))
    return _with_flange(load, document)


def _with_flange(load: ControllerLoad, document: StoredPayload) -> ControllerLoad:
    """The load with the flange's place in its frame, where the document tells it."""
    flange = document.flange_in_payload_frame or None
    if flange is None:
        return load
    pose = Pose.from_rpy(flange.xyz.tolist(), np.radians(flange.rpy_deg).tolist())
    return replace(load, flange=pose, flange_source=flange.source)


def _half_widths(estimate: FreeEstimate | PossibleEstimate) -> HalfWidths | None:
    """Half of the narrowest intervals; None where the document holds none of the mass."""
    if isinstance(estimate, PossibleEstimate):
        spreads: tuple[Any, ...] = (
            (present(estimate.interval95) or {}).get("M"),
            estimate.com_interval95,
            estimate.inertia_com_interval95,
        )
        halves = [_known(bounds, lambda ends: np.ptp(ends, axis=-1) / 2.0) for bounds in spreads]
    else:
        spreads = (
            (present(estimate.sigma_robust) or present(estimate.sigma) or {}).get("M"),
            present(estimate.com_sigma_robust) or estimate.com_sigma,
            present(estimate.inertia_com_sigma_robust) or estimate.inertia_com_sigma,
        )
        halves = [_known(sigma, lambda ends: 2.0 * ends) for sigma in spreads]
    return HalfWidths(*halves) if np.isfinite(halves[0]) else None


def _known(values: Any, half: Callable[[Array], Array]) -> float:
    """The smallest half-width among those that are known; infinite where none is."""
    if present(values) is None:
        return math.inf
    halves = np.atleast_1d(half(np.asarray(values, dtype=float))).ravel()
    return float(np.min(halves[np.isfinite(halves) & (halves > 0.0)], initial=np.inf))


def _body(parameters: Mapping[str, float | None], name: str, point_mass: bool) -> InertialParameters:
    """The ten as a body; a point mass where the inertia is not to be used and may be missing.

    Raises:
        InputError: if a number that is needed was not measured.
    """
    values = np.array([parameters.get(kind) for kind in INERTIAL], dtype=float)
    needed = INERTIAL[6:] if point_mass else INERTIAL
    missing = [kind for kind, value in zip(INERTIAL, values, strict=True) if kind in needed and np.isnan(value)]
    if missing:
        raise InputError(
            f"{name}: {', '.join(missing)} was not measured: move more joints, or assume an inertia by 'dynident "
            "weigh --inertia box:AxBxC'"
        )
    if np.isnan(values).any():
        return InertialParameters.from_com(values[9], values[6:9] / values[9], np.zeros((3, 3)))
    return InertialParameters(values)


def _chosen(
    estimates: tuple[FreeEstimate | PossibleEstimate, ...], method: int | None, name: str
) -> FreeEstimate | PossibleEstimate:
    there = sorted({estimate.method for estimate in estimates})
    number = next((m for m in PREFERRED if m in there), None) if method is None else method
    of_method = [estimate for estimate in estimates if estimate.method == number]
    if not of_method:
        raise InputError(
            f"{name}: no estimate of method {number}; there are {', '.join(map(str, there)) or 'none'}"
        )
    return next((estimate for estimate in of_method if isinstance(estimate, PossibleEstimate)), of_method[0])


def _estimator(estimate: FreeEstimate | PossibleEstimate) -> str:
    return "constrained" if isinstance(estimate, PossibleEstimate) else "wls"
