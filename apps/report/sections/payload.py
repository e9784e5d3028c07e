"""A payload, by a long motion or a short one: first what to use and what to type in; then what it rests on."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import starmap
from typing import Any

import numpy as np

from ....common import Array, InputError
from ....estimation import METHOD_NAMES
from ....estimation.fit.covariance import NORMAL95
from ....estimation.payload.by_joints import Repeats
from ....estimation.payload.short_motion import OFFSET_SHARE, RIPPLE_CHANCE
from ....estimation.possible.payload import CONFLICT
from ....estimation.results.payload import PayloadResult, PossibleEstimate, array, numbers
from ....model import INERTIAL
from ...export.controllers import FORMATS
from ...export.load import is_flange, load_of
from ...numbers import ENTRIES, SIX, interval_digits, rounded, with_interval, with_sigma
from ..blocks import Block, Drawing, Notes, OnPage, Pair, Report, Section, Table, Text
from ..figures import BLUE, ORANGE, VIEWS, interval_rows, legend, panels
from . import evidence

_SHOWN = ("abb", "kuka", "ur", "fanuc", "yaskawa", "staubli", "franka", "urdf")
"""The formats in the page; 'dynident export' writes more."""
_USES = {"use": "yes", "do not use": "no", "weighed": "yes: the scale's", "not visible": "no: not visible",
         "assumed": "assumed, not measured", "not measured well enough": "no: too uncertain"}  # fmt: skip
_COVERS = {("centre ", "use"): "yes, all three", ("inertia", "use"): "yes, all six"}
"""A use on the screen; of several numbers it says of how many."""
_MAKERS = {"abb": "abb", "kuka": "kuka", "universal robots": "ur", "fanuc": "fanuc", "yaskawa": "yaskawa",
           "motoman": "yaskawa", "stäubli": "staubli", "staubli": "staubli", "franka": "franka"}  # fmt: skip
"""Word in a robot's title -> its format."""
_MOMENTS = [f"{'XYZ'[i]}{'XYZ'[j]} at com" for i, j in SIX]
_UNITS = {
    **dict.fromkeys(INERTIAL[:6], "kg m²"),
    **dict.fromkeys(INERTIAL[6:9], "kg m"),
    "M": "kg",
    **dict.fromkeys((f"com {axis}" for axis in "xyz"), "m"),
    **dict.fromkeys((*_MOMENTS, "smallest moment", "middle moment", "largest moment"), "kg m²"),
}
"""The ten parameters, the centre of mass, the inertia and its principal moments there, with units."""
_PLATE = 31.5  # mm: half of the plate of ISO 9409-1-50, to compare sizes with
_NAME = 24  # letters of a recording's name
_FREE = 0.22  # the free estimate stands this much below the constrained one
_METHODS = {
    1: "from the loaded torques minus those of the robot identified without payload",
    2: "from the change of the robot's base parameters",
    3: "from the difference of the torques on the same trajectory",
    4: "robot and payload together, from all recordings",
}


