"""A weighing: what it rests on, line by line, and its report."""

import numpy as np

from ....common.arrays import Array
from ....estimation import PAYLOAD, PayloadAnswer, PayloadProblem
from ....estimation.diagnosis.finding import Finding
from ....estimation.diagnosis.joints import worst_joint
from ....estimation.payload.constant_torques import OFFSET_SHARE
from ....estimation.payload.ripple import RIPPLE_CHANCE
from ....estimation.payload.short_motion import ShortMotion
from ....model import INERTIAL
from ...export.controllers.load import is_flange
from ...numbers import or_dash
from ...results import StoredPayload
from ..blocks import Block, Column, Notes, Page, Pair, Section, Table, Text, columns
from ..figures.by_joints import joints_figure
from ..figures.flange import flange_figure
from ..figures.repeats import repeats_figure
from ..provenance import Provenance
from .controller import controller_blocks
from .data import report_page
from .gain_errors import gain_error_notes
from .joints import joints_section
from .quantities import quantities_table
from .recommended import UNITS
from .verdict import reason_blocks, verdict_banner

_QUANTITIES = ("mass", "centre of mass", "inertia")


def repeat_notes(answer: PayloadAnswer) -> list[str]:
    """Spread and drift of several recordings."""
    repeats = answer.repeats
    if repeats is None:
        return []
    _, masses, sigmas = repeats.seen
    each = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in zip(masses, sigmas, strict=True))
    lines = [f"{len(repeats.masses)} recordings, each alone [kg]: {each}; spread {repeats.spread:.2g} kg."]
    if repeats.drift is not None:
        step, sigma = repeats.drift
        trend = "a drift" if repeats.drifts else "no clear drift"
        lines.append(f"From one to the next {step:+.2g} ± {sigma:.2g} kg: {trend}.")
    if repeats.excess > 1.0:
        lines.append(
            f"They scatter {repeats.excess:.2g} times as much as each says: all intervals are widened by that."
        )
    return lines


def parameters_table(answer: PayloadAnswer) -> Table:
    """The ten with standard deviations, as far as these joints show them."""
    solved, shown = answer.free, answer.short.visibility.parameters
    robust = solved.estimate.sigma_robust
    rows = []
    for k, kind in enumerate(INERTIAL):
        numbers = [np.nan] * 4
        if k in solved.places:
            place = solved.places.index(k)
            numbers = [solved.estimate.values[place], solved.estimate.sigma[place]]
            numbers += [robust[place] if robust is not None else np.nan, answer.model.sigma[place]]
        rows.append((kind, UNITS[kind], *(or_dash(x, ".4g") for x in (*numbers, answer.ten[k])), shown[kind]))
    numeric = ("free", "sigma", "robust", "with gains", "told")
    headings = (*columns(("", "unit"), numeric), Column("by these joints"))
    return Table("Parameters about the frame's origin", headings, rows)


def detail_notes(answer: PayloadAnswer) -> list[str]:
    """Condition numbers, residuals, chi-squared: the second page."""
    problem, short, solved = answer.problem, answer.short, answer.free
    raw, scaled = problem.loaded.select(PAYLOAD).condition_numbers()
    shares = solved.unexplained(short.torque_rms)
    joints = " ".join("-" if not np.isfinite(x) else f"{100 * x:.1f}" for x in shares)
    robust = solved.estimate.robust
    lines = [
        f"Joints {', '.join(map(str, short.joints))} move; {problem.loaded.equations} equations, condition "
        f"number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled.",
        f"Not explained: {joints} % of the joints' torque, {100 * solved.estimate.fit.relative:.1f} % of the "
        "payload's own.",
    ]
    lines.append(_friction_note(problem, short))
    if robust is not None:
        if not robust.by_memory:
            lines.append(f"Standard deviations by {robust.blocks} blocks of {robust.block_length:.2g} s or more.")
        lines += [robust.warning] * bool(robust.warning)
    else:
        lines.append(f"Standard deviations by the formula alone: {solved.without_robust}")
    lines += _ripple_notes(short)
    for sums in short.visibility.combinations:
        lines.append(f"Visible only as a sum: {sums}.")
    if answer.possible is not None:
        result = answer.possible.result
        lines.append(
            f"Nearest payload that can exist: chi2 rises by {result.chi2_rise:.3g} (p {result.p_value:.2g})."
        )
    for pair in problem.pairs:
        lines.append(
            f"Aligned by {pair.lag:.4f} s; positions then differ by at most {1e3 * pair.max_mismatch:.2f} mrad."
        )
    return lines


def _friction_note(problem: PayloadProblem, short: ShortMotion) -> str:
    if problem.known is None:
        return f"Coulomb friction is free in each recording; {_offsets_note(short)}"
    if not short.held.held:
        return "Friction is the robot's own."
    return (
        "Friction may differ from the robot's own (--friction-change), and the robot from what was identified "
        "within its covariance; the intervals allow for it."
    )


