"""A weighing on the terminal: first what to do next, then, on a second page, what it rests on."""

import numpy as np
from rich.table import Table

from ..estimation import WeighAnswer
from ..estimation.diagnosis import Finding, worst_joint
from ..estimation.weigh import OFFSET_SHARE, RIPPLE_CHANCE, WeighProblem
from ..model import INERTIAL
from .by_joints_table import by_joints_table
from .gains import gain_error_notes
from .tables import UNITS, empty_table

_LEVELS = {
    "use": "use mass, centre of mass and inertia",
    "mass_and_com_only": "use mass and centre of mass",
    "do_not_use": "do not use",
}
_MOMENTS = ("XX", "YY", "ZZ")


def first_screen(answer: WeighAnswer) -> Table:
    """Quantity, value, 95 % interval, and whether to use it."""
    frame = answer.problem.robot.payload_frame
    table = empty_table(f"Payload in {frame}", ("quantity", "unit"), ("value", "95 %", "interval"))
    table.add_column("", no_wrap=True)
    _row(table, "mass", "kg", answer.mass, answer.mass_interval, answer.judged["mass"].use, 4)
    for k, axis in enumerate("xyz"):
        low, high = 1e3 * answer.com_interval[k]
        use = answer.judged["centre of mass"].use if k == 0 or not np.isfinite(answer.com[k]) else ""
        _row(table, f"centre of mass {axis}", "mm", 1e3 * answer.com[k], (low, high), use, 1)
    for k, kind in enumerate(_MOMENTS):
        value, interval = moment(answer, k)
        use = answer.judged["inertia"].use if k == 0 else ""
        if answer.stand_in is not None:
            use = "assumed"
        _row(table, f"inertia {kind} at com", "kg m²", value, interval, use, 4)
    return table


def first_notes(answer: WeighAnswer) -> list[str]:
    """What to do, agreement with the scale and other ways, the worst joint, reasons, the controller's block."""
    lines = [f"Verdict: {_LEVELS[answer.verdict.level]}.", *(f"  - {reason}" for reason in answer.verdict.reasons)]
    lines.append(scale_note(answer))
    if answer.stand_in is not None:
        lines.append(f"Inertia ASSUMED, not measured: {answer.stand_in.description}.")
    lines += agreement_notes(answer)
    lines += repeat_notes(answer)
    lines.append(worst_note(worst_joint(answer.by_joints, answer.mass)))
    lines += gain_error_notes(answer.problem.robot, answer.gains)
    if answer.verdict.level != "do_not_use":
        lines.append(f"For the controller: {controller_line(answer)}")
        lines.append("Its own format: add --json P.json, then 'dynident export P.json --to ur|abb|kuka|..'.")
    return lines


def controller_line(answer: WeighAnswer) -> str:
    """Mass, centre of mass and, where it may be used, inertia in one line."""
    place = ", ".join(f"{1e3 * x:.1f}" for x in answer.com)
    line = f"mass {answer.mass:.3f} kg, centre of mass ({place}) mm"
    if answer.stand_in is not None:
        moments = ", ".join(f"{x:.4f}" for x in np.diag(answer.stand_in.inertia(answer.mass)))
        return f"{line}, inertia there ({moments}) kg m², ASSUMED"
    if answer.judged["inertia"].use == "use" and answer.constrained is not None:
        J = answer.constrained.body.inertia_com
        moments = ", ".join(f"{x:.4f}" for x in [*np.diag(J), J[0, 1], J[0, 2], J[1, 2]])
        return f"{line}, inertia there XX YY ZZ XY XZ YZ ({moments}) kg m²"
    return f"{line}, inertia left at zero"


def repeat_notes(answer: WeighAnswer) -> list[str]:
    """Spread and drift of several recordings."""
    repeats = answer.repeats
    if repeats is None:
        return []
    _, masses, sigmas = repeats.seen
    each = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in zip(masses, sigmas, strict=True))
    lines = [f"{len(repeats.masses)} recordings, each alone [kg]: {each}; spread {repeats.spread:.2g} kg."]
    if repeats.drift is not None:
        step, sigma = repeats.drift
        told = "a drift" if repeats.drifts else "no clear drift"
        lines.append(f"From one to the next {step:+.2g} ± {sigma:.2g} kg: {told}.")
    if repeats.excess > 1.0:
        lines.append(
            f"They scatter {repeats.excess:.2g} times as much as each says: all intervals are widened by that."
        )
    return lines


def detail_tables(answer: WeighAnswer) -> list[Table]:
    """The ten with standard deviations, and the mass by groups of joints."""
    found = answer.found
    title = "Parameters about the frame's origin"
    table = empty_table(title, ("", "unit"), ("free", "sigma", "robust", "with gains", "told"))
    table.add_column("by these joints", no_wrap=True)
    shown = answer.problem.visibility.parameters
    robust = found.estimate.sigma_robust
    for k, kind in enumerate(INERTIAL):
        cells = ["-"] * 4
        if k in found.places:
            place = found.places.index(k)
            numbers = [found.estimate.values[place], found.estimate.sigma[place]]
            numbers += [robust[place] if robust is not None else np.nan, answer.model.sigma[place]]
            cells = [f"{x:.4g}" if np.isfinite(x) else "-" for x in numbers]
        told = answer.ten[k]
        table.add_row(kind, UNITS[kind], *cells, f"{told:.4g}" if np.isfinite(told) else "-", shown[kind])
    return [table, by_joints_table(answer.by_joints)]