def payload_report(result: PayloadResult, document: str | None = None, notes: Sequence[str] = ()) -> Report:
    """Verdict, what to enter, quantities, reasons; what it rests on; ``document``: its JSON file."""
    best, made, method, level = result.best, result.working, result.method, result.verdict.level
    agreed = (float(result.mass), *result.mass.interval95.tolist())
    sections = [methods_section(result), evidence.joints_section(result.mass_by_joints or (), agreed)]
    subtitle, more = "Identified from recordings of joint positions and torques", list[Block]()
    if joints := result.joints:
        subtitle = f"Weighed by a motion of joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
    if result.standing:
        subtitle = f"Weighed at rest in {result.standing.poses} poses"
    if result.repeats:
        sections.insert(0, repeats_section(result.repeats, agreed))
    if not result.joints:
        worst, *measured = evidence.explained(made, lambda: (*made.problem.source.loaded, *made.held_out))
        more = [worst]
        sections += [*measured, evidence.essential_section(result.essential or None, result.title)]
    to_do = [evidence.MEND]
    if level != "do_not_use":
        export = f"'dynident export {document or 'P.json'} --to ur' (abb, kuka, fanuc, ...)"
        line = f"Controller file: {'' if document or not made else 'add --json P.json, then '}{export}."
        to_do = [f"Enter in the controller: {controller_line(result)}.", line]
    controller: list[Block] = [
        Text("What to enter in the controller", heading=True),
        Notes(to_do),
        OnPage(partial(controller_blocks, result)),
        *([OnPage(partial(flange_blocks, result, best))] if best else []),
    ]
    rows, com, inertia = [], result.com, result.inertia
    centres = ((f"centre of mass {'xyz'[k]}", "mm", com, 1e3, k) for k in range(3))
    moments = ((f"inertia {name}", "kg m²", inertia, 1.0, at) for name, at in zip(_MOMENTS, SIX, strict=True))
    for name, unit, of, scale, at in (("mass", "kg", result.mass, 1.0, ()), *centres, *moments):
        shown = with_interval(float(scale * of.value[at]), *(scale * of.interval95[at]).tolist())
        rows.append((name, unit, *shown, _COVERS.get((name[:7], of.use), _USES.get(of.use, of.use))))
    headings, spare = ("", "unit", "value", "95 % interval", "use it?"), [row[0] for row in rows[7:]]
    ends = ("mass", "centre of mass z")
    quantities = Table(f"Payload in {result.frame}", headings, rows, ends, merged=True, spare=spare)
    first: list[Block] = [
        Text(f"Verdict: {evidence.VERDICTS[level]} (method {method}, {METHOD_NAMES[method]}).", level=level),
        Pair(controller, [quantities]),
        *evidence.reason_blocks(result.verdict),
        Notes([*answer_notes(result), *notes], optional=True),
        *more,
    ]
    details, told = "every method, all parameters, joints, residuals", list(data_notes(result))
    return Report(f"Payload on the {result.title}", first, sections, details, subtitle, told)


def repeats_section(repeats: Repeats, agreed: Sequence[float]) -> Section:
    """Mass [kg] by each recording in the order they were given, ``agreed`` by all; drawn where two show it."""
    masses, sigmas = (np.array(x, dtype=float) for x in (repeats.masses, repeats.sigmas))
    shown, reach = np.flatnonzero(np.isfinite(masses)).tolist(), NORMAL95 * sigmas

    def draw() -> list[Block]:
        names = [f"{k}: {source[-_NAME:]}" for k, source in enumerate(repeats.sources, 1)]
        figure, ((axis,),) = panels((7.0, 0.32 * len(names) + 1.0))
        interval_rows(axis, names, np.column_stack([masses, masses - reach, masses + reach]), agreed)
        axis.set_xlabel("mass [kg]")
        caption = (
            "The mass by each recording alone, in order, with two standard deviations; the dashed line and the "
            "band are the answer by all of them."
        )
        told = "; ".join(f"recording {k + 1} {masses[k]:.4g} kg" for k in shown)
        return [Drawing("repeats", caption, figure, f"{caption} {told}.")]

    text = "Each recording was also weighed on its own: their scatter shows what no single one can."
    drawn = [OnPage(draw)] * (len(shown) > 1)
    return Section("repeats", "From recording to recording", [Text(text), *drawn])


