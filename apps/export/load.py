"""A payload as controllers and simulators ask for it, made of a result's estimate; bodies as simulators hold them.

MJCF: a body inside the body ``flange``. SDFormat: a model of one link, its origin at the flange; without entries of
the inertia it takes 1 kg m^2, so a point mass needs explicit zeros. URDF: a link fixed to the link ``tool0``. USD:
a prim whose origin is the flange, in the stage's units, for referencing a stage converts nothing; a mass or
diagonalInertia of zero is ignored. The inertial's frame is turned in USD alone. Sources: those of ``simulators``.
"""

import json
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ... import __version__
from ...common import Array, InputError
from ...common.schema import present
from ...estimation.results.payload import FreeEstimate, PayloadResult, PossibleEstimate, array, numbers
from ...model import INERTIAL, InertialParameters, Pose
from ...model.inertia import ten_parameters
from ..numbers import ENTRIES, exact, inertia_entries, interval_digits, placed, principal_axes, quaternion
from ..results import read_stored_payload
from .format import Format, element, texts

_ROUNDING = 1e-12
"""Share of the pseudo-inertia's trace by which its smallest eigenvalue may be negative from rounding."""
_EDGE = 1e-6
"""Share of the trace by which the two smaller principal moments must exceed the largest: controllers hold single
precision, and some simulators check A + B >= C to the last digit.
"""
_DIGITS = 10  # significant digits where a hand may type them and no interval says how many there are
_ALLOWED = 1.05  # by this ratio to the rated payload an estimate may err
_HEAVIEST, _FARTHEST = 5000.0, 10.0  # kg and m: twice what the strongest arms carry, and farther than any reaches
_LEAST = 1e-15  # MuJoCo's mjMINVAL: no moment of inertia may be smaller


