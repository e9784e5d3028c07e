"""The estimates behind a payload: its parameters by every method in one table, and what they rest on."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.fit.settings import METHOD_NAMES
from ....estimation.payload.nuisance import OFFSET_SHARE, RIPPLE_CHANCE
from ....estimation.possible.payload import CONFLICT
from ....estimation.results.payload import (
    FreeEstimate,
    PayloadData,
    PayloadResult,
    PossibleEstimate,
    array,
    bounds,
    numbers,
)
from ....model import INERTIAL
from ...numbers import SIX, interval_digits, rounded, six, with_interval
from ..blocks import Block, Notes, Section, Table, Text, with_sigma
from ..figures.payload import methods_figure
from .evidence import conditioning, residual_text

_UNITS = dict.fromkeys(INERTIAL[:6], "kg m²") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}
_ROWS = (
    *((kind, _UNITS[kind]) for kind in INERTIAL),
    *((f"com {axis}", "m") for axis in "xyz"),
    *((f"{'XYZ'[i]}{'XYZ'[j]} at com", "kg m²") for i, j in SIX),
    *((f"{which} moment", "kg m²") for which in ("smallest", "middle", "largest")),
)
"""The ten parameters, the centre of mass, the inertia and its principal moments there, with units."""
_METHODS = {
    1: "from the loaded torques minus those of the robot identified without payload",
    2: "from the change of the robot's base parameters",
    3: "from the difference of the torques on the same trajectory",
    4: "robot and payload together, from all recordings",
}


def methods_section(result: PayloadResult) -> Section:
    """Every method's payload, with constraints and without, whether it can exist, and where sigma comes from."""
    free = {estimate.method: estimate for estimate in result.free}
    blocks: list[Block] = [
        Notes([f"Method {number}, {METHOD_NAMES[number]}: {_METHODS[number]}." for number in sorted(free)]),
        *([methods_figure(result)] if result.possible else []),
        parameters_table(result),
        Text(
            "XY is the entry of the inertia matrix, minus the integral of x y dm. On the same trajectories methods "
            "3 and 4 use the same equations, so their agreement confirms nothing. Methods 1 and 2 use the robot's "
            "identified parameters."
        ),
    ]
    if result.best is not None:
        rows = []
        for each in result.possible:
            own = free[each.method]
            numbers_of = [f"{array(of.min_pseudo_inertia_eigenvalue):.2g}" for of in (own, each)]
            numbers_of += [f"{array(each.chi2_rise):.3g}", f"{array(each.p_value):.2g}"]
            exists, hold = own.physically_consistent, "contradict the data" if each.conflict else "hold"
            rows.append((f"method {each.method}", "yes" if exists else "no", *numbers_of, hold))
        headings = ("", "free exists", "eigenvalue free", "constrained", "chi2 rise", "p", "constraints")
        text = (
            "A body can exist if the 4 x 4 pseudo-inertia has no negative eigenvalue; positive moments alone are "
            "not enough. A small p says that the data contradict the constraints."
        )
        constraints = f"Constraints: {'; '.join(present(result.best.constraints) or ())}."
        blocks += [Table("Physical consistency", headings, rows), Notes([text, constraints])]
    blocks.append(Notes(method_notes(result)))
    return Section("methods", "Every parameter, and the methods side by side", blocks)