def answer_notes(result: PayloadResult) -> Iterator[str]:
    """Worst joint, methods side by side, an assumed inertia, scale, other ways to the mass, repeats, gains."""
    worst, chosen, robust = result.joint_that_agrees_least, result.recommended, result.best_free.robust
    residual, masses = result.relative_residual, {each.method: each.ten[9] for each in result.estimates}
    yield f"Inertia ASSUMED, not measured: {result.assumed.inertia}." if result.assumed else ""
    yield f"Largest disagreement: {worst}." if worst else "No joint can be compared with the others."
    if len(masses) > 1:
        each = ", ".join(f"({method}) {x:.4g}" for method, x in sorted(masses.items()) if np.isfinite(x))
        yield f"Mass by method: {each} kg."
    if chosen is not None and chosen.reason:
        yield f"Method {chosen.method} is recommended: {chosen.reason}."
    yield from (f"Note: {text}." for text in result.verdict.notes)
    weighings = (result.best or result.best_free).weighed or ()
    if result.mass_from_scale and result.scale:
        weighed = "{:g} ± {:g} kg".format(*result.scale)
        yield f"The mass is the scale's, {weighed}: the torques of these joints do not show it."
    elif not weighings:
        yield "If you can weigh the payload, --mass KG+-KG checks the torques and sharpens the result."
    else:
        yield from (
            f"The scale says {own.mass:g} ± {own.sigma:.2g} kg, the torques {own.identified:.4g} ± "
            f"{own.identified_sigma:.2g} kg: {abs(array(own.z)):.1f} sigma apart, so they "
            f"{'contradict each other' if array(own.p_value) < CONFLICT else 'agree'}."
            for own in weighings
        )
    for way in result.agreement or ():
        com = ", ".join("-" if not np.isfinite(x) else f"{1e3 * x:.1f}" for x in way.com)
        yield f"Cross-check, {way.name}: {array(way.mass):.4g} kg, centre of mass ({com}) mm."
    if repeats := result.repeats:
        alone = zip(map(array, repeats.masses), map(array, repeats.sigmas), strict=True)
        texts = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in alone if np.isfinite(m))
        spread = f"spread {array(repeats.spread):.2g} kg"
        yield f"The {len(repeats.masses)} recordings on their own [kg]: {texts}; {spread}."
        if repeats.drift_per_recording is not None:
            trend = "a drift" if repeats.drifts else "no clear drift"
            trend = f"a drift, which the order {repeats.order} cancels" if repeats.order else trend
            step = f"{repeats.drift_per_recording:+.2g} ± {array(repeats.drift_sigma):.2g}"
            yield f"Change from one recording to the next: {step} kg, {trend}."
        if repeats.excess is not None and repeats.excess > 1.0:
            yield f"They scatter {repeats.excess:.2g} times more than expected; all intervals are widened."
    if standing := result.standing:
        told = "this order cannot show drift; record unloaded, loaded, loaded, unloaded"
        if drift := standing.drift:
            told = f"drift of {array(drift.mass):+.2g} kg per recording removed ({drift.ratio:.0%} of the variance)"
        yield f"{standing.poses} poses at rest, {standing.order}: {told}."
    yield from evidence.model_notes(result)
    if not result.joints and not (residual and residual.validation):
        yield "To test the model, keep one recording without payload out of the fit (--validate)."
    if robust and robust.unavailable:
        yield f"Record longer: the intervals assume white noise, because {robust.unavailable}."
    elif robust and robust.warning:
        yield f"Note: {robust.warning}."


def controller_line(result: PayloadResult) -> str:
    """Mass, centre of mass and, where it may be used, inertia, at the flange; digits as the intervals allow."""
    pose, inertia = result.flange, result.inertia
    turn, origin = (pose.R, pose.p) if pose is not None else (np.eye(3), np.zeros(3))
    place, moved = 1e3 * (turn.T @ (result.com.value - origin)), turn.T @ inertia.value @ turn
    intervals, listed = (1e3 * result.com.interval95, inertia.interval95.reshape(9, 2)), list[str]()
    for values, ends in zip((place, moved[ENTRIES]), intervals, strict=True):
        # As many digits as the widest interval allows.
        digits = interval_digits(float(np.nanmax(np.diff(ends, axis=1), initial=0.0)))
        listed.append(", ".join(rounded(x, digits, "unknown") for x in values.tolist()))
    where = "" if is_flange(result.frame) else f" in {result.frame}"
    where = " at the flange" if pose is not None else where
    mass = with_interval(float(result.mass), *result.mass.interval95.tolist())[0]
    line = f"mass {mass} kg, centre of mass ({listed[0]}) mm{where}"
    if result.assumed:
        return f"{line}, inertia about it ({', '.join(f'{x:.4f}' for x in np.diag(moved))}) kg m², ASSUMED"
    if inertia.use == "use" and result.best is not None:
        return f"{line}, inertia about it XX YY ZZ XY XZ YZ ({listed[1]}) kg m²"
    return f"{line}, inertia zero"


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
        return [Text(where), Text(controller_line(result), copied="controller-plain")]
    load = replace(at_flange, reasons=())  # which stand beside it
    maker = next((form for word, form in _MAKERS.items() if word in result.title.lower()), "")
    every = dict[str, OnPage]()
    for form in _SHOWN:
        try:
            written = Text(FORMATS[form].text(load).rstrip("\n"), copied=f"controller-{form}")
        except InputError as error:
            written = Text(f"This controller would refuse it: {error}.")
        every[form] = OnPage(partial(list, [written]), FORMATS[form].title, form == maker)
    more = Text(f"'dynident export --to' also writes {', '.join(form for form in FORMATS if form not in _SHOWN)}.")
    title = "Other controllers and files" if maker else "Controllers and files"
    return [*([every.pop(maker)] if maker else []), OnPage(lambda: [*every.values(), more], title)]


