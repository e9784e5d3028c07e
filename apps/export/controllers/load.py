"""A payload as a robot's controller asks for it, and the estimate of a result that becomes it."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....common.schema import present
from ....estimation.results.payload import FreeEstimate, PayloadResult, PossibleEstimate, array, bounds, numbers
from ....model import INERTIAL, InertialParameters, Pose
from ....model.inertia import ten_parameters
from ...numbers import interval_digits
from ...results import read_stored_payload
from .rotation import principal_axes

_FLANGES = ("tool0", "flange")
"""First word of a payload frame that is the flange's."""
_ROUNDING = 1e-12
"""Share of the pseudo-inertia's trace by which its smallest eigenvalue may be negative from rounding."""
_EDGE = 1e-6
"""Share of the trace by which the two smaller principal moments must exceed the largest: controllers hold single
precision, and some simulators check A + B >= C to the last digit.
"""


class HalfWidths(NamedTuple):
    """Half of the narrowest 95 % interval of each quantity; infinite where there is none.

    Attributes:
        mass: [kg].
        com: of the centre of mass [m].
        inertia: of the inertia there [kg m^2].
    """

    mass: float
    com: float
    inertia: float


_ALLOWED = 1.05
"""Of the rated payload: by so much an estimate may err."""
_HEAVIEST, _FARTHEST = 5000.0, 10.0
"""kg and m: twice what the strongest arms carry, and farther than any reaches."""