def _offsets_note(short: ShortMotion) -> str:
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


def moment(answer: PayloadAnswer, k: int) -> tuple[float, tuple[float, float]]:
    """Inertia about axis ``k`` at the centre of mass [kg m^2], with its 95 % interval; nan where there is none."""
    values, intervals = _inertia(answer)
    low, high = intervals[k, k]
    return float(values[k, k]), (float(low), float(high))


def _inertia(answer: PayloadAnswer) -> tuple[Array, Array]:
    """Inertia at the centre of mass [kg m^2], 3 x 3, with 95 % intervals, 3 x 3 x 2; nan where there is none."""
    nothing = np.full((3, 3, 2), np.nan)
    if answer.stand_in is not None:
        return answer.stand_in.inertia(answer.mass), nothing
    if answer.possible is None:
        return nothing[..., 0], nothing
    return answer.possible.body.inertia_com, answer.possible.intervals.inertia_com


def scale_note(answer: PayloadAnswer) -> str:
    """Agreement with the scale."""
    if answer.free.from_scale and answer.scale is not None:
        return (
            f"Mass: the scale's {answer.scale.mass:g} ± {answer.scale.sigma:g} kg; the torques of these joints do "
            "not contain it."
        )
    weighing = answer.weighing
    if weighing is None:
        return "Not weighed: --mass KG+-KG compares with a scale, and sharpens the centre of mass."
    agree = "which contradict each other" if weighing.conflict else "in agreement"
    return (
        f"Scale {weighing.mass:g} ± {weighing.sigma:.2g} kg, torques {weighing.identified:.4g} ± "
        f"{weighing.identified_sigma:.2g} kg: {abs(weighing.z):.1f} sigma apart, {agree}."
    )


def agreement_notes(answer: PayloadAnswer) -> list[str]:
    """What other ways to weigh it say."""
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


def assumed_notes(answer: PayloadAnswer) -> list[str]:
    """What inertia is assumed."""
    if answer.stand_in is None:
        return []
    return [f"Inertia ASSUMED, not measured: {answer.stand_in.description}."]


def weigh_page(answer: PayloadAnswer, document: StoredPayload, provenance: Provenance) -> Page:
    """First screen for the one who types the number in, the rest for the one who asks why."""
    robot, joints = answer.problem.robot, answer.short.joints
    title = robot.title or robot.name
    moved = f"joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
    drawn = joints_figure(answer.by_joints, answer.mass, answer.mass_interval)
    controller = controller_blocks(document, "this report", title)
    lead: list[Block] = [
        verdict_banner(answer.verdict),
        Pair(_quantities(answer), [Text("What to type into the controller", "heading"), *controller]),
        Text("Each joint weighs", "heading"),
        Text(worst_note(worst_joint(answer.by_joints, answer.mass))),
        *([drawn] if drawn else []),
    ]
    details: list[Block] = [parameters_table(answer), Notes(detail_notes(answer))]
    sections = (
        *_repeats(answer),
        *_place(answer),
        joints_section(answer.by_joints),
        Section("details", "Parameters and what they rest on", details),
    )
    subtitle = f"Weighed by a motion of {moved}, {provenance.day}"
    notes = agreement_notes(answer)
    return report_page(f"Payload on the {title}", subtitle, lead, sections, notes, provenance)


def _quantities(answer: PayloadAnswer) -> list[Block]:
    """Value, 95 % interval and use of each quantity; the scale; why."""
    uses: list[str] = [answer.judged[name].use for name in _QUANTITIES]
    if answer.stand_in is not None:
        uses[2] = "ASSUMED, not measured"
    table = quantities_table(
        answer.problem.robot.payload_frame,
        "",
        (answer.mass, answer.mass_interval),
        (answer.com, answer.com_interval),
        _inertia(answer),
        uses,
    )
    lines = [scale_note(answer), *assumed_notes(answer), *repeat_notes(answer)]
    gains = [Text(line, "note") for line in gain_error_notes(answer.problem.robot, answer.gains)]
    return [table, *map(Text, lines), *gains, *reason_blocks(answer.verdict)]


def _repeats(answer: PayloadAnswer) -> tuple[Section, ...]:
    if answer.repeats is None:
        return ()
    drawn = repeats_figure(answer.repeats, answer.mass, answer.mass_interval)
    words = Text("Each recording was weighed alone too: the scatter tells what no single one does.")
    return (Section("repeats", "From recording to recording", [words, *([drawn] if drawn else [])]),)


def _place(answer: PayloadAnswer) -> tuple[Section, ...]:
    best = answer.possible
    if best is None:
        return ()
    drawing = flange_figure(best, answer.judged["inertia"].use == "use", is_flange(best.frame))
    return (Section("place", "Where the centre of mass is", [drawing]),)