def flange_blocks(result: PayloadResult, payload: PossibleEstimate) -> list[Block]:
    """Three views to one scale, the uncertainty enlarged; the plate of a flange, the body of a known inertia."""
    from matplotlib import patches

    com, ends = 1e3 * array(payload.com, 3), 1e3 * array(payload.com_interval95, 3, 2)
    flange = is_flange(result.frame)
    points = [np.full(3, -1.25 * _PLATE), np.full(3, 1.25 * _PLATE), com - 12.0, com + 12.0]
    origin = "the flange, drawn as a plate of 63 mm (ISO 9409-1-50)" if flange else "the frame's origin"
    caption = f"Centre of mass seen along y, along x and along z, from {origin}, to scale."
    body, known = None, bool(np.isfinite(ends).all())
    if known:
        caption += " Bars and ellipse: its 95 % intervals, enlarged below."
        points += list(ends.T)
    if result.inertia.use == "use":
        # Squared semi-axes of the homogeneous ellipsoid of the same inertia, as a matrix [mm^2].
        J = array(payload.inertia_com, 3, 3)
        body = 5e6 / payload.body.mass * (0.5 * np.trace(J) * np.eye(3) - J)
        caption += " Dashed: equivalent ellipsoid, homogeneous and of the identified mass and inertia."
        reach = np.sqrt(np.maximum(np.diag(body), 0.0))
        points += [com - reach, com + reach]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle, half = 0.5 * (low + high), 0.53 * float((high - low).max())
    figure, axes = panels((6.6, 4.7 if known else 2.6), 1 + known, 3)
    for column, at in zip(axes.T, map(list, VIEWS.values()), strict=True):
        above, names = column[0], ["xyz"[i] for i in at]
        if flange:
            look: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "black", "hatch": "///"}
            side = patches.Rectangle((-_PLATE, -8.0), 2 * _PLATE, 8.0, **look)
            above.add_patch(side if at[1] == 2 else patches.Circle((0.0, 0.0), _PLATE, **look))
        for tip, name in zip(0.9 * _PLATE * np.eye(2), names, strict=True):
            above.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2})
            above.annotate(name, tip, xytext=(3, 3), textcoords="offset points", fontsize=9)
        if body is not None:
            squares, directions = np.linalg.eigh(body[np.ix_(at, at)])
            angle = np.linspace(0.0, 2.0 * np.pi, 91)
            circle = np.sqrt(np.maximum(squares, 0.0))[:, None] * np.vstack([np.cos(angle), np.sin(angle)])
            outline = com[at, None] + directions @ circle
            above.plot(*outline, "--", color="0.35", linewidth=1.2, label="equivalent ellipsoid")
        for axis in column:
            (x, y), ((left, right), (bottom, top)) = com[at], ends[at]
            if known:
                look = {"facecolor": "none", "edgecolor": BLUE, "linewidth": 1.2, "hatch": "xxx"}
                axis.add_patch(patches.Ellipse(ends[at].mean(axis=1), *np.ptp(ends[at], axis=1), **look))
                axis.plot([left, right], [y, y], color=BLUE, linewidth=1.6, label="95 % intervals")
                axis.plot([x, x], [bottom, top], color=BLUE, linewidth=1.6)
            look = {"color": ORANGE, "markeredgecolor": "black", "markersize": 5}
            axis.plot(x, y, "o", label="centre of mass", **look)
            axis.set_aspect("equal", adjustable="box" if axis is above else "datalim")
            axis.set(xlabel=f"{names[0]} [mm]", ylabel=f"{names[1]} [mm]")
            axis.tick_params(labelsize=8)
            axis.locator_params(nbins=5)
            axis.margins(0.12)
        above.set(**{f"{way}lim": (middle[i] - half, middle[i] + half) for way, i in zip("xy", at, strict=True)})
    legend(figure, [axes[0, 0]])
    where = ", ".join(f"{axis} {x:.1f} mm" for axis, x in zip("xyz", com, strict=True))
    return [Drawing("flange", caption, figure, f"{caption} Centre of mass at {where}.")]


