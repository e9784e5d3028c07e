"""A payload, by a long motion or a short one: first what to use and what to type in."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....common.schema import present
from ....estimation.fit.settings import METHOD_NAMES
from ....estimation.possible.payload import CONFLICT
from ....estimation.results.payload import PayloadResult, array
from ...export.controllers import FORMATS
from ...export.load import is_flange, load_of
from ...numbers import SIX, interval_digits, rounded, six, with_interval
from ..blocks import Block, Code, Notes, OnPage, Pair, Report, Section, Table, Text, lines
from ..figures.payload import flange_figure, repeats_figure, seen
from . import evidence
from .estimates import data_notes, methods_section

_SHOWN = ("abb", "kuka", "ur", "fanuc", "yaskawa", "staubli", "franka", "urdf")
"""The formats in the page; 'dynident export' writes more."""
_USES = {"use": "yes", "do not use": "no", "weighed": "yes: the scale's", "not visible": "no: not visible",
         "assumed": "assumed, not measured", "not measured well enough": "no: too uncertain"}  # fmt: skip
_COVERS = {("centre ", "use"): "yes, all three", ("inertia", "use"): "yes, all six"}
"""A use on the screen; of several numbers it says of how many."""
_MAKERS = {"abb": "abb", "kuka": "kuka", "universal robots": "ur", "fanuc": "fanuc", "yaskawa": "yaskawa",
           "motoman": "yaskawa", "stäubli": "staubli", "staubli": "staubli", "franka": "franka"}  # fmt: skip
"""Word in a robot's title -> its format."""


def payload_report(result: PayloadResult, document: str | None = None, notes: Sequence[str] = ()) -> Report:
    """Verdict, what to type into the controller, quantities, reasons, the worst joint; then what it rests on.

    ``document`` is the JSON file that it was written to.
    """
    best, made, method, level = result.best, result.working, result.method, result.verdict.level
    mass, interval = float(result.mass), tuple(result.mass.interval95.tolist())
    sections = [
        methods_section(result),
        evidence.joints_section(present(result.mass_by_joints) or (), mass, interval),
    ]
    subtitle, worst = "Identified from recordings of joint positions and torques", list[Block]()
    if joints := present(result.joints):
        subtitle = f"Weighed by a motion of joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
    if standing := present(result.standing):
        subtitle = f"Weighed at rest in {standing.poses} poses"
    if (repeats := present(result.repeats)) is not None:
        text = "Each recording was also weighed on its own: their scatter shows what no single one can."
        blocks: list[Block] = [Text(text), *repeats_figure(repeats, mass, interval)]
        sections.insert(0, Section("repeats", "From recording to recording", blocks))
    if not result.short:
        base, source = (made.problem.base, made.problem.source) if made else (None, None)
        count = (len(source.loaded) if source else 0) + (len(made.held_out) if made else 0)
        labels = dict(zip(base.columns, base.names, strict=True)) if base else {}
        sections += [
            evidence.torques_section(lambda: made.predictions, count),
            evidence.excitation_section(lambda: made.excitation, labels),
            evidence.essential_section(present(result.essential), result.title),
        ]
        worst = [evidence.worst_torque(lambda: made.predictions)]
    to_do = [evidence.MEND]
    if level != "do_not_use":
        export = f"'dynident export {document or 'P.json'} --to ur' (abb, kuka, fanuc, ...)"
        line = f"Controller file: {'' if document or not made else 'add --json P.json, then '}{export}."
        to_do = [f"Enter in the controller: {controller_line(result)}.", line]
    controller: list[Block] = [
        Text("What to enter in the controller", heading=True),
        Notes(to_do),
        OnPage(lambda: controller_blocks(result)),
        *([flange_figure(best, result.inertia.use == "use", is_flange(result.frame))] if best else []),
    ]
    first: list[Block] = [
        Text(f"Verdict: {evidence.VERDICTS[level]} (method {method}, {METHOD_NAMES[method]}).", level=level),
        Pair(controller, [quantities_table(result)]),
        *evidence.reason_blocks(result.verdict),
        Notes([*answer_notes(result), *notes], optional=True),
        *worst,
    ]
    more = "every method, all parameters, joints, residuals"
    return Report(f"Payload on the {result.title}", first, sections, more, subtitle, data_notes(result))