def detail_notes(answer: WeighAnswer) -> list[str]:
    """Condition numbers, residuals, chi-squared: the second page."""
    problem, found = answer.problem, answer.found
    raw, scaled = problem.problem.select([f"{kind}_L" for kind in INERTIAL]).condition_numbers()
    shares = found.unexplained(problem.torque_rms)
    joints = " ".join("-" if not np.isfinite(x) else f"{100 * x:.1f}" for x in shares)
    robust = found.estimate.robust
    lines = [
        f"Joints {', '.join(map(str, problem.joints))} move; {problem.problem.equations} equations, condition "
        f"number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled.",
        f"Not explained: {joints} % of the joints' torque, {100 * found.estimate.fit.relative:.1f} % of the "
        "payload's own.",
    ]
    lines.append(f"Coulomb friction is free in each recording; {_offsets_note(problem)}")
    if robust is not None:
        lines.append(f"Standard deviations by {robust.blocks} blocks of {robust.block_length:.2g} s or more.")
        lines += [robust.warning] * bool(robust.warning)
    else:
        lines.append(f"Standard deviations by the formula alone: {found.without_robust}")
    lines += _ripple_notes(problem)
    for sums in problem.visibility.combinations:
        lines.append(f"Visible only as a sum: {sums}.")
    if answer.constrained is not None:
        result = answer.constrained.result
        lines.append(
            f"Nearest payload that can exist: chi2 rises by {result.chi2_rise:.3g} (p {result.p_value:.2g})."
        )
    for pair in problem.pairs:
        lines.append(
            f"Aligned by {pair.lag:.4f} s; positions then differ by at most {1e3 * pair.max_mismatch:.2f} mrad."
        )
    return lines


def _offsets_note(problem: WeighProblem) -> str:
    held = problem.held
    if not held.joints:
        return "constant torques are free too."
    joints = ", ".join(str(j + 1) for j in held.joints)
    sigmas = ", ".join(f"{held.sigma[j]:.2g}" for j in held.joints)
    return (
        f"constant torques of joint {joints} may change by {sigmas} N·m or N (1 sigma, {100 * OFFSET_SHARE:.1f} % "
        "of Coulomb friction), which the intervals allow for."
    )


def _ripple_notes(problem: WeighProblem) -> list[str]:
    """Waves that came with the payload, or are noise."""
    waves = dict.fromkeys((wave.joint, round(wave.waves)) for run in problem.runs for wave in run.ripple)
    if not waves:
        return []
    told = ", ".join(f"joint {joint} {count}" for joint, count in waves)
    by_noise = 1.0 - (1.0 - RIPPLE_CHANCE) ** (len(problem.joints) * len(problem.runs))
    return [
        f"Ripple that seems to come with the payload, waves per turn (or per 2 pi m): {told}. It may be chance: "
        f"noise alone shows a wave in a joint of a recording with a probability of {100 * RIPPLE_CHANCE:.0f} %, "
        f"here in one or more with {100 * by_noise:.0f} %. It is estimated too, which costs accuracy."
    ]


def moment(answer: WeighAnswer, k: int) -> tuple[float, tuple[float, float]]:
    """Inertia about axis ``k`` at the centre of mass [kg m^2], with its 95 % interval; nan where there is none."""
    nothing = (float("nan"), float("nan"))
    if answer.stand_in is not None:
        return float(answer.stand_in.inertia(answer.mass)[k, k]), nothing
    if answer.constrained is None:
        return float("nan"), nothing
    low, high = answer.constrained.intervals.inertia_com[k, k]
    return float(answer.constrained.body.inertia_com[k, k]), (float(low), float(high))


def _row(
    table: Table, name: str, unit: str, value: float, interval: tuple[float, float], use: str, digits: int
) -> None:
    cells = [f"{x:.{digits}f}" if np.isfinite(x) else "-" for x in (value, *interval)]
    table.add_row(name, unit, *cells, use)


def scale_note(answer: WeighAnswer) -> str:
    """Agreement with the scale."""
    if answer.found.from_scale and answer.scale is not None:
        return (
            f"Mass: the scale's {answer.scale.mass:g} ± {answer.scale.sigma:g} kg; the torques of these joints do "
            "not contain it."
        )
    weighing = answer.weighing
    if weighing is None:
        return "Not weighed: --mass and --mass-sigma compare with a scale, and sharpen the centre of mass."
    agree = "which contradict each other" if weighing.conflict else "in agreement"
    return (
        f"Scale {weighing.mass:g} ± {weighing.sigma:.2g} kg, torques {weighing.identified:.4g} ± "
        f"{weighing.identified_sigma:.2g} kg: {abs(weighing.z):.1f} sigma apart, {agree}."
    )


def agreement_notes(answer: WeighAnswer) -> list[str]:
    """The same by other ways."""
    return [
        f"Another way, {way.name}: {way.mass:.4g} kg, centre of mass "
        f"({', '.join('-' if not np.isfinite(x) else f'{1e3 * x:.1f}' for x in way.com)}) mm."
        for way in answer.agreement
    ]


def worst_note(worst: Finding | None) -> str:
    """The joint that agrees least, in words."""
    if worst is None:
        return "No joint can be compared with the others."
    return f"Joint that agrees least: {worst.text}."