def methods_section(result: PayloadResult) -> Section:
    """Every method's payload, with constraints and without, whether it can exist, and where sigma comes from."""
    possible, best = result.possible, result.best
    # Value, 95 % interval and larger sigma of the parameters in _UNITS, nan where there is none, N x 4, by method.
    alone, within = dict[int, Array](), dict[int, Array]()
    for estimate in result.estimates:
        parts = [np.column_stack([estimate.ten, numbers(estimate.interval95, 2), estimate.larger_sigma])]
        for name, shape in (("com", (3,)), ("inertia_com", (3, 3)), ("principal_moments", (3,))):
            ends = array(getattr(estimate, f"{name}_interval95", None), *shape, 2)
            of = (getattr(estimate, f"{name}{kind}", None) for kind in ("", "_sigma", "_sigma_robust"))
            value, sigma, robust = (array(each, *shape)[..., None] for each in of)
            row = np.concatenate([value, ends, np.fmax(sigma, robust)], axis=-1)
            parts.append(row[ENTRIES] if name == "inertia_com" else row)
        (within if isinstance(estimate, PossibleEstimate) else alone)[estimate.method] = np.concatenate(parts)
    chosen = best.method if best is not None else None

    def draw() -> list[Block]:
        scale, places = np.array([[1.0], [1e3], [1e3], [1e3]]), _FREE + np.arange(len(within))
        filled, opened = ({k: scale * rows[k][9:13, :3] for k in within} for rows in (within, alone))
        figure, axes = panels((9.0, 0.42 * len(within) + 1.35), 1, 4, sharey=True)
        titles = ("mass [kg]", *(f"centre of mass {axis} [mm]" for axis in "xyz"))
        for k, (axis, title) in enumerate(zip(axes[0], titles, strict=True)):
            agreed = filled[chosen][k] if chosen else [np.nan] * 3
            interval_rows(
                axis, [f"method {k}" for k in within], np.array([of[k] for of in filled.values()]), agreed
            )
            look: dict[str, Any] = {"color": "black", "fillstyle": "none", "markersize": 5, "linestyle": "none"}
            free = [of[k, 0] for of in opened.values()]
            axis.plot(free, places, "D", label="least squares alone", **look)
            axis.set_title(title, fontsize=10)
            axis.locator_params(axis="x", nbins=4)
        axes[0, 0].plot([], [], "o-", color=BLUE, label="with constraints, 95 %")
        legend(figure, [axes[0, 0]])
        caption = (
            "Filled: payload that can exist, with its 95 % interval. Open: least squares alone, which may be a "
            "body that cannot exist. The dashed line and the band are the recommended payload (method "
            f"{result.method})."
        )
        masses = ", ".join(f"method {each.method} {each.ten[9]:.4g} kg" for each in possible)
        return [Drawing("methods", caption, figure, f"{caption} Masses: {masses}.")]

    # One row a number: value and 95 % interval, other methods, least squares with the larger sigma.
    shown = (within[chosen] if chosen else alone[result.best_free.method])[:, :3].copy()
    if best is None:  # intervals of what was determined
        shown[:, 1:] = np.nan
        shown[9:13, 1:] = np.vstack([result.mass.interval95, result.com.interval95])
    values, intervals = zip(*starmap(with_interval, shown.tolist()), strict=True)
    columns: dict[str, Sequence[str]] = {"": [*_UNITS], "unit": [*_UNITS.values()]}
    columns |= {f"method {result.method}": values, "95 % interval": intervals}
    digits = list(map(interval_digits, shown[:, 2] - shown[:, 1]))
    for method, rows in within.items():
        if method != chosen:
            columns[f"method {method}"] = list(map(rounded, rows[:, 0].tolist(), digits))
    for method, rows in alone.items():
        cells = [with_sigma(x, sigma) if np.isfinite(x) else "-" for x, _, _, sigma in rows.tolist()]
        columns[f"method {method} free"] = cells
    if result.gain_sigma:
        by_gains = numbers((best or result.best_free).sigma_with_gains)
        cells = [f"{x:.2g}" if np.isfinite(x) else "" for x in by_gains]
        columns["sigma with gains"] = [*cells, *[""] * (len(_UNITS) - len(cells))]
    if result.visibility:
        columns["by these joints"] = [result.visibility.parameters.get(name, "") for name in _UNITS]
    text = (
        "XY is the entry of the inertia matrix, minus the integral of x y dm. On the same trajectories methods "
        "3 and 4 use the same equations, so their agreement confirms nothing. Methods 1 and 2 use the robot's "
        "identified parameters."
    )
    table = list(zip(*columns.values(), strict=True))
    blocks: list[Block] = [
        Notes([f"Method {number}, {METHOD_NAMES[number]}: {_METHODS[number]}." for number in sorted(alone)]),
        *([OnPage(draw)] if possible else []),
        Table(f"Every parameter in {result.frame}", list(columns), table, ends=("M", "com z", "YZ at com")),
        Text(text),
    ]
    if best is not None:
        table, free = [], {own.method: own for own in result.free}
        for each in possible:
            own = free[each.method]
            cells = [f"{array(of.min_pseudo_inertia_eigenvalue):.2g}" for of in (own, each)]
            cells += [f"{array(each.chi2_rise):.3g}", f"{array(each.p_value):.2g}"]
            exists, hold = own.physically_consistent, "contradict the data" if each.conflict else "hold"
            table.append((f"method {each.method}", "yes" if exists else "no", *cells, hold))
        headings = ("", "free exists", "eigenvalue free", "constrained", "chi2 rise", "p", "constraints")
        text = (
            "A body can exist if the 4 x 4 pseudo-inertia has no negative eigenvalue; positive moments alone are "
            "not enough. A small p says that the data contradict the constraints."
        )
        constraints = f"Constraints: {'; '.join(best.constraints or ())}."
        blocks += [Table("Physical consistency", headings, table), Notes([text, constraints])]
    blocks.append(Notes([*method_notes(result)]))
    return Section("methods", "Every parameter, and the methods side by side", blocks)