def quantities_table(result: PayloadResult) -> Table:
    """Value, 95 % interval and use of mass, centre of mass and inertia there."""
    mass, com, inertia = result.mass, result.com, result.inertia
    numbers = [("mass", "kg", mass.value, mass.interval95, mass.use)]
    for axis, x, ends in zip("xyz", com.value, com.interval95, strict=True):
        numbers.append((f"centre of mass {axis}", "mm", 1e3 * x, 1e3 * ends, com.use))
    names = [f"inertia {'XYZ'[i]}{'XYZ'[j]} at com" for i, j in SIX]
    for name, at in zip(names, SIX, strict=True):
        numbers.append((name, "kg m²", inertia.value[at], inertia.interval95[at], inertia.use))
    rows = [
        (name, unit, *with_interval(float(x), *ends.tolist()), _COVERS.get((name[:7], use), _USES.get(use, use)))
        for name, unit, x, ends, use in numbers
    ]
    headings = ("", "unit", "value", "95 % interval", "use it?")
    ends_at = ("mass", "centre of mass z")
    return Table(f"Payload in {result.frame}", headings, rows, ends_at, merged=True, spare=names[3:])


def answer_notes(result: PayloadResult) -> list[str]:
    """Worst joint, methods side by side, an assumed inertia, scale, other ways to the mass, repeats, gains."""
    worst, chosen, robust = result.joint_that_agrees_least, result.recommended, present(result.best_free.robust)
    residual, masses = present(result.relative_residual), {each.method: each.ten[9] for each in result.estimates}
    each = ", ".join(f"({method}) {x:.4g}" for method, x in sorted(masses.items()) if np.isfinite(x))
    scale = [
        f"The scale says {weighing.mass:g} ± {weighing.sigma:.2g} kg, the torques {weighing.identified:.4g} ± "
        f"{weighing.identified_sigma:.2g} kg: {abs(array(weighing.z)):.1f} sigma apart, so they "
        f"{'contradict each other' if array(weighing.p_value) < CONFLICT else 'agree'}."
        for weighing in present((result.best or result.best_free).weighed) or ()
    ]
    if result.mass_from_scale and result.scale:
        known, sigma = result.scale
        scale = [f"The mass is the scale's, {known:g} ± {sigma:g} kg: the torques of these joints do not show it."]
    noted = lines(
        f"Inertia ASSUMED, not measured: {result.assumed.inertia}." if result.assumed else "",
        f"Largest disagreement: {worst}." if worst else "No joint can be compared with the others.",
        f"Mass by method: {each} kg." if len(masses) > 1 else "",
        f"Method {chosen.method} is recommended: {chosen.reason}." if chosen is not None and chosen.reason else "",
        *evidence.verdict_notes(result.verdict),
        *(scale or ["If you can weigh the payload, --mass KG+-KG checks the torques and sharpens the result."]),
    )
    for way in present(result.agreement) or ():
        com = ", ".join("-" if not np.isfinite(x) else f"{1e3 * x:.1f}" for x in way.com)
        noted.append(f"Cross-check, {way.name}: {array(way.mass):.4g} kg, centre of mass ({com}) mm.")
    if repeats := present(result.repeats):
        _, alone, sigmas = seen(repeats)
        texts = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in zip(alone, sigmas, strict=True))
        spread = f"spread {array(repeats.spread):.2g} kg"
        noted.append(f"The {len(repeats.masses)} recordings on their own [kg]: {texts}; {spread}.")
        if repeats.drift_per_recording is not None:
            trend = "a drift" if repeats.drifts else "no clear drift"
            trend = f"a drift, which the order {repeats.order} cancels" if repeats.order else trend
            step = f"{repeats.drift_per_recording:+.2g} ± {array(repeats.drift_sigma):.2g}"
            noted.append(f"Change from one recording to the next: {step} kg, {trend}.")
        if repeats.excess is not None and repeats.excess > 1.0:
            noted.append(f"They scatter {repeats.excess:.2g} times more than expected; all intervals are widened.")
    if standing := present(result.standing):
        told = "this order cannot show drift; record unloaded, loaded, loaded, unloaded"
        if drift := standing.drift:
            told = f"drift of {array(drift.mass):+.2g} kg per recording removed ({drift.ratio:.0%} of the variance)"
        noted.append(f"{standing.poses} poses at rest, {standing.order}: {told}.")
    noted += evidence.friction_notes(present(result.friction) or ())
    noted += evidence.gain_error_notes(result.settings, result.gains)
    if not result.short and not (residual and residual.validation):
        noted.append("To test the model, keep one recording without payload out of the fit (--validate).")
    if robust and robust.unavailable:
        noted.append(f"Record longer: the intervals assume white noise, because {robust.unavailable}.")
    elif robust and robust.warning:
        noted.append(f"Note: {robust.warning}.")
    return noted