@dataclass(frozen=True)
class ControllerLoad:
    """One body and what must be said beside its numbers.

    Attributes:
        body: the payload about the origin and in the axes of ``frame``.
        frame: the frame, in words.
        source: file, method and estimator the numbers come from.
        verdict: level of the verdict.
        reasons: for the verdict.
        point_mass: whether the inertia at the centre of mass is not to be used: only mass and centre of mass are
            written.
        in_tool_frame: whether ``frame`` is a tool's, not the flange's.
        flange: where the robot's flange stands in ``frame``, if that is another frame and it is known.
        flange_source: who says so.
        half_widths: of the intervals, by which numbers are rounded before they are written; None: they are not.
        inertia_digits: decimals of the inertia [kg m^2], where it is rounded.
        added: to each moment before, so that the rounded body can exist [kg m^2].
        rated: what the arm carries by its data sheet [kg]; inf where that is not known.
        meters_per_unit: length of the unit of length [m], for formats that have units of their own (USD).
    """

    body: InertialParameters
    frame: str
    source: str
    verdict: str
    reasons: tuple[str, ...] = ()
    point_mass: bool = False
    in_tool_frame: bool = False
    rated: float = math.inf
    meters_per_unit: float = 1.0
    flange: Pose | None = None
    flange_source: str = ""
    half_widths: HalfWidths | None = None
    inertia_digits: int | None = None
    added: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a load that no controller takes.

        Raises:
            InputError: for a mass that is not positive, and for an inertia that no body has.
        """
        if not self.body.mass > 0.0:
            raise InputError(f"{self.source}: a mass of {self.body.mass:.3g} kg: controllers refuse it")
        mass, reach = self.body.mass, float(np.abs(self.body.com).max())
        if not (mass <= _HEAVIEST and reach <= _FARTHEST):
            raise InputError(
                f"{self.source}: {mass:.3g} kg, its centre of mass {reach:.3g} m away, is nothing that an arm "
                "carries: kg and metres are needed"
            )
        if not self.point_mass and not np.abs(self.body.inertia_com).max() <= mass * _FARTHEST**2:
            raise InputError(
                f"{self.source}: moments of inertia up to {np.abs(self.body.inertia_com).max():.3g} kg m^2 are "
                f"nothing that {mass:.3g} kg have: kg and metres are needed"
            )
        if not self.meters_per_unit > 0.0:
            raise InputError(f"metres per unit must be positive, not {self.meters_per_unit:g}")
        pseudo = self.body.pseudo_inertia
        if not self.point_mass and self.body.min_pseudo_inertia_eigenvalue < -_ROUNDING * np.trace(pseudo):
            raise InputError(
                f"{self.source}: no body has this inertia (pseudo-inertia eigenvalue "
                f"{self.body.min_pseudo_inertia_eigenvalue:.2g}): take one that can exist, or identify again"
            )

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @property
    def beyond_rating(self) -> str:
        """What is told of a mass that the arm does not carry; empty for others."""
        if not self.mass > _ALLOWED * self.rated:
            return ""
        return f"a mass of {self.mass:.4g} kg, the arm carries {self.rated:g} kg"

    @property
    def com(self) -> Array:
        """Centre of mass in ``frame`` [m], shape (3,)."""
        return self.body.com

    @cached_property
    def inertia(self) -> Array:
        """Inertia about the centre of mass in the axes of ``frame`` [kg m^2], 3 x 3; zero for a point mass."""
        return np.zeros((3, 3)) if self.point_mass else self.body.inertia_com + self._lack * np.eye(3)

    @property
    def widened(self) -> float:
        """What is added to each moment [kg m^2] where a body is so flat or thin that rounding could make it
        impossible; else zero. A constrained estimate often is.
        """
        return self.added + self._lack

    @cached_property
    def _lack(self) -> float:
        if self.point_mass:
            return 0.0
        moments = np.linalg.eigvalsh(self.body.inertia_com)
        return max(0.0, float(_EDGE * moments.sum() - _excess(self.body.inertia_com)))

    def rounded(self) -> "ControllerLoad":
        """The load with as many digits as its intervals support: two of each half-width."""
        if self.half_widths is None:
            return self
        mass, com = (
            np.round(value, _digits(value, half))
            for value, half in ((np.array(self.mass), self.half_widths.mass), (self.com, self.half_widths.com))
        )
        digits, added = None, 0.0
        inertia = self.inertia
        if not self.point_mass:
            digits = _digits(inertia, self.half_widths.inertia)
            unit = 10.0**-digits
            inertia = np.round(inertia, digits)
            # Rounding can make a thin body impossible; one unit is left for the rounding of principal moments.
            while _excess(inertia) < unit:
                inertia, added = np.round(inertia + unit * np.eye(3), digits), added + unit
        body = InertialParameters(ten_parameters(float(mass), com, inertia))
        return replace(self, body=body, half_widths=None, inertia_digits=digits, added=self.widened + added)

    @cached_property
    def principal(self) -> tuple[Array, Array]:
        """Principal moments at the centre of mass [kg m^2], shape (3,), and their axes as columns, 3 x 3."""
        return principal_axes(self.inertia)

    @cached_property
    def products_lost(self) -> float:
        """Largest product of inertia over the smallest moment, in the axes of ``frame``: what a format loses that
        takes the moments alone.
        """
        largest = float(np.abs(self.inertia[np.triu_indices(3, 1)]).max())
        return largest / float(np.diag(self.inertia).min()) if largest > 0.0 else 0.0

    def seen_from(self, rotation: Array, origin: Array, frame: str) -> "ControllerLoad":
        """Move the load to another frame, which is given in this one.

        Args:
            rotation: 3 x 3; columns are the other frame's axes in this one.
            origin: of the other frame in this one [m], shape (3,).
            frame: the other frame, in words.
        """
        return replace(self, body=self.body.moved(rotation.T, -rotation.T @ origin), frame=frame, flange=None)

    def in_flange(self) -> "ControllerLoad | None":
        """The load in the flange, where its frame is the flange or the flange's place in it is known."""
        if is_flange(self.frame):
            return self
        if self.flange is None:
            return None
        x, y, z = self.flange.origin
        turn = ", ".join(f"{np.degrees(angle) + 0.0:g}" for angle in self.flange.rpy)
        place = f"({x:g}, {y:g}, {z:g}) m, ({turn}) deg"
        frame = f"flange, at {place} in {self.frame} ({self.flange_source or 'no source'})"
        return self.seen_from(self.flange.R, self.flange.p, frame)


def _digits(values: Array, half_width: float) -> int:
    """Decimals: two digits of the half-width, or four of the largest number where there is none."""
    if np.isfinite(half_width) and half_width > 0.0:
        return interval_digits(2.0 * half_width)
    largest = float(np.abs(values).max())
    return 3 - int(np.floor(np.log10(largest))) if largest > 0.0 else 4