def parameters_table(result: PayloadResult) -> Table:
    """One row a number: value and 95 % interval, what the other methods say, and least squares alone.

    Free estimates stand with the larger of the formula's and the robust standard deviation. More columns hold the
    standard deviations with errors of the drive gains, where they are allowed for, and what a short motion shows.
    """
    best = result.best or result.best_free
    ends = np.full((len(_ROWS), 2), np.nan)
    ends[9:13] = np.vstack([result.mass.interval95, result.com.interval95])
    if isinstance(best, PossibleEstimate):
        ends[:13] = np.vstack([bounds(best.interval95), array(best.com_interval95, 3, 2)])
        ends[13:19] = [array(best.inertia_com_interval95, 3, 3, 2)[pair] for pair in SIX]
        ends[19:] = array(best.principal_moments_interval95, 3, 2)
    names, units = zip(*_ROWS, strict=True)
    values = zip(_values(best).tolist(), ends.tolist(), strict=True)
    shown = [with_interval(x, *end) for x, end in values]
    columns: dict[str, Sequence[str]] = {"": names, "unit": units}
    columns[f"method {result.method}"], columns["95 % interval"] = zip(*shown, strict=True)
    digits = [interval_digits(high - low) for low, high in ends]
    for each in result.possible:
        if each is not result.best:
            pairs = zip(_values(each).tolist(), digits, strict=True)
            columns[f"method {each.method}"] = [rounded(x, most) for x, most in pairs]
    for own in result.free:
        coms = np.fmax(array(own.com_sigma, 3), array(own.com_sigma_robust, 3))
        inertias = np.fmax(array(own.inertia_com_sigma, 3, 3), array(own.inertia_com_sigma_robust, 3, 3))
        sigma = np.concatenate([own.larger_sigma, coms, six(inertias), np.full(3, np.nan)])
        with_sigmas = zip(_values(own).tolist(), sigma.tolist(), strict=True)
        columns[f"method {own.method} free"] = [with_sigma(x, s) if np.isfinite(x) else "-" for x, s in with_sigmas]
    if result.gain_sigma:
        by_gains = [f"{x:.2g}" if np.isfinite(x) else "" for x in numbers(best.sigma_with_gains)]
        columns["sigma with gains"] = [*by_gains, *[""] * (len(_ROWS) - len(by_gains))]
    if (visibility := present(result.visibility)) is not None:
        columns["by these joints"] = [visibility.parameters.get(name, "") for name in names]
    rows = list(zip(*columns.values(), strict=True))
    return Table(f"Every parameter in {result.frame}", list(columns), rows, ("M", "com z", "YZ at com"))


def _values(estimate: FreeEstimate | PossibleEstimate) -> Array:
    """Numbers of the table's rows, nan where not determined."""
    moments = estimate.principal_moments if isinstance(estimate, PossibleEstimate) else None
    inertia = six(array(estimate.inertia_com, 3, 3))
    return np.concatenate([estimate.ten, array(estimate.com, 3), inertia, array(moments, 3)])


def method_notes(result: PayloadResult) -> list[str]:
    """Say where intervals and sigma come from, what constraints cost and which methods contradict them."""
    best, robust, lines = result.best, present(result.best_free.robust), list[str]()
    if best is not None:
        source = (
            "from the formula (17)-(19) for white torque noise; on real robots they are too short by a factor of "
            "about 1.5 to 4"
        )
        if robust is not None and robust.blocks is not None:
            by = f": {robust.warning}" if robust.by_memory else f", by the jackknife ({robust.blocks} blocks)"
            source = f"over all bodies that satisfy the constraints{by}"
        if np.isnan(bounds(best.interval95)).any():
            lines.append("No intervals, because the constraints contradict the data.")
        else:
            lines.append(f"95 % intervals {source}.")
        price = "No constraint is active: the free estimate is already physical."
        if best.active:
            held = "; ".join(str(active.constraint) for active in best.active)
            rise, p_value = array(best.chi2_rise), array(best.p_value)
            price = f"Active constraints: {held}; chi2 rises by {rise:.3g} (p {p_value:.2g})."
        lines.append(price)
    against: dict[str, dict[int, float]] = {}  # p values by method of each constraint that is contradicted
    for estimate in result.possible if best is not None else ():
        for active in estimate.active or ():
            if (p := float(array(active.p_value))) < CONFLICT:
                against.setdefault(str(active.constraint), {})[estimate.method] = p
    for text, methods in against.items():
        numbers_of = ", ".join(map(str, methods))
        lines.append(f"Contradicted by method {numbers_of}: {text} (p {max(methods.values()):.1g}).")
    left_out = (present(result.left_out) or {}).items()
    return [*lines, *sigma_notes(result.free), *(f"Method {method} left out: {why}" for method, why in left_out)]


def sigma_notes(estimates: Sequence[FreeEstimate]) -> list[str]:
    """Say where the standard deviations of free estimates come from, and what speaks against them."""
    robust = [(e, e.robust) for e in estimates if e.robust and e.robust.blocks is not None]
    lines = ["± one standard deviation by (17)-(19), for white torque noise and an exact torque scale."]
    if robust:
        first = robust[0][1]
        other, source = "that from the errors' autocorrelation", "autocorrelation"
        if not first.by_memory:
            length = array(present(first.block_length))
            other = "the block jackknife's standard deviation"
            blocks = f"blocks of {length:.2g} s or more" if length else "poses"
            source = f"jackknife over {first.blocks} {blocks}"
        lines = [f"± the larger of the formula's (17)-(19) and {other}."]
        ratios = [
            f"method {e.method} {numbers(e.sigma_robust)[-1] / numbers(e.sigma)[-1]:.2f}"
            for e, _ in robust
            if not e.from_scale
        ]
        if ratios:
            lines.append(f"Mass, sigma_robust/sigma ({source} to formula): {', '.join(ratios)}.")
    by_formula: dict[str, list[str]] = {}
    for e in estimates:
        if e.unavailable:
            by_formula.setdefault(e.unavailable, []).append(str(e.method))
    formula = [f"± of method {', '.join(each)} by the formula alone: {why}" for why, each in by_formula.items()]
    return [*lines, *sorted({str(r.warning) for _, r in robust if r.warning}), *formula]