def controller_line(result: PayloadResult) -> str:
    """Mass, centre of mass and, where it may be used, inertia, at the flange; digits as the intervals allow."""
    pose = result.flange
    turn, origin = (pose.R, pose.p) if pose is not None else (np.eye(3), np.zeros(3))
    where = "" if is_flange(result.frame) else f" in {result.frame}"
    where = " at the flange" if pose is not None else where
    com = _numbers(1e3 * (turn.T @ (result.com.value - origin)), 1e3 * result.com.interval95)
    mass = with_interval(float(result.mass), *result.mass.interval95.tolist())[0]
    line, inertia = f"mass {mass} kg, centre of mass ({com}) mm{where}", result.inertia
    moved = turn.T @ inertia.value @ turn
    if result.assumed:
        return f"{line}, inertia about it ({', '.join(f'{x:.4f}' for x in np.diag(moved))}) kg m², ASSUMED"
    if inertia.use == "use" and result.best is not None:
        numbers = _numbers(six(moved), inertia.interval95.reshape(9, 2))
        return f"{line}, inertia about it XX YY ZZ XY XZ YZ ({numbers}) kg m²"
    return f"{line}, inertia zero"


def _numbers(values: Array, intervals: Array) -> str:
    """Numbers with as many digits as the widest of their intervals allows; what is not known is said."""
    widths = np.diff(intervals, axis=1)
    digits = interval_digits(float(np.nanmax(widths, initial=0.0)))
    return ", ".join(rounded(x, digits, "unknown") for x in values.tolist())


def controller_blocks(result: PayloadResult) -> list[Block]:
    """The recommended payload in the formats of controllers; that of the robot's maker, by its title, is open."""
    try:
        load = load_of(result, "this report")
    except InputError as error:
        return [Text(f"No controller takes this payload: {error}.")]
    if load.verdict == "do_not_use":
        return [Text("There is nothing to enter: the verdict is not to use these numbers. See the reasons.")]
    at_flange = load.in_flange()
    if at_flange is None:
        where = (
            f"The payload is given in {load.frame}, but controllers ask for the flange. 'dynident export "
            "payload.json --to NAME --flange-frame X Y Z RX RY RZ' converts it, given the pose of the flange in "
            "that frame. The numbers as identified:"
        )
        return [Text(where), Code("controller-plain", controller_line(result))]
    load = replace(at_flange, reasons=())  # which stand beside it
    maker = next((form for word, form in _MAKERS.items() if word in result.title.lower()), "")

    def written(form: str) -> list[Block]:
        try:
            return [Code(f"controller-{form}", FORMATS[form].text(load).rstrip("\n"))]
        except InputError as error:
            return [Text(f"This controller would refuse it: {error}.")]

    every = {form: OnPage(partial(written, form), FORMATS[form].title, form == maker) for form in _SHOWN}
    own = [every.pop(maker)] if maker else []
    more = Text(f"'dynident export --to' also writes {', '.join(form for form in FORMATS if form not in _SHOWN)}.")
    title = "Other controllers and files" if maker else "Controllers and files"
    return [*own, OnPage(lambda: [*every.values(), more], title)]
