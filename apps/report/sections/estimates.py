"""The estimates behind a payload: its parameters by every method in one table, and what they rest on."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....estimation import PAYLOAD, PayloadAnswer
from ....estimation.payload.constant_torques import OFFSET_SHARE
from ....estimation.payload.constrained import ConstrainedPayload
from ....estimation.payload.long_motion import LongMotion
from ....estimation.payload.result import PayloadEstimate
from ....estimation.payload.ripple import RIPPLE_CHANCE
from ....estimation.payload.short_motion import ShortMotion
from ....model import INERTIAL, InertialParameters
from ...numbers import interval_digits, or_dash
from ..blocks import Block, Cell, Column, Notes, Section, Table, Text, columns, with_sigma
from ..figures.payload import methods_figure
from .evidence import residual_text

_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Places of the inertia matrix's six entries."""
_UNITS = dict.fromkeys(INERTIAL[:6], "kg m²") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}
_ROWS = (
    *((kind, _UNITS[kind]) for kind in INERTIAL),
    *((f"com {axis}", "m") for axis in "xyz"),
    *((f"{'XYZ'[i]}{'XYZ'[j]} at com", "kg m²") for i, j in _PAIRS),
    *((f"{which} moment", "kg m²") for which in ("smallest", "middle", "largest")),
)
"""The ten parameters, the centre of mass, the inertia and its principal moments there, with units."""
_ENDS = ("M", "com z", "ZZ at com")


def methods_section(answer: PayloadAnswer) -> Section:
    """Every method's payload, with constraints and without, whether it can exist, and where sigma comes from."""
    words = (
        "XY is the entry of the inertia matrix: minus the integral of x y dm. Methods 3 and 4 on the same "
        "trajectories use the same equations: that they agree confirms nothing. Methods 1 and 2 go through the "
        "robot's own parameters."
    )
    blocks: list[Block] = [Text(words)]
    if answer.constrained:
        blocks.append(methods_figure(answer))
    blocks += [parameters_table(answer), *consistency_blocks(answer)]
    blocks.append(Notes(method_notes(answer)))
    return Section("methods", "Every parameter, and the methods side by side", blocks)


def parameters_table(answer: PayloadAnswer) -> Table:
    """One row a number: value and 95 % interval, what the other methods say, and least squares alone.

    Free estimates stand with the larger of the formula's and the robust standard deviation. More columns hold the
    standard deviations with errors of the drive gains, where they are allowed for, and what a short motion shows.
    """
    values, bounds = _reported(answer)
    others = [payload for payload in answer.constrained if payload is not answer.possible]
    numbers = [values, *bounds.T, *(_all_numbers(payload.body) for payload in others)]
    free = [free_cells(estimate) for estimate in answer.estimates]
    with_gains, problem = answer.model.sigma, answer.problem
    rows: list[tuple[Cell, ...]] = []
    for k, (name, unit) in enumerate(_ROWS):
        digits = interval_digits(bounds[k, 1] - bounds[k, 0])
        # Zero has no sign.
        cells = [or_dash(np.round(column[k], digits) + 0.0, f".{digits}f") for column in numbers]
        row: list[Cell] = [name, unit, *cells, *(column[k] for column in free)]
        if answer.gains is not None:
            place = answer.free.places.index(k) if k in answer.free.places else None
            row.append("" if place is None else f"{with_gains[place]:.2g}")
        if isinstance(problem, ShortMotion):
            row.append(problem.visibility.parameters.get(name, ""))
        rows.append(tuple(row))
    methods = [f"method {payload.method}" for payload in others]
    methods += [f"method {estimate.method} free" for estimate in answer.estimates]
    headings = [f"method {answer.free.method}", "95 %", "interval", *methods]
    headings += ["sigma with gains"] if answer.gains is not None else []
    shown = (Column("by these joints"),) if isinstance(problem, ShortMotion) else ()
    title = f"Every parameter in {answer.free.frame}"
    return Table(title, (*columns(("", "unit"), headings), *shown), rows, _ENDS)


def free_cells(estimate: PayloadEstimate) -> list[Cell]:
    """Least squares alone: the ten, the centre of mass and the inertia there, as far as they are determined."""
    sigma = np.full(len(INERTIAL), np.nan)
    sigma[list(estimate.places)] = estimate.larger_sigma
    values = estimate.ten
    if estimate.complete:
        values = _numbers(estimate.body)
        inertia = estimate.larger_sigma_inertia_com
        sigma = np.concatenate([sigma, estimate.larger_sigma_com, [inertia[pair] for pair in _PAIRS]])
    cells = [
        with_sigma(float(value), float(s)) if np.isfinite(value) else "-"
        for value, s in zip(values, sigma, strict=True)
    ]
    return [*cells, *["-"] * (len(_ROWS) - len(cells))]