def data_notes(result: PayloadResult) -> list[str]:
    """Equations, condition numbers, residuals, friction and the alignment of recordings."""
    data, residual = present(result.data), present(result.relative_residual)
    if data is None:
        return []
    lines = list[str]()
    if data.condition_number is not None:
        moving = f"Joints {', '.join(map(str, result.joints))} move" if result.joints else "Without payload"
        lines.append(f"{moving}: {conditioning(data.equations, data.base_parameters, data)}")
    if result.short:
        lines += _short_notes(result, data)
    elif residual is not None and residual.relative is not None:
        lines.append(f"Relative residual of the robot's model: {residual_text(residual)}")
    if residual is not None and residual.validation:
        lines.append(f"On the validation recording: {residual_text(residual.validation)}")
    if data.friction == "may differ" and not result.short:
        lines.append(
            "In methods 3 and 4, and in method 1 with a stored robot, friction under load may differ from that "
            "without (--friction-change); the intervals allow for it."
        )
    if data.lags_s:
        ends = dict.fromkeys(f"{round(lag, 4) + 0.0:.4f}" for lag in (min(data.lags_s), max(data.lags_s)))
        pairs = f"{len(data.lags_s)} pair{'s' * (len(data.lags_s) > 1)}"
        largest, rms = (1e3 * array(x) for x in (data.max_position_mismatch_rad, data.rms_position_mismatch_rad))
        lines.append(
            f"{pairs} aligned by {' to '.join(ends)} s; positions then differ by at most {largest:.2f} mrad (rms "
            f"{rms:.3f})."
        )
    return lines


def _short_notes(result: PayloadResult, data: PayloadData) -> list[str]:
    residual, visibility = present(result.relative_residual), present(result.visibility)
    unexplained = array(residual.relative_per_joint, 0) if residual else np.zeros(0)
    own = array(residual.relative if residual else None)
    joints = " ".join(rounded(100.0 * ratio, 1) for ratio in unexplained.tolist())
    friction, constant = "Friction is that of the stored robot.", present(result.constant_torques)
    if data.friction == "free":
        offsets = "so are the constant torques."
        if constant is not None and constant.joints:
            sigmas = ", ".join(f"{constant.sigma[j - 1]:.2g}" for j in constant.joints)
            offsets = (
                f"the constant torques of joint {', '.join(map(str, constant.joints))} may change by {sigmas} N·m "
                f"or N (1 sigma, {100 * OFFSET_SHARE:.1f} % of Coulomb friction); the intervals allow for it."
            )
        friction = f"Coulomb friction is estimated anew in each recording; {offsets}"
    elif data.friction == "may differ":
        friction = (
            "Friction may differ from the stored robot's (--friction-change), and the robot from its stored "
            "parameters within their covariance; the intervals allow for both."
        )
    lines = [
        f"Unexplained: {joints} % of each joint's torque, {100 * own:.1f} % of the payload's torque.",
        friction,
    ]
    if waves := dict.fromkeys((wave.joint, round(wave.waves)) for wave in result.ripple or ()):
        counts = ", ".join(f"joint {joint} {count}" for joint, count in waves)
        recordings = max(1, len(result.repeats.sources if result.repeats else ()), len(data.lags_s))
        by_noise = 1.0 - (1.0 - RIPPLE_CHANCE) ** (len(result.joints or ()) * recordings)
        lines.append(
            f"Ripple that comes with the payload, in waves per turn (or per 2 pi m): {counts}. It may be chance: "
            f"noise alone shows such a wave in {100 * RIPPLE_CHANCE:.0f} % of joints and recordings, here in at "
            f"least one with a probability of {100 * by_noise:.0f} %. It is estimated too, which widens the "
            "intervals."
        )
    sums = visibility.combinations if visibility else ()
    return [*lines, *(f"Only this sum is visible: {names}." for names in sums)]
