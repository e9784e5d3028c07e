"""A motion that was designed, replayed or asked for near a pose: its limits, and what it will tell."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from .... import __version__
from ....model import INERTIAL, InertialParameters, Motion
from ....model.base import PayloadVisibility
from ....model.drives import parameter_kind
from ....model.friction import LAWS
from ....model.inertia import PayloadSpread, payload_spread
from ....trajectories import DesignProblem, Fourier, Scene, Score, StaticShape
from ....trajectories.design.problem import BALL
from ....trajectories.design.score import holding_torques, load_torques
from ...export.motions import assumed_line, rests_on
from ...numbers import joined
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text
from ..documents import JudgedMotion, NearResult
from ..figures import log_scale, named_panels, signals
from .robot import assumed_notes

_MOST_SHOWN = 12
_FEW_NAMED = 4  # parameters a figure names as the least known
_UNITS = {"position": ("m", "rad"), "speed": ("m/s", "rad/s"), "torque": ("N", "N·m")}
"""Units of sliding and of turning joints."""
_SHOWN = 8  # of more parameters: the least known
_MASS, _ARM, _GYRATION = 3.0, 0.1, 0.055  # kg, m, m: a payload that stands for those to come
_STATIC_MOST = 0.05  # standard deviation over the mass: above it standing still tells too little
_KINDS = ("position", "speed", "acceleration", "torque")
_GROUPS = (
    ("inertia", "kg m²", ("XX", "XY", "XZ", "YY", "YZ", "ZZ")),
    ("first moments", "kg m", ("MX", "MY", "MZ")),
    ("masses", "kg", ("M",)),
    ("rotor inertia", "kg m² or kg", ("IA", "IAM")),
    ("Coulomb friction", "N·m or N", ("FS", "FSM")),
    ("viscous friction", "N·m·s or N·s/m", ("FV", "FVM")),
    *((f"{law.title} friction", law.unit, (kind,)) for kind, law in LAWS.items() if kind not in ("FS", "FV")),
    ("constant torques", "N·m or N", ("OFF",)),
)
"""Kinds of parameters in words, their unit, and the letters they are called by."""


def design_report(judged: JudgedMotion) -> Report:
    """Limits, predicted standard deviations and what to do next; then every parameter and the motion."""
    score, problem, floor, replay = judged.score, judged.score.problem, judged.floor, judged.replay
    kind, title, learnt = problem.criterion.kind, problem.robot.title or problem.robot.name, judged.learnt
    length, writers = problem.goal.data_length, "--samples, --ros2, --urscript or --val3"
    banner, limits, brakes_note, brakes = _limits(judged.title, score)
    rows = list[tuple[str, ...]]()
    replayed = floored = ""
    if replay is not None:
        kept = f"but {'; '.join(replay.violations)}" if replay.violations else "every limit met"
        replayed = (
            f"Replayed by trapezoidal moves, as --val3 commands: {criterion_text(kind, replay.value)} in "
            f"{replay.duration:.4g} s, {kept}. Run 'dynident score' on the controller's log."
        )
    if floor is not None:
        quantity = {"d": "uncertainty", "a": "relative sigma"}.get(kind, "condition number")
        times = np.exp(0.5 * floor.gap if kind == "d" else floor.gap)
        least = "the best value found, which is not a bound"
        if floor.dual is not None:
            least = (
                f"the dual bound {criterion_text(kind, floor.dual)} (no motion can do better, unless some state is "
                "more informative than the best one found by search)"
            )
        floored = (
            f"Best distribution of {floor.states} states within the limits, ignoring continuity: "
            f"{criterion_text(kind, floor.value)}. The motion's {quantity}, for ideal states, is {times:.3g} times "
            f"{least}."
        )
    # What one run would leave unknown: of a payload of the rated mass, or of a robot kind by kind.
    run = f"{length:g} s of data" if length else "one run"
    if learnt.covariance is None:
        taught = Table(f"From {run} not every parameter can be identified", ("",), [])
    elif tuple(problem.names) == tuple(f"{kind}{problem.robot.n}" for kind in INERTIAL):
        mass = problem.robot.rated_payload if np.isfinite(problem.robot.rated_payload) else _MASS
        body = InertialParameters.from_com(mass, [0.0, 0.0, _ARM], _GYRATION**2 * mass * np.eye(3))
        spread = payload_spread(body.vector, learnt.covariance, range(len(INERTIAL)))
        taught = _spread_table(
            f"Predicted from {run} for {mass:g} kg, {1e3 * _ARM:g} mm along the last axis", spread
        )
    else:
        for text, unit, kinds in _GROUPS:
            if found := [x for name, x in learnt.sigma.items() if parameter_kind(name) in kinds]:
                rows.append((text, str(len(found)), f"{np.median(found):.2g}", f"{max(found):.2g}", unit))
        heading = f"Predicted accuracy of the robot's parameters from {run} (1 sigma)"
        taught = Table(heading, ("", "number", "median", "largest", "unit"), rows)
    conditions = {"cond": learnt.condition_number, "cond-scaled": learnt.condition_number_scaled}
    reached = float(np.log(conditions[kind])) if kind in conditions else score.value
    after = [f"Next: add {writers}, run it, then 'dynident check LOG'."] if judged.design is not None else []
    assumed = assumed_notes(problem.robot, *rests_on(problem))
    first: list[Block] = [
        banner,
        limits,
        taught,
        Notes([noise_line(problem), f"Criterion {criterion_text(kind, reached)}.", *after]),
        Notes([replayed, *brakes_note, *assumed, floored], optional=True),
        *([_how_to_run(score.duration, writers, "payload")] if after else []),
    ]
    recorded = f"{length:g} s of data, the motion repeated" if length else "recorded once"
    facts = (learnt.condition_number, learnt.condition_number_scaled, learnt.log_det)
    raw, scaled, log_det = (f"{x:.4g}" if np.isfinite(x) else "rank-deficient" for x in facts)
    together = [
        ("duration", f"{score.duration:.4g}", f"s; {recorded}"),
        ("parameters", str(len(problem.names)), f"criterion {kind}"),
        ("condition number", raw, "of W in SI units, as identify will form it"),
        ("the same, scaled", scaled, "columns scaled to norm 1"),
        ("log det", log_det, "of the information matrix"),
    ]
    sigma, reference, labels = learnt.sigma, judged.reference, judged.labels
    known, relative = bool(np.isfinite(list(sigma.values())).all()), learnt.relative_sigma(reference)
    shown = list(sigma)
    if len(sigma) > _MOST_SHOWN:  # those least known of their values; none where no value is known
        shown = sorted(sigma, key=lambda name: -relative.get(name, 0.0))[: _SHOWN if relative else 0]
    of_value = {name: (f"{reference[name]:.4g}", f"{100.0 * x:.2g}") for name, x in relative.items()}
    rows = [(labels.get(name, name), f"{sigma[name]:.3g}", *of_value.get(name, ("", ""))) for name in shown]
    least = f", the {len(shown)} least known of {len(sigma)}" if len(shown) < len(sigma) else ""

    def draw() -> list[Block]:
        percent = {labels.get(name, name): 100.0 * x for name, x in relative.items()}
        absolute = {labels.get(name, name): x for name, x in sigma.items() if name not in relative}
        parts = [pair for pair in (("relative to its value [%]", percent), ("in SI units", absolute)) if pair[1]]
        figure, axes = named_panels([list(values) for _, values in parts])
        for axis, (unit, values) in zip(axes, parts, strict=True):
            heights = np.array(list(values.values()))
            axis.bar(np.arange(len(heights)), heights, color="0.75", edgecolor="black", linewidth=0.6)
            axis.set_ylim(0.5 * heights.min(), 6.0 * heights.max())
            log_scale(axis)
            for k in np.argsort(-heights, kind="stable")[:_FEW_NAMED].tolist():  # the least known, numbered
                axis.annotate(f"{heights[k]:.2g}", (k, heights[k]), ha="center", va="bottom", size=7, rotation=90)
            axis.set_ylabel(f"predicted sigma\n{unit}", fontsize=9)
        figure.suptitle(f"{title}: predicted standard deviations")
        caption = "Standard deviation that identification would leave to each parameter, predicted."
        return [Drawing("predicted_sigma", caption, figure)]

    blocks: list[Block] = [
        Table("Parameters together", ("", "value", "remark"), together),
        *([Table(f"Predicted sigma{least}", ("", "sigma", "value", "%"), rows)] if known and rows else []),
        *brakes,
        OnPage(partial(motion_figure, problem, judged.motion, f"{title}: motion between its limits")),
        *([OnPage(draw)] if known else []),
    ]
    more = f"condition numbers, all parameters{', torque on the brakes' if brakes else ''}"
    sections = [Section("motion", "Motion and what it would teach", blocks)]
    return Report(f"Motion for the {title}", first, sections, more)


def near_report(result: NearResult, expected: InertialParameters, hints: Sequence[str], motion: Motion) -> Report:
    """Predicted sigma of an expected payload, what to do next, other ``hints``; visibility, poses, motion."""
    problem, score, plan, shape = result.design.problem, result.design.score, result.design.plan, result.shape
    robot, joints, mass = problem.robot, ", ".join(map(str, shape.joints)), expected.mass
    title, writers, command = robot.title or robot.name, "--samples, --ros2 or --urscript", "weigh"
    if isinstance(shape, StaticShape):
        kind, command = f"{shape.count} poses at rest", "weigh --static"
        writers = "--samples, --ros2, --urscript or --val3"
        ratio = result.spread.mass / mass
        advice = f" Above {100 * _STATIC_MOST:g} % a motion is better: omit --static." * (ratio > _STATIC_MOST)
        scatter = joined(problem.noise[np.isfinite(problem.noise)], ".2g")
        noted = [
            f"1 sigma is {100.0 * ratio:.2g} % of the mass.{advice}",
            f"Scatter of the torque at rest from one approach to the next ({problem.goal.noise_source}): {scatter} "
            "N·m or N. Constant torques may change between recordings, those of the arm by 0.66 times that, of the "
            "wrist freely.",
        ]
        course = f"{plan.duration:.0f} s: poses are held {shape.hold:g} s after moves from below and above."
    else:
        assert isinstance(plan, Fourier)
        kind, noted = "Motion", [noise_line(problem)]
        periods = "one period" if plan.repeats == 1 else f"{plan.repeats} periods"
        two = f", at {len(plan.poses)} poses, {plan.transfer:.1f} s apart" * bool(plan.transfer)
        slower = joined((rung.duration for rung in result.ladder if rung.speed < 1.0), ".0f")
        before = f"the slower runs before it take {slower} s" if slower else "the first run may be at full speed"
        if not result.ladder:
            before = f"the rehearsal, one period at a tenth of the speed, takes {plan.slowed(0.1).duration:.0f} s"
        course = f"{plan.duration:.1f} s: {periods} of {plan.period:.2f} s{two}; {before}."
    banner, limits, brakes_note, brakes = _limits(f"{kind} of joints {joints} of {title}", score)
    unchecked = (
        "Torque limits are NOT checked: the description lacks torque limits or parameters (--robot-parameters or "
        "--arm-mass). A slow run does not reveal them either."
    )
    remarks = [f"Duration {course}", "" if problem.torque_limited else unchecked, *brakes_note]
    steps = [(f"{100.0 * rung.speed:.0f}", f"{rung.mass:.2f}", f"{rung.bound:.2f}") for rung in result.ladder]
    rungs = [(f"run {k}", *step) for k, step in enumerate(steps, 1)]
    headings = ("step", "speed %", "safe up to kg", "then known to be below kg")
    ladder = "Ladder: go on only if the last run showed no more than the next one allows"
    payload = f"{mass:g} kg at ({joined(1e3 * expected.com, 'g')}) mm"
    after = f"Next: add {writers}, run the motion without and with the payload, then 'dynident {command}'."
    first: list[Block] = [
        banner,
        _spread_table(f"Predicted accuracy for {payload}", result.spread),
        *([Table(ladder, headings, rungs)] if rungs else []),
        Notes([*noted, after]),
        Notes([*hints, *remarks, *assumed_notes(robot, *rests_on(problem))], optional=True),
        OnPage(lambda: [limits]),
        _how_to_run(plan.duration, writers, command),
    ]
    scale = np.where([joint.revolute for joint in robot.joints], 180.0 / np.pi, 1.0)
    stood = ("pose", *(f"q{j}" for j in range(1, robot.n + 1)))
    poses = [(str(k), *(f"{x:.1f}" for x in scale * pose)) for k, pose in enumerate(result.poses, 1)]
    drawn = OnPage(partial(motion_figure, problem, motion, f"Motion that weighs a payload: {title}"))
    sections = [
        Section("payload", "What it shows of a payload", [visibility_table(result.visibility), *brakes]),
        Section("motion", "The motion between its limits", [Table("Poses, deg or m", stood, poses), drawn]),
    ]
    more = f"poses, which parameters these joints show{', torque on the brakes' if brakes else ''}"
    return Report(f"Motion that weighs a payload: {title}", first, sections, more)


def _limits(title: str, score: Score) -> tuple[Text, Table, list[str], list[Table]]:
    """Say if a motion keeps its limits, how near it comes; name the payloads, and what brakes must hold."""
    problem, payloads, notes, brakes = score.problem, score.problem.payloads, list[str](), list[Table]()
    rows = list[tuple[str, ...]]()
    missed = [limit for limit in score.limits if str(limit) in score.violations]
    for limit in score.limits:
        kept = f"violated by {limit.violation:.4g}" if limit in missed else "met"
        rows.append((limit.name, f"{limit.value:.4g}", f"{limit.limit:.4g}", limit.worst, kept))
    scene = problem.scene or Scene()
    unseen = [kind for kind in _KINDS if not any(row[0].startswith(kind) for row in rows)]
    level, keeps = ("mass_and_com_only", "within all checked limits") if unseen else ("use", "within all limits")
    if not score.feasible:
        named = ", ".join(dict.fromkeys(limit.name for limit in missed))
        level, keeps = "do_not_use", f"NOT within its limits of {named}"
    radii = {body.radius for body in scene.bodies if body.link and body.name != BALL}
    tubes = f" (tubes of {1e3 * max(radii):.0f} mm radius)" if len(radii) == 1 else ""
    looked = [f"the arm itself{tubes}"] * bool(scene.pairs) + [f"the {surface.name}" for surface in scene.surfaces]
    floored = any("floor" in surface.name for surface in scene.surfaces)
    unseen += [*["self-collision"] * (not scene.pairs), *["floor"] * (not floored)]
    unseen += [*["payload"] * (payloads is None), "cables and cell"]
    clear = f" Collisions checked with {' and '.join(looked)}." * bool(looked)
    banner = Text(f"{title}: {keeps}.{clear} NOT checked: {', '.join(unseen)}.", level=level)
    heading = f"Largest values against the limits, SI units, in {score.duration:.4g} s"
    table = Table(heading, ("", "reaches", "limit", "where", "kept"), rows)
    if payloads is not None:
        too_much = any(limit.name.startswith("torque") for limit in missed)
        start, worst = (holding_torques(problem, poses) for poses in (score.samples.q[:1], score.samples.q))
        ratios = worst / problem.bounds.torque
        joint, half = int(np.argmax(ratios)), 1e3 * payloads.half
        centre = joined(1e3 * payloads.centre + 0.0, ".4g")
        region = f"in an ellipsoid of half axes {joined(half, '.4g')} mm"
        if payloads.region == "cube":
            region = f"in a box of half edges {joined(half, '.4g')} mm"
        elif np.ptp(half) < 1e-9 * half.max():
            region = f"within {half[0]:.4g} mm"
        notes = [
            f"Torque limits {'do NOT hold' if too_much else 'hold'} for every payload of 0 to {payloads.mass:g} kg "
            f"{region} of ({centre}) mm in the last link's frame.",
            f"If power fails on the way, the brake of joint {joint + 1} must hold up to {100 * ratios[joint]:.0f} "
            "% of the joint's torque limit.",
        ]
        rows = [
            (f"joint {j}", f"{round(first, 6):.4g}", f"{round(most, 6):.4g}", f"{limit:.4g}")
            for j, (first, most, limit) in enumerate(zip(start, worst, problem.bounds.torque, strict=True), 1)
        ]
        title = "Torque that the brakes must hold with the worst payload, N·m or N"
        brakes = [Table(title, ("power cut", "at the start", "on the way, at most", "limit"), rows)]
    return banner, table, notes, brakes


def _how_to_run(duration: float, writers: str, command: str) -> OnPage:
    """From the file to the payload: options that write the motion, and the command that takes both recordings."""
    steps = [
        f"Write it for the controller: add {writers} to the command below.",
        "Run it slowly first, and watch cables, fixtures and people: dynident does not know about them.",
        f"Record {duration:.3g} s of positions and torques or currents, without and with the payload, with the "
        "same program.",
        f"Check each recording ('dynident check LOG'), then 'dynident {command} --unloaded A --loaded B'.",
    ]
    return OnPage(lambda: [Text("How to run it", heading=True), Notes(steps)])


def noise_line(problem: DesignProblem) -> str:
    """The torque errors that predicted standard deviations rest on."""
    values, goal = joined(problem.noise[np.isfinite(problem.noise)], ".2g"), problem.goal
    known = f"{values} N·m or N, {'in each of two recordings, ' * (goal.single_rate < goal.rate)}"
    return f"Torque noise {problem.goal.noise_source}: {known}{goal.rate:.3g} independent samples a second."


def _spread_table(title: str, spread: PayloadSpread) -> Table:
    sigmas = [("mass", "kg", spread.mass)]
    sigmas += [(f"centre of mass {axis}", "mm", 1e3 * x) for axis, x in zip("xyz", spread.com, strict=True)]
    sigmas += [(f"inertia {a}{a} at com", "kg m²", x) for a, x in zip("XYZ", spread.moments, strict=True)]
    rows = [(name, unit, f"{x:.2g}" if np.isfinite(x) else "not visible") for name, unit, x in sigmas]
    return Table(title, ("", "unit", "1 sigma"), rows)


def criterion_text(kind: str, value: float) -> str:
    """A criterion's value in words, as a solver works with it."""
    if not np.isfinite(value):
        return f"{kind}: not every parameter can be identified"
    if kind == "d":
        return f"d: uncertainty {np.exp(0.5 * value):.4g} (geometric mean of sigma)"
    if kind == "a":
        return f"a: relative sigma {100.0 * np.exp(value):.4g} % (root mean square)"
    return f"{kind}: condition number {np.exp(value):.4g}"