def method_notes(result: PayloadResult) -> Iterator[str]:
    """Say where intervals and sigma come from, what constraints cost and which methods contradict them."""
    best, robust, against = result.best, result.best_free.robust, dict[str, dict[int, float]]()
    if best is not None:
        source = (
            "from the formula (17)-(19) for white torque noise; on real robots they are too short by a factor of "
            "about 1.5 to 4"
        )
        if robust and robust.blocks is not None:
            by = f": {robust.warning}" if robust.by_memory else f", by the jackknife ({robust.blocks} blocks)"
            source = f"over all bodies that satisfy the constraints{by}"
        contradicted = np.isnan(numbers(best.interval95, 2)).any()
        none = "No intervals, because the constraints contradict the data."
        yield none if contradicted else f"95 % intervals {source}."
        price = "No constraint is active: the free estimate is already physical."
        if best.active:
            held = "; ".join(str(active.constraint) for active in best.active)
            rise, p_value = array(best.chi2_rise), array(best.p_value)
            price = f"Active constraints: {held}; chi2 rises by {rise:.3g} (p {p_value:.2g})."
        yield price
        for estimate in result.possible:
            for active in estimate.active or ():
                if (p := float(array(active.p_value))) < CONFLICT:
                    against.setdefault(str(active.constraint), {})[estimate.method] = p
    for text, methods in against.items():  # p values by method of each constraint that is contradicted
        yield f"Contradicted by method {', '.join(map(str, methods))}: {text} (p {max(methods.values()):.1g})."
    # Then where the standard deviations of the free estimates come from.
    robusts = [(e, e.robust) for e in result.free if e.robust and e.robust.blocks is not None]
    if robusts:
        first, other, source = robusts[0][1], "that from the errors' autocorrelation", "autocorrelation"
        if not first.by_memory:
            length, other = array(first.block_length), "the block jackknife's standard deviation"
            parts = f"blocks of {length:.2g} s or more" if length else "poses"
            source = f"jackknife over {first.blocks} {parts}"
        yield f"± the larger of the formula's (17)-(19) and {other}."
        measured = [e for e, _ in robusts if not e.from_scale]
        ratios = [f"method {e.method} {numbers(e.sigma_robust)[-1] / numbers(e.sigma)[-1]:.2f}" for e in measured]
        if ratios:
            yield f"Mass, sigma_robust/sigma ({source} to formula): {', '.join(ratios)}."
    else:
        yield "± one standard deviation by (17)-(19), for white torque noise and an exact torque scale."
    yield from sorted({str(own.warning) for _, own in robusts if own.warning})
    missing = {e.method: e.robust.unavailable for e in result.free if e.robust and e.robust.unavailable}
    for why in dict.fromkeys(missing.values()):
        alone = ", ".join(str(method) for method, text in missing.items() if text == why)
        yield f"± of method {alone} by the formula alone: {why}"
    yield from (f"Method {method} left out: {why}" for method, why in (result.left_out or {}).items())