@dataclass(frozen=True)
class ControllerLoad:
    """One body and what must be said beside its numbers."""

    body: InertialParameters  # the payload about the origin and in the axes of ``frame``
    frame: str  # in words
    source: str  # file, method and estimator the numbers come from
    verdict: str  # its level
    reasons: tuple[str, ...] = ()  # for the verdict
    point_mass: bool = False  # the inertia is not to be used: only mass and centre of mass are written
    in_tool_frame: bool = False  # ``frame`` is a tool's, not the flange's
    rated: float = math.inf  # payload by the arm's data sheet [kg], where that is known
    meters_per_unit: float = 1.0  # length of the unit of length [m], for formats that have units of their own (USD)
    flange: Pose | None = None  # pose of the robot's flange in ``frame``, if that is another frame and it is known
    flange_source: str = ""  # who says so
    # Of the narrowest 95 % intervals of mass, centre of mass and inertia, infinite where there is none, by which
    # numbers are rounded before they are written; None: they are not.
    half_widths: tuple[float, ...] | None = None
    moment_digits: int | None = None  # decimals of moments, one more than those of a rounded inertia [kg m^2]
    widened: float = 0.0  # added to each moment [kg m^2], by which rounding makes no flat body impossible

    def __post_init__(self) -> None:
        mass, body, fault, units = self.mass, self.body, "", "kg and metres are needed"
        if not self.meters_per_unit > 0.0:
            raise InputError(f"metres per unit must be positive, not {self.meters_per_unit:g}")
        reach = float(np.abs(body.com).max()) if mass > 0.0 else 0.0
        if not mass > 0.0:
            fault = f"a mass of {mass:.3g} kg: controllers refuse it"
        elif not (mass <= _HEAVIEST and reach <= _FARTHEST):
            load = f"{mass:.3g} kg, its centre of mass {reach:.3g} m away"
            fault = f"{load}, is nothing that an arm carries: {units}"
        elif self.point_mass:
            return
        elif not (most := float(np.abs(body.inertia_com).max())) <= mass * _FARTHEST**2:
            fault = f"moments of inertia up to {most:.3g} kg m^2 are nothing that {mass:.3g} kg have: {units}"
        elif (least := body.min_pseudo_inertia_eigenvalue) < -_ROUNDING * np.trace(body.pseudo_inertia):
            found = f"no body has this inertia (pseudo-inertia eigenvalue {least:.2g})"
            fault = f"{found}: take one that can exist, or identify again"
        if fault:
            raise InputError(f"{self.source}: {fault}")

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @property
    def beyond_rating(self) -> str:
        """Fault of a mass that the arm does not carry; empty for others."""
        text = f"a mass of {self.mass:.4g} kg, the arm carries {self.rated:g} kg"
        return text if self.mass > _ALLOWED * self.rated else ""

    @property
    def against(self) -> str:
        """Fault for which it must not be written, its verdict or its mass; empty for others."""
        if self.verdict == "do_not_use":
            return f"the verdict on {self.source} is 'do not use': {'; '.join(self.reasons)}"
        return self.beyond_rating and f"{self.source}: {self.beyond_rating}"

    @property
    def com(self) -> Array:
        """Centre of mass in ``frame`` [m], shape (3,)."""
        return self.body.com

    @property
    def inertia(self) -> Array:
        """Inertia about the centre of mass in the axes of ``frame`` [kg m^2], 3 x 3; zero for a point mass."""
        return np.zeros((3, 3)) if self.point_mass else self.body.inertia_com

    def rounded(self) -> "ControllerLoad":
        """The load with as many digits as its intervals support, two of each half-width, and not too flat."""
        lack = 0.0 if self.point_mass else max(0.0, _EDGE * float(np.trace(self.inertia)) - _excess(self.inertia))
        if self.half_widths is None and not lack:
            return self
        values, places = [np.array(self.mass), self.com, self.inertia + lack * np.eye(3)], []
        for k, half in enumerate(self.half_widths or ()):
            # Two digits of the half-width, or four of the largest number where there is none.
            largest = float(np.abs(values[k]).max())
            four = 3 - int(np.floor(np.log10(largest))) if largest > 0.0 else 4
            places.append(interval_digits(2.0 * half) if 0.0 < half < math.inf else four)
            values[k] = np.round(values[k], places[k])
        (mass, com, inertia), widened, digits = values, self.widened + lack, self.moment_digits
        if places and not self.point_mass:
            unit, digits = 10.0 ** -places[2], places[2] + 1
            # Rounding can make a thin body impossible; one unit is left for the rounding of principal moments.
            while _excess(inertia) < unit:
                inertia, widened = np.round(inertia + unit * np.eye(3), places[2]), widened + unit
        body = InertialParameters(ten_parameters(float(mass), com, inertia))
        return replace(self, body=body, half_widths=None, moment_digits=digits, widened=widened)

    def seen_from(self, pose: Pose, frame: str) -> "ControllerLoad":
        """The load in another frame, whose pose is given in this one."""
        back = pose.inverse()
        return replace(self, body=self.body.moved(back.R, back.p), frame=frame, flange=None)

    def in_flange(self) -> "ControllerLoad | None":
        """The load in the flange, where its frame is the flange or the flange's place in it is known."""
        if is_flange(self.frame):
            return self
        if self.flange is None:
            return None
        frame = f"flange, at {placed(self.flange)} in {self.frame} ({self.flange_source or 'no source'})"
        return self.seen_from(self.flange, frame)


def _excess(inertia: Array) -> float:
    """By how much the two smaller principal moments exceed the largest [kg m^2]."""
    moments = np.linalg.eigvalsh(inertia)
    return float(moments[0] + moments[1] - moments[2])


def is_flange(frame: str) -> bool:
    """Tell whether a payload's frame is the flange: it begins with "tool0", "flange" or "the bare flange"."""
    return re.match(r"[\s:,]*((the|bare)[\s:,]+)*(tool0|flange)([\s:,]|$)", frame.lower()) is not None