def _excess(inertia: Array) -> float:
    """By how much the two smaller principal moments exceed the largest [kg m^2]."""
    moments = np.linalg.eigvalsh(inertia)
    return float(moments[0] + moments[1] - moments[2])


def is_flange(frame: str) -> bool:
    """Whether the frame of a payload is the flange: it begins with "tool0", "flange" or "the bare flange"."""
    words = frame.lower().replace(":", " ").replace(",", " ").split()
    first = next((word for word in words if word not in ("the", "bare")), "")
    return first in _FLANGES


def read_load(path: str | Path, method: int | None = None, despite_verdict: bool = False) -> ControllerLoad:
    """The payload of a JSON file; see ``load_of``.

    Raises:
        InputError: if the file is no such document, or the estimate is not of a body that can exist.
    """
    return load_of(read_stored_payload(path), Path(path).name, method, despite_verdict)


def load_of(
    result: PayloadResult, name: str, method: int | None = None, despite_verdict: bool = False
) -> ControllerLoad:
    """The payload of a result, in the frame it was identified in.

    Of the methods the one that is asked for, else the recommended one; of its estimates the constrained one, which
    can exist, else the weighted least-squares one.

    Args:
        name: of the result, for messages.
        method: 1 to 4.
        despite_verdict: take the inertia although the verdict is that only mass and centre of mass may be used.

    Raises:
        InputError: if the estimate is not of a body that can exist.
    """
    there = sorted({estimate.method for estimate in result.estimates})
    number = method if method is not None or not there else result.method
    estimates: tuple[FreeEstimate | PossibleEstimate, ...] = (*result.possible, *result.free)
    chosen = [estimate for estimate in estimates if estimate.method == number]
    if not chosen:
        raise InputError(
            f"{name}: no estimate of method {number}; there are {', '.join(map(str, there)) or 'none'}"
        )
    estimate, verdict, widths = chosen[0], result.verdict, _half_widths(chosen[0])
    kind = "constrained" if isinstance(estimate, PossibleEstimate) else "wls"
    source, reasons, ten = f"{name}, method {number} ({kind})", verdict.reasons, estimate.ten
    point_mass = verdict.level == "mass_and_com_only" and not despite_verdict
    if result.assumed and number == result.method:
        label = f"inertia ASSUMED, not measured: {result.assumed.inertia}"
        source, reasons, point_mass = f"{source}, {label}", (*reasons, label), False
        ten, widths = numbers(result.assumed.parameters), widths and widths._replace(inertia=math.inf)
    place = present(result.flange_in_payload_frame)
    return ControllerLoad(
        _body(ten, name, point_mass),
        result.frame,
        source,
        verdict.level,
        reasons,
        point_mass,
        rated=result.rated_payload_kg or math.inf,
        half_widths=widths,
        flange=result.flange,
        flange_source=place.source if place else "",
    )


def _half_widths(estimate: FreeEstimate | PossibleEstimate) -> HalfWidths | None:
    """Half of the narrowest intervals; None where there is none of the mass."""
    if isinstance(estimate, PossibleEstimate):
        ends = (
            bounds(estimate.interval95)[9],
            array(estimate.com_interval95, 3, 2),
            array(estimate.inertia_com_interval95, 3, 3, 2),
        )
        halves = [_least(np.ptp(each, axis=-1) / 2.0) for each in ends]
    else:
        coms = array(estimate.com_sigma, 3), array(estimate.com_sigma_robust, 3)
        inertias = array(estimate.inertia_com_sigma, 3, 3), array(estimate.inertia_com_sigma_robust, 3, 3)
        halves = [_least(2.0 * each) for each in (estimate.larger_sigma[9], np.fmax(*coms), np.fmax(*inertias))]
    return HalfWidths(*halves) if np.isfinite(halves[0]) else None


def _least(halves: Array) -> float:
    """The smallest of those that are known; infinite where none is."""
    return float(np.min(halves, where=np.isfinite(halves) & (halves > 0.0), initial=np.inf))


def _body(values: Array, name: str, point_mass: bool) -> InertialParameters:
    """The ten as a body; a point mass where the inertia is not to be used and may be missing.

    Raises:
        InputError: if a number that is needed was not measured.
    """
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