def _reported(answer: PayloadAnswer) -> tuple[Array, Array]:
    """Values and 95 % intervals of the rows, shapes (22,) and (22, 2); nan where there are none."""
    best, values, bounds = answer.possible, np.full(len(_ROWS), np.nan), np.full((len(_ROWS), 2), np.nan)
    if best is not None:
        inertia = [best.intervals.inertia_com[pair] for pair in _PAIRS]
        intervals = (best.intervals.parameters, best.intervals.com, inertia, best.intervals.principal_moments)
        return _all_numbers(best.body), np.vstack(intervals)
    values[:13] = *answer.ten, *answer.com
    bounds[9:13] = answer.mass_interval, *answer.com_interval
    return values, bounds


def _all_numbers(body: InertialParameters) -> Array:
    return np.append(_numbers(body), np.linalg.eigvalsh(body.inertia_com))


def _numbers(body: InertialParameters) -> Array:
    return np.concatenate([body.vector, body.com, [body.inertia_com[pair] for pair in _PAIRS]])


def consistency_blocks(answer: PayloadAnswer) -> list[Block]:
    """Smallest eigenvalue of the pseudo-inertia by every method, free and constrained, and the price."""
    if answer.possible is None:
        return []
    headings = ("free exists", "eigenvalue free", "constrained", "chi2 rise", "p", "constraints")
    rows = [
        (
            f"method {payload.method}",
            "yes" if payload.free.body.physically_consistent else "no",
            f"{payload.free.body.min_pseudo_inertia_eigenvalue:.2g}",
            f"{payload.result.min_pseudo_inertia_eigenvalue:.2g}",
            f"{payload.result.chi2_rise:.3g}",
            f"{payload.p_value:.2g}",
            "contradict the data" if payload.conflict else "hold",
        )
        for payload in answer.constrained
    ]
    words = (
        "A body can exist if the 4 x 4 pseudo-inertia has no negative eigenvalue; positive moments alone are not "
        "enough. A small p says that the data contradict the constraints."
    )
    constraints = "; ".join(constraint.description for constraint in answer.possible.result.constraints)
    return [
        Table("Physical consistency", columns(("",), headings), rows),
        Text(words),
        Text(f"Constraints: {constraints}."),
    ]


def method_notes(answer: PayloadAnswer) -> list[str]:
    """Say where intervals and sigma come from, what constraints cost and which methods contradict them."""
    best, lines = answer.possible, list[str]()
    if best is not None:
        lines = [_interval_note(best), _cost_note(best), *_conflict_notes(answer.constrained)]
    left_out = [f"Method {method} left out: {reason}" for method, reason in answer.left_out.items()]
    return [*lines, *sigma_notes(answer.estimates), *left_out]


def _interval_note(payload: ConstrainedPayload) -> str:
    robust = payload.free.estimate.robust
    if np.isnan(payload.intervals.parameters).any():
        return "No intervals: constraints contradict the data, so that none would hold."
    if robust is None:
        return (
            "95 % intervals by the formula (17)-(19) alone, for white torque noise: on real robots they are too "
            "short by a factor of about 1.5 to 4."
        )
    if robust.by_memory:
        return f"95 % intervals over bodies that hold all constraints: {robust.warning}."
    return f"95 % intervals by the block jackknife ({robust.blocks} blocks), over bodies that hold all constraints."


def _cost_note(payload: ConstrainedPayload) -> str:
    result = payload.result
    if not result.active:
        return "No constraint is active: the free estimate can exist as it is."
    bounds = "; ".join(active.description for active in result.active)
    return f"Active: {bounds}. Their price: chi2 rises by {result.chi2_rise:.3g} (p {payload.p_value:.2g})."


def _conflict_notes(payloads: Sequence[ConstrainedPayload]) -> list[str]:
    """One line for each constraint that any method contradicts."""
    against: dict[str, dict[int, float]] = {}
    for payload in payloads:
        for conflict in payload.conflicts:
            against.setdefault(conflict.description, {})[payload.method] = conflict.p_value
    return [
        f"Contradicted by method {', '.join(map(str, methods))}: {text} (p {max(methods.values()):.1g})."
        for text, methods in against.items()
    ]


def sigma_notes(estimates: Sequence[PayloadEstimate]) -> list[str]:
    """Say where the standard deviations of free estimates come from, and what speaks against them."""
    both = [(e, e.estimate.robust) for e in estimates]
    robust = [r for _, r in both if r is not None]
    lines = ["± one standard deviation by (17)-(19): for white torque noise, the torques' scale taken as exact."]
    if robust:
        by_blocks, by_memory = "the block jackknife's standard deviation", "that by the memory of the errors"
        blocks = f"{robust[0].blocks} blocks of {robust[0].block_length:.2g} s or more"
        how = "memory" if robust[0].by_memory else f"jackknife over {blocks}"
        ratios = [
            f"method {e.method} {r.sigma[-1] / e.estimate.sigma[-1]:.2f}"
            for e, r in both
            if r is not None and not e.from_scale
        ]
        lines = [f"± the larger of the formula's (17)-(19) and {by_memory if robust[0].by_memory else by_blocks}."]
        if ratios:
            lines.append(f"Mass, sigma_robust/sigma ({how} to formula): {', '.join(ratios)}.")
    by_formula: dict[str, list[str]] = {}
    for e in estimates:
        if e.without_robust:
            by_formula.setdefault(e.without_robust, []).append(str(e.method))
    alone = [f"± of method {', '.join(methods)} by the formula alone: {why}" for why, methods in by_formula.items()]
    return [*lines, *sorted({r.warning for r in robust if r.warning}), *alone]