def read_load(path: str | Path, method: int | None = None, despite_verdict: bool = False) -> ControllerLoad:
    """The payload of a JSON file; see ``load_of``."""
    return load_of(read_stored_payload(path), Path(path).name, method, despite_verdict)


def load_of(
    result: PayloadResult, name: str, method: int | None = None, despite_verdict: bool = False
) -> ControllerLoad:
    """The payload of a result, in the frame it was identified in.

    Args:
        name: of the result, for messages.
        method: 1 to 4, the recommended one by default; its constrained estimate, which can exist, goes before the
            weighted least-squares one.
        despite_verdict: take the inertia although the verdict is that only mass and centre of mass may be used.

    Raises:
        InputError: if the estimate is not of a body that can exist.
    """
    there, verdict = sorted({estimate.method for estimate in result.estimates}), result.verdict
    number = method if method is not None or not there else result.method
    estimates: tuple[FreeEstimate | PossibleEstimate, ...] = (*result.possible, *result.free)
    estimate = next((each for each in estimates if each.method == number), None)
    if estimate is None:
        raise InputError(f"{name}: no estimate of method {number}; there are {str(there)[1:-1] or 'none'}")
    if isinstance(estimate, PossibleEstimate):
        kind = "constrained"
        parts = (array(estimate.com_interval95, 3, 2), array(estimate.inertia_com_interval95, 3, 3, 2))
        halves = [np.ptp(each, axis=-1) / 2.0 for each in (numbers(estimate.interval95, 2)[9], *parts)]
    else:
        kind = "wls"
        coms = array(estimate.com_sigma, 3), array(estimate.com_sigma_robust, 3)
        inertias = array(estimate.inertia_com_sigma, 3, 3), array(estimate.inertia_com_sigma_robust, 3, 3)
        halves = [2.0 * each for each in (estimate.larger_sigma[9], np.fmax(*coms), np.fmax(*inertias))]
    # The narrowest that is known.
    widths = tuple(float(np.min(half, where=np.isfinite(half) & (half > 0.0), initial=np.inf)) for half in halves)
    source, reasons, ten = f"{name}, method {number} ({kind})", verdict.reasons, estimate.ten
    point_mass = verdict.level == "mass_and_com_only" and not despite_verdict
    if result.assumed and number == result.method:
        label = f"inertia ASSUMED, not measured: {result.assumed.inertia}"
        source, reasons, point_mass = f"{source}, {label}", (*reasons, label), False
        ten, widths = numbers(result.assumed.parameters), (*widths[:2], math.inf)
    if missing := [INERTIAL[k] for k in range(6 if point_mass else 0, 10) if np.isnan(ten[k])]:
        advice = "move more joints, or assume an inertia by 'dynident weigh --inertia box:AxBxC'"
        raise InputError(f"{name}: {', '.join(missing)} was not measured: {advice}")
    if np.isnan(ten).any():  # of a point mass, whose inertia is not used
        body = InertialParameters.from_com(ten[9], ten[6:9] / ten[9], np.zeros((3, 3)))
    else:
        body = InertialParameters(ten)
    flange, rated = present(result.flange_in_payload_frame), result.rated_payload_kg or math.inf
    half_widths, told = widths if math.isfinite(widths[0]) else None, flange.source if flange else ""
    load = ControllerLoad(body, result.frame, source, verdict.level, reasons, point_mass, rated=rated)
    return replace(load, half_widths=half_widths, flange=result.flange, flange_source=told)