def data_notes(result: PayloadResult) -> Iterator[str]:
    """Equations, condition numbers, residuals, friction and the alignment of recordings."""
    data, residual = result.data, result.relative_residual
    if not data:
        return
    if data.condition_number is not None:
        moving = f"Joints {', '.join(map(str, result.joints))} move" if result.joints else "Without payload"
        yield f"{moving}: {evidence.conditioning(data.equations, data.base_parameters, data)}"
    if result.joints:
        unexplained = array(residual.relative_per_joint, 0) if residual else np.zeros(0)
        joints = " ".join(rounded(100.0 * ratio, 1) for ratio in unexplained.tolist())
        own = 100.0 * array(residual.relative if residual else None)
        yield f"Unexplained: {joints} % of each joint's torque, {own:.1f} % of the payload's torque."
        friction = "Friction is that of the stored robot."
        if data.friction == "may differ":
            friction = (
                "Friction may differ from the stored robot's (--friction-change), and the robot from its stored "
                "parameters within their covariance; the intervals allow for both."
            )
        elif data.friction == "free":
            offsets = "so are the constant torques."
            if (constant := result.constant_torques) and constant.joints:
                sigmas = ", ".join(f"{constant.sigma[j - 1]:.2g}" for j in constant.joints)
                offsets = (
                    f"the constant torques of joint {', '.join(map(str, constant.joints))} may change by {sigmas} "
                    f"N·m or N (1 sigma, {100 * OFFSET_SHARE:.1f} % of Coulomb friction); the intervals allow for "
                    "it."
                )
            friction = f"Coulomb friction is estimated anew in each recording; {offsets}"
        yield friction
        if waves := dict.fromkeys((wave.joint, round(wave.waves)) for wave in result.ripple or ()):
            counts = ", ".join(f"joint {joint} {count}" for joint, count in waves)
            recordings = max(1, len(result.repeats.sources if result.repeats else ()), len(data.lags_s))
            by_noise = 1.0 - (1.0 - RIPPLE_CHANCE) ** (len(result.joints or ()) * recordings)
            yield (
                f"Ripple that comes with the payload, in waves per turn (or per 2 pi m): {counts}. It may be "
                f"chance: noise alone shows such a wave in {100 * RIPPLE_CHANCE:.0f} % of joints and recordings, "
                f"here in at least one with a probability of {100 * by_noise:.0f} %. It is estimated too, which "
                "widens the intervals."
            )
        sums = result.visibility.combinations if result.visibility else ()
        yield from (f"Only this sum is visible: {names}." for names in sums)
    elif residual and residual.relative is not None:
        yield f"Relative residual of the robot's model: {evidence.residual_text(residual)}"
    if residual and residual.validation:
        yield f"On the validation recording: {evidence.residual_text(residual.validation)}"
    if data.friction == "may differ" and not result.joints:
        yield (
            "In methods 3 and 4, and in method 1 with a stored robot, friction under load may differ from that "
            "without (--friction-change); the intervals allow for it."
        )
    if data.lags_s:
        ends = dict.fromkeys(f"{round(lag, 4) + 0.0:.4f}" for lag in (min(data.lags_s), max(data.lags_s)))
        pairs = f"{len(data.lags_s)} pair{'s' * (len(data.lags_s) > 1)}"
        largest, rms = (1e3 * array(x) for x in (data.max_position_mismatch_rad, data.rms_position_mismatch_rad))
        apart = f"positions then differ by at most {largest:.2f} mrad (rms {rms:.3f})."
        yield f"{pairs} aligned by {' to '.join(ends)} s; {apart}"