def visibility_table(visibility: PayloadVisibility) -> Table:
    """Each of the ten, before any motion."""
    joints = ", ".join(map(str, visibility.joints))
    rows = [(kind, visibility.parameters[kind], visibility.combination(kind)) for kind in INERTIAL]
    title = f"Visible to joint{'s' * (len(visibility.joints) > 1)} {joints}: {visibility.rank} of 10"
    return Table(title, ("parameter", "visible", "as part of"), rows)


def near_head(result: NearResult, speed: float) -> tuple[str, ...]:
    """Lines of plain ASCII at the head of a motion's file."""
    shape, plan, problem = result.shape, result.design.plan, result.design.problem
    kind = "Motion that weighs a payload" if speed == 1.0 else f"REHEARSAL at {100 * speed:g} % of the speed"
    name = (problem.robot.title or problem.robot.name).encode("ascii", "replace").decode("ascii")
    if isinstance(shape, StaticShape):
        moves = f"Each held {shape.hold:g} s, after moves from below and from above [rad or m]", shape.approach
    else:
        moves = "Range to either side [rad or m]", shape.ranges
    if isinstance(plan, Fourier) and speed != 1.0:
        plan = plan.slowed(speed)
    return (
        f"{kind}: {name}, by dynident {__version__}.",
        f"Joints {', '.join(map(str, shape.joints))} move, the others are held.",
        *(f"Pose {k} [rad or m]: {joined(q, '.5f')}." for k, q in enumerate(result.poses, 1)),
        f"{moves[0]}: {joined(moves[1], '.5f')}.",
        f"Duration {plan.duration:.6g} s; seed {result.design.seed}.",
        *([] if problem.torque_limited else ["Torque limits were not checked."]),
        *assumed_line(problem),
    )


def motion_figure(problem: DesignProblem, motion: Motion, title: str) -> list[Block]:
    """Positions, speeds and torques of every joint between their limits: a row a joint, a column a quantity."""
    bounds, torques = problem.bounds, load_torques(problem, motion)
    columns = {
        "position": ({"position": motion.q}, (bounds.low, bounds.high)),
        "speed": ({"speed": motion.qd}, (-bounds.speed, bounds.speed)),
        **({"torque": (torques, (-bounds.torque, bounds.torque))} if torques else {}),
    }
    turning = sorted({joint.revolute for joint in problem.robot.joints}, reverse=True)
    units = {name: " or ".join(_UNITS[name][kind] for kind in turning) for name in columns}
    figure = signals(motion.t, {f"{name} [{units[name]}]": column for name, column in columns.items()}, title)
    return [
        Drawing("motion", "Positions, speeds and torques of every joint between their limits, over time.", figure)
    ]