def load_head(form: Format[ControllerLoad], load: ControllerLoad) -> list[str]:
    """Head of a file: source, verdict, frame, and what must be known of the numbers of a rounded load."""
    verdict = load.verdict.replace("_", " ").replace("mass and com only", "use mass and centre of mass only")
    lines = [
        f"{form.title}: payload by dynident {__version__} from {load.source}. Verdict: {verdict}.",
        *(f"  {reason}" for reason in load.reasons),
        f"Frame: {load.frame}.",
        *form.remarks,
    ]
    if load.point_mass:
        lines.append(f"Mass and centre of mass only: {form.in_part}.")
    elif "products" not in form.holds:
        largest = float(np.abs(load.inertia[np.triu_indices(3, 1)]).max())
        lost = largest / float(np.diag(load.inertia).min()) if largest > 0.0 else 0.0
        lines.append(f"Products of inertia are lost: the largest is {100 * lost:.2g} % of the smallest moment.")
    if load.widened > 0.0:
        thin = f"A very thin body: {load.widened:.1g} kg m^2 was added to each moment"
        lines.append(f"{thin}, so that rounding does not make it physically impossible.")
    return [*lines, f"Format: {form.source}."]


def number(value: float, digits: int | None = None) -> str:
    """A number without exponent, always with a decimal point: every controller reads it; ``digits``: decimals."""
    value = value if digits is None else round(value, digits)
    text = np.format_float_positional(value, precision=_DIGITS, unique=False, fractional=False, trim="0")
    return "0.0" if float(text) == 0.0 else text


def listed(values: Array, digits: int | None = None) -> str:
    """Several of them, with commas."""
    return ", ".join(number(float(value), digits) for value in np.ravel(values))


def load_format(
    *,
    order: str,
    reference: str = "inertia matrix about the centre of mass, axes of the flange",
    units: str = "kg, m, kg m^2",
    holds: frozenset[str] = frozenset({"products"}),
    **parts: Any,
) -> "partial[Format[ControllerLoad]]":
    """Make a function the format of a payload, which says what its numbers refer to, their order and units."""
    remarks = (f"Reference: {reference}.", f"Order: {order}.", f"Units: {units}.")
    return partial(Format, head=load_head, ready=ControllerLoad.rounded, remarks=remarks, holds=holds, **parts)


def urdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in URDF [kg, m, kg m^2]: entries of the matrix about the centre of mass, in the axes of the link."""
    origin, entries = element("origin", {"xyz": exact(com), "rpy": "0 0 0"}), inertia_entries(inertia)
    return element("inertial", {}, origin, element("mass", {"value": exact(mass)}), element("inertia", entries))


def sdf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in SDFormat; the pose of its inertial frame is not turned."""
    pose = texts({"pose": f"{exact(com)} 0 0 0", "mass": exact(mass)})
    return element("inertial", {}, *pose, element("inertia", {}, *texts(inertia_entries(inertia))))


def mjcf_inertial(mass: float, com: Array, inertia: Array) -> Element:
    """A body in MJCF: entries M11, M22, M33, M12, M13, M23 of the matrix."""
    moments = {"fullinertia": exact(inertia[ENTRIES])} if inertia.any() else {"diaginertia": "0 0 0"}
    return element("inertial", {"pos": exact(com), "mass": exact(mass)} | moments)


def ends(parent: str, child: str, pose: Pose) -> list[Element]:
    """Links of a joint in URDF, and its place in the first one."""
    return [
        element("parent", {"link": parent}),
        element("child", {"link": child}),
        element("origin", {"xyz": exact(pose.origin), "rpy": exact(pose.rpy)}),
    ]


def stage(root: str, unit: str, prims: Iterable[str]) -> str:
    """A stage of USD with the ``unit`` of length [m]; the prim ``root`` is taken by default."""
    about = [f'defaultPrim = "{root}"', "kilogramsPerUnit = 1", f"metersPerUnit = {unit}", 'upAxis = "Z"']
    return "\n".join(["(", *indented(about), ")", "", *prims])


def prim(kind: str, inside: Iterable[str], metadata: Iterable[str] = ()) -> list[str]:
    """Lines of a prim of USD."""
    return [f"def {kind} (", *indented(metadata), ")", "{", *indented(inside), "}"]