def data_notes(answer: PayloadAnswer) -> list[str]:
    """Equations, condition numbers, residuals, friction and the alignment of recordings."""
    problem = answer.problem
    lines = _short_notes(answer, problem) if isinstance(problem, ShortMotion) else _long_notes(answer, problem)
    if not problem.pairs:
        return lines
    lags = sorted(round(pair.lag, 4) + 0.0 for pair in problem.pairs)
    shift = f"{lags[0]:.4f}" if lags[0] == lags[-1] else f"{lags[0]:.4f} to {lags[-1]:.4f}"
    worst = max(problem.pairs, key=lambda pair: pair.max_mismatch)
    aligned = (
        f"{len(lags)} pair{'s' * (len(lags) > 1)} aligned by {shift} s; positions then differ by at most "
        f"{1e3 * worst.max_mismatch:.2f} mrad (rms {1e3 * worst.rms_mismatch:.3f})."
    )
    return [*lines, aligned]


def _long_notes(answer: PayloadAnswer, problem: LongMotion) -> list[str]:
    lines = list[str]()
    if problem.unloaded is not None:
        raw, scaled = problem.unloaded.condition_numbers()
        lines.append(
            f"Without payload: {problem.unloaded.equations} equations, {len(problem.base.columns)} parameters; "
            f"condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled."
        )
    if answer.robot_fit is not None:
        lines.append(f"Relative residual of the robot's model: {residual_text(answer.robot_fit)}")
    if answer.validation is not None:
        lines.append(f"The same on the validation recording: {residual_text(answer.validation)}")
    if problem.friction and any(estimate.method in (3, 4) for estimate in answer.estimates):
        lines.append(
            "Methods 3, 4: friction under load may differ from the robot's own (--friction-change), which the "
            "intervals allow for."
        )
    return lines


def _short_notes(answer: PayloadAnswer, short: ShortMotion) -> list[str]:
    solved = answer.free
    raw, scaled = short.loaded.select(PAYLOAD).condition_numbers()
    unexplained = solved.unexplained(short.torque_rms)
    joints = " ".join("-" if not np.isfinite(ratio) else f"{100 * ratio:.1f}" for ratio in unexplained)
    friction = "Friction is the robot's own."
    if short.known is None:
        friction = f"Coulomb friction is free in each recording; {_offsets(short)}"
    elif short.held.held:
        friction = (
            "Friction may differ from the robot's own (--friction-change), and the robot from what was identified "
            "within its covariance; the intervals allow for it."
        )
    return [
        f"Joints {', '.join(map(str, short.joints))} move; {short.loaded.equations} equations, condition "
        f"number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled.",
        f"Not explained: {joints} % of the joints' torque, {100 * solved.estimate.fit.relative:.1f} % of the "
        "payload's own.",
        friction,
        *_ripple_notes(short),
        *(f"Visible only as a sum: {sums}." for sums in short.visibility.combinations),
    ]


def _offsets(short: ShortMotion) -> str:
    constant = short.held
    if not constant.joints:
        return "constant torques are free too."
    joints = ", ".join(str(j + 1) for j in constant.joints)
    sigmas = ", ".join(f"{constant.sigma[j]:.2g}" for j in constant.joints)
    return (
        f"constant torques of joint {joints} may change by {sigmas} N·m or N (1 sigma, {100 * OFFSET_SHARE:.1f} % "
        "of Coulomb friction), which the intervals allow for."
    )


def _ripple_notes(short: ShortMotion) -> list[str]:
    """Waves that came with the payload, or are noise."""
    waves = dict.fromkeys((wave.joint, round(wave.waves)) for run in short.runs for wave in run.ripple)
    if not waves:
        return []
    joints = ", ".join(f"joint {joint} {count}" for joint, count in waves)
    by_noise = 1.0 - (1.0 - RIPPLE_CHANCE) ** (len(short.joints) * len(short.runs))
    return [
        f"Ripple that seems to come with the payload, waves per turn (or per 2 pi m): {joints}. It may be chance: "
        f"noise alone shows a wave in a joint of a recording with a probability of {100 * RIPPLE_CHANCE:.0f} %, "
        f"here in one or more with {100 * by_noise:.0f} %. It is estimated too, which costs accuracy."
    ]