def indented(lines: Iterable[str]) -> list[str]:
    """Lines that stand four blanks further in."""
    return [f"    {line}" for line in lines]


def schemas(*names: str) -> str:
    """Metadata that applies schemas to a prim."""
    return f"prepend apiSchemas = [{', '.join(map(json.dumps, names))}]"


@load_format(
    title="MJCF (copy the body payload into the body of your flange)",
    source="MuJoCo XML reference, body/inertial",
    order="pos x, y, z; fullinertia M11, M22, M33, M12, M13, M23",
    in_part="the inertia is zero, a point mass; a moving link needs inertia of its own",
)
def _mjcf(load: ControllerLoad) -> Element:
    least = float(principal_axes(load.inertia)[0].min())
    if not load.point_mass and least < _LEAST:
        raise InputError(f"the smallest moment of inertia is {least:.2g} kg m^2: MuJoCo refuses so small a body")
    body = element("body", {"name": "payload"}, mjcf_inertial(load.mass, load.com, load.inertia))
    world = element("worldbody", {}, element("body", {"name": "flange"}, body))
    return element("mujoco", {"model": "payload"}, world)


@load_format(
    title="SDFormat (fix the link payload to the flange of your robot, origin on origin)",
    source="sdformat.org/spec, inertial",
    order="pose x, y, z, roll, pitch, yaw; ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix",
    in_part="the inertia is zero, a point mass (left out it would be 1 kg m^2); simulators may ask for one of "
    "your own",
)
def _sdf(load: ControllerLoad) -> Element:
    link = element("link", {"name": "payload"}, sdf_inertial(load.mass, load.com, load.inertia))
    return element("sdf", {"version": "1.7"}, element("model", {"name": "payload"}, link))


@load_format(
    title="URDF (copy joint and link payload into your robot, whose flange link is tool0 here)",
    source="wiki.ros.org/urdf/XML/link",
    order="ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix (ixy = -integral of x y dm)",
    in_part="the inertia is zero, a point mass; simulators may ask for one of your own",
)
def _urdf(load: ControllerLoad) -> Element:
    joint = element("joint", {"name": "tool0-payload", "type": "fixed"}, *ends("tool0", "payload", Pose()))
    link = element("link", {"name": "payload"}, urdf_inertial(load.mass, load.com, load.inertia))
    return element("robot", {"name": "payload"}, element("link", {"name": "tool0"}), joint, link)


@load_format(
    title="USD PhysicsMassAPI (stage units; copy into a stage of the same units)",
    source="OpenUSD, UsdPhysicsMassAPI",
    holds=frozenset({"products", "units"}),
    reference="principal moments about the centre of mass, their axes turned by principalAxes out of the prim's",
    order="centerOfMass x, y, z; diagonalInertia along the principal axes; principalAxes w, x, y, z",
    units="kg (kilogramsPerUnit = 1), length in metersPerUnit, inertia in kg times that squared",
    in_part="no diagonalInertia: the simulator makes one from the shapes",
    first_line="#usda 1.0",
)
def _usd(load: ControllerLoad) -> str:
    (moments, axes), unit, digits = principal_axes(load.inertia), load.meters_per_unit, load.moment_digits
    digits = None if digits is None else digits + round(2.0 * math.log10(unit))
    lines = [
        f"float physics:mass = {number(load.mass)}",
        f"point3f physics:centerOfMass = ({listed(load.com / unit)})",
        f"float3 physics:diagonalInertia = ({listed(moments / unit**2, digits)})",
        f"quatf physics:principalAxes = ({listed(quaternion(axes))})",
    ]
    about = [schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI")]
    return stage("payload", number(unit), prim('Xform "payload"', lines[: 2 if load.point_mass else 4], about))


SIMULATORS = {"mjcf": _mjcf, "sdf": _sdf, "urdf": _urdf, "usd": _usd}
"""Formats of a payload for simulators."""
