"""A motion that was designed, replayed or asked for near a pose: its limits, and what it will tell."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from .... import __version__
from ....model import INERTIAL, InertialParameters, Motion
from ....model.drives import parameter_kind
from ....model.friction import LAWS
from ....model.inertia import PayloadSpread, payload_spread
from ....model.visibility import PayloadVisibility
from ....trajectories import DesignProblem, Fourier, Scene, Score, StaticShape
from ....trajectories.design.problem import BALL
from ....trajectories.design.score import Learnt, holding_torques, load_torques
from ...export.motion import assumed_line, rests_on
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text, lines
from ..documents import JudgedMotion, NearResult
from ..figures import Figure, by_joint, log_scale, named, named_panels, signals
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
    brakes_note, brakes = _brakes(problem, score)
    replayed = floored = ""
    if replay is not None:
        limits = f"but {'; '.join(replay.violations)}" if replay.violations else "every limit met"
        replayed = (
            f"Replayed by trapezoidal moves, as --val3 commands: {criterion_text(kind, replay.value)} in "
            f"{replay.duration:.4g} s, {limits}. Run 'dynident score' on the controller's log."
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
    conditions = {"cond": learnt.condition_number, "cond-scaled": learnt.condition_number_scaled}
    reached = float(np.log(conditions[kind])) if kind in conditions else score.value
    assumed = assumed_notes(problem.robot, *rests_on(problem))
    after = [f"Next: add {writers}, run it, then 'dynident check LOG'."] if judged.design is not None else []
    first: list[Block] = [
        _motion_banner(judged.title, score),
        _limits_table(score),
        _taught_table(problem, learnt),
        Notes([noise_line(problem), f"Criterion {criterion_text(kind, reached)}.", *after]),
        Notes(lines(replayed, *brakes_note, *assumed, floored), optional=True),
        *([_how_to_run(score.duration, writers, "payload")] if after else []),
    ]
    recorded = f"{length:g} s of data, the motion repeated" if length else "recorded once"
    raw, scaled, log_det = (
        f"{x:.4g}" if np.isfinite(x) else "rank-deficient"
        for x in (learnt.condition_number, learnt.condition_number_scaled, learnt.log_det)
    )
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
    rows = [
        (
            labels.get(name, name),
            f"{sigma[name]:.3g}",
            f"{reference[name]:.4g}" if name in reference else "",
            f"{100.0 * relative[name]:.2g}" if name in relative else "",
        )
        for name in shown
    ]
    least = f", the {len(shown)} least known of {len(sigma)}" if len(shown) < len(sigma) else ""
    blocks: list[Block] = [
        Table("Parameters together", ("", "value", "remark"), together),
        *([Table(f"Predicted sigma{least}", ("", "sigma", "value", "%"), rows)] if known and rows else []),
        *brakes,
        motion_figure(problem, judged.motion, f"{title}: motion between its limits"),
        *([sigma_figure(learnt, f"{title}: predicted standard deviations", reference, labels)] if known else []),
    ]
    more = f"condition numbers, all parameters{', torque on the brakes' if brakes else ''}"
    return Report(
        f"Motion for the {title}", first, [Section("motion", "Motion and what it would teach", blocks)], more
    )


def near_report(result: NearResult, expected: InertialParameters, hints: Sequence[str], motion: Motion) -> Report:
    """Predicted sigma of an expected payload, what to do next, other ``hints``; visibility, poses, motion."""
    robot, problem, score = result.robot, result.design.problem, result.design.score
    title, joints = robot.title or robot.name, ", ".join(map(str, result.shape.joints))
    position = ", ".join(f"{1e3 * x:g}" for x in expected.com)
    kind, writers, command, noted, course = _course(result, expected.mass)
    brakes_note, brakes = _brakes(problem, score)
    unchecked = (
        "Torque limits are NOT checked: the description lacks torque limits or parameters (--robot-parameters or "
        "--arm-mass). A slow run does not reveal them either."
    )
    notes = [
        *hints,
        f"Duration {course}",
        *([] if problem.torque_limited else [unchecked]),
        *brakes_note,
        *assumed_notes(robot, *rests_on(problem)),
    ]
    rungs = [
        (f"run {k}", f"{100.0 * rung.speed:.0f}", f"{rung.mass:.2f}", f"{rung.bound:.2f}")
        for k, rung in enumerate(result.ladder, 1)
    ]
    ladder = "Ladder: go on only if the last run showed no more than the next one allows"
    headings = ("step", "speed %", "safe up to kg", "then known to be below kg")
    first: list[Block] = [
        _motion_banner(f"{kind} of joints {joints} of {title}", score),
        _spread_table(f"Predicted accuracy for {expected.mass:g} kg at ({position}) mm", result.spread),
        *([Table(ladder, headings, rungs)] if rungs else []),
        Notes(
            [
                *noted,
                f"Next: add {writers}, run the motion without and with the payload, then 'dynident {command}'.",
            ]
        ),
        Notes(notes, optional=True),
        OnPage(lambda: [_limits_table(score)]),
        _how_to_run(result.design.plan.duration, writers, command),
    ]
    scale = np.where([joint.revolute for joint in robot.joints], 180.0 / np.pi, 1.0)
    stood = ("pose", *(f"q{j}" for j in range(1, robot.n + 1)))
    poses = [(str(k), *(f"{x:.1f}" for x in scale * pose)) for k, pose in enumerate(result.poses, 1)]
    drawn = motion_figure(problem, motion, f"Motion that weighs a payload: {title}")
    sections = [
        Section("payload", "What it shows of a payload", [visibility_table(result.visibility), *brakes]),
        Section("motion", "The motion between its limits", [Table("Poses, deg or m", stood, poses), drawn]),
    ]
    more = f"poses, which parameters these joints show{', torque on the brakes' if brakes else ''}"
    return Report(f"Motion that weighs a payload: {title}", first, sections, more)


def _course(result: NearResult, mass: float) -> tuple[str, str, str, list[str], str]:
    """Describe a motion: its name, the options that write it, its command, its errors, and how long it takes."""
    problem, plan, shape = result.design.problem, result.design.plan, result.shape
    if isinstance(shape, StaticShape):
        share, course = result.spread.mass / mass, "poses are held {:g} s after moves from below and above"
        advice = f" Above {100 * _STATIC_MOST:g} % a motion is better: omit --static." * (share > _STATIC_MOST)
        scatter = ", ".join(f"{x:.2g}" for x in problem.noise if np.isfinite(x))
        noted = [
            f"1 sigma is {100.0 * share:.2g} % of the mass.{advice}",
            f"Scatter of the torque at rest from one approach to the next ({problem.noise_from}): {scatter} N·m or "
            "N. Constant torques may change between recordings, those of the arm by 0.66 times that, of the wrist "
            "freely.",
        ]
        writers, course = "--samples, --ros2, --urscript or --val3", course.format(shape.hold)
        return f"{shape.count} poses at rest", writers, "weigh --static", noted, f"{plan.duration:.0f} s: {course}."
    assert isinstance(plan, Fourier)
    periods = "one period" if plan.repeats == 1 else f"{plan.repeats} periods"
    two = f", at {len(plan.poses)} poses, {plan.transfer:.1f} s apart" * bool(plan.transfer)
    slower = ", ".join(f"{rung.duration:.0f}" for rung in result.ladder if rung.speed < 1.0)
    before = f"the rehearsal, one period at a tenth of the speed, takes {plan.slowed(0.1).duration:.0f} s"
    if result.ladder:
        before = f"the slower runs before it take {slower} s" if slower else "the first run may be at full speed"
    course = f"{plan.duration:.1f} s: {periods} of {plan.period:.2f} s{two}; {before}."
    return "Motion", "--samples, --ros2 or --urscript", "weigh", [noise_line(problem)], course


def _motion_banner(title: str, score: Score) -> Text:
    names = dict.fromkeys(limit.name for limit in score.limits)
    missing = [kind for kind in _KINDS if not any(name.startswith(kind) for name in names)]
    missed = dict.fromkeys(limit.name for limit in score.limits if str(limit) in score.violations)
    level, text = "mass_and_com_only" if missing else "use", f"all{' checked' * bool(missing)} limits"
    keeps = f"within {text}" if score.feasible else f"NOT within its limits of {', '.join(missed)}"
    scene = score.problem.scene or Scene()
    radii = {body.radius for body in scene.bodies if body.link and body.name != BALL}
    tubes = f" (tubes of {1e3 * max(radii):.0f} mm radius)" if len(radii) == 1 else ""
    looked = [f"the arm itself{tubes}"] * bool(scene.pairs) + [f"the {surface.name}" for surface in scene.surfaces]
    unseen = [*missing, *["self-collision"] * (not scene.pairs)]
    unseen += ["floor"] * (not any("floor" in surface.name for surface in scene.surfaces))
    unseen += [*["payload"] * (score.problem.payloads is None), "cables and cell"]
    clear = f" Collisions checked with {' and '.join(looked)}." * bool(looked)
    level = level if score.feasible else "do_not_use"
    return Text(f"{title}: {keeps}.{clear} NOT checked: {', '.join(unseen)}.", level=level)


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


def _brakes(problem: DesignProblem, score: Score) -> tuple[list[str], list[Table]]:
    """The set of payloads, if any, and the torque that holds the arm still with the worst, joint by joint."""
    payloads = problem.payloads
    if payloads is None:
        return [], []
    missed = any(limit.name.startswith("torque") and str(limit) in score.violations for limit in score.limits)
    start, worst = (holding_torques(problem, poses) for poses in (score.samples.q[:1], score.samples.q))
    ratios = worst / problem.bounds.torque
    joint, half = int(np.argmax(ratios)), 1e3 * payloads.half
    x, y, z = 1e3 * payloads.centre + 0.0
    axes = ", ".join(f"{length:.4g}" for length in half)
    region = f"in an ellipsoid of half axes {axes} mm"
    if payloads.region == "cube":
        region = f"in a box of half edges {axes} mm"
    elif np.ptp(half) < 1e-9 * half.max():
        region = f"within {half[0]:.4g} mm"
    notes = [
        f"Torque limits {'do NOT hold' if missed else 'hold'} for every payload of 0 to {payloads.mass:g} kg "
        f"{region} of ({x:.4g}, {y:.4g}, {z:.4g}) mm in the last link's frame.",
        f"If power fails on the way, the brake of joint {joint + 1} must hold up to {100 * ratios[joint]:.0f} % of "
        "the joint's torque limit.",
    ]
    rows = [
        (f"joint {j}", f"{round(first, 6):.4g}", f"{round(most, 6):.4g}", f"{limit:.4g}")
        for j, (first, most, limit) in enumerate(zip(start, worst, problem.bounds.torque, strict=True), 1)
    ]
    headings = ("power cut", "at the start", "on the way, at most", "limit")
    title = "Torque that the brakes must hold with the worst payload, N·m or N"
    return notes, [Table(title, headings, rows)]


def _limits_table(score: Score) -> Table:
    rows = []
    for limit in score.limits:
        kept = f"violated by {limit.violation:.4g}" if str(limit) in score.violations else "met"
        rows.append((limit.name, f"{limit.value:.4g}", f"{limit.limit:.4g}", limit.worst, kept))
    title = f"Largest values against the limits, SI units, in {score.duration:.4g} s"
    return Table(title, ("", "reaches", "limit", "where", "kept"), rows)


def noise_line(problem: DesignProblem) -> str:
    """The torque errors that predicted standard deviations rest on."""
    goal, sigma = problem.goal, [f"{x:.2g}" for x in problem.noise if np.isfinite(x)]
    pair = "in each of two recordings, " * (goal.single_rate < goal.rate)
    values = ", ".join(sigma)
    return (
        f"Torque noise {problem.noise_from}: {values} N·m or N, {pair}{goal.rate:.3g} independent samples a second."
    )


def _taught_table(problem: DesignProblem, learnt: Learnt) -> Table:
    """Sigma that one run would leave: of a payload of the rated mass, or of a robot kind by kind."""
    length = problem.goal.data_length
    recorded = f"{length:g} s of data" if length else "one run"
    if learnt.covariance is None:
        return Table(f"From {recorded} not every parameter can be identified", ("",), [])
    if tuple(problem.names) == tuple(f"{kind}{problem.robot.n}" for kind in INERTIAL):
        # A payload of the rated mass stands for those to come.
        mass = problem.robot.rated_payload if np.isfinite(problem.robot.rated_payload) else _MASS
        body = InertialParameters.from_com(mass, [0.0, 0.0, _ARM], _GYRATION**2 * mass * np.eye(3))
        spread = payload_spread(body.vector, learnt.covariance, range(len(INERTIAL)))
        return _spread_table(
            f"Predicted from {recorded} for {mass:g} kg, {1e3 * _ARM:g} mm along the last axis", spread
        )
    rows = []
    for text, unit, kinds in _GROUPS:
        sigma = [s for name, s in learnt.sigma.items() if parameter_kind(name) in kinds]
        if sigma:
            rows.append((text, str(len(sigma)), f"{np.median(sigma):.2g}", f"{max(sigma):.2g}", unit))
    headings = ("", "number", "median", "largest", "unit")
    return Table(f"Predicted accuracy of the robot's parameters from {recorded} (1 sigma)", headings, rows)


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
    shape, plan = result.shape, result.design.plan
    kind = "Motion that weighs a payload" if speed == 1.0 else f"REHEARSAL at {100 * speed:g} % of the speed"
    name = (result.robot.title or result.robot.name).encode("ascii", "replace").decode("ascii")
    unchecked = [] if result.design.problem.torque_limited else ["Torque limits were not checked."]
    if isinstance(shape, StaticShape):
        moves = f"Each held {shape.hold:g} s, after moves from below and from above [rad or m]", shape.approach
    else:
        moves = "Range to either side [rad or m]", shape.ranges
    if isinstance(plan, Fourier) and speed != 1.0:
        plan = plan.slowed(speed)
    return (
        f"{kind}: {name}, by dynident {__version__}.",
        f"Joints {', '.join(map(str, shape.joints))} move, the others are held.",
        *(f"Pose {k} [rad or m]: {', '.join(f'{x:.5f}' for x in q)}." for k, q in enumerate(result.poses, 1)),
        f"{moves[0]}: {', '.join(f'{x:.5f}' for x in moves[1])}.",
        f"Duration {plan.duration:.6g} s; seed {result.design.seed}.",
        *unchecked,
        *assumed_line(result.design.problem),
    )


def motion_figure(problem: DesignProblem, motion: Motion, title: str) -> Drawing:
    """Positions, speeds and torques of every joint between their limits: a row a joint, a column a quantity."""

    def drawn() -> Figure:
        bounds, torques = problem.bounds, load_torques(problem, motion)
        turning = sorted({joint.revolute for joint in problem.robot.joints}, reverse=True)
        columns = {
            "position": partial(signals, motion.t, {"position": motion.q}, limits=(bounds.low, bounds.high)),
            "speed": partial(signals, motion.t, {"speed": motion.qd}, limits=(-bounds.speed, bounds.speed)),
            "torque": partial(signals, motion.t, torques, limits=(-bounds.torque, bounds.torque)),
        }
        units = {name: " or ".join(_UNITS[name][kind] for kind in turning) for name in columns}
        shown = {f"{name} [{units[name]}]": draw for name, draw in columns.items() if torques or name != "torque"}
        return by_joint(problem.robot.n, shown, title)

    return Drawing("motion", "Positions, speeds and torques of every joint between their limits, over time.", drawn)


def sigma_figure(learnt: Learnt, title: str, reference: Mapping[str, float], labels: Mapping[str, str]) -> Drawing:
    """Predicted sigma of every parameter: relative where a reference value is known, else in SI units."""

    def draw() -> Figure:
        relative = learnt.relative_sigma(reference)
        percent = {labels.get(name, name): 100.0 * x for name, x in relative.items()}
        absolute = {labels.get(name, name): x for name, x in learnt.sigma.items() if name not in relative}
        parts = [pair for pair in (("relative to its value [%]", percent), ("in SI units", absolute)) if pair[1]]
        figure, axes = named_panels(max(len(values) for _, values in parts), len(parts))
        for axis, (unit, values) in zip(axes, parts, strict=True):
            heights = np.array(list(values.values()))
            axis.bar(np.arange(len(heights)), heights, color="0.75", edgecolor="black", linewidth=0.6)
            axis.set_ylim(0.5 * heights.min(), 6.0 * heights.max())
            log_scale(axis)
            for k in np.argsort(-heights, kind="stable")[:_FEW_NAMED]:  # the least known with their number
                position: tuple[float, float] = (k, heights[k])
                axis.annotate(f"{heights[k]:.2g}", position, ha="center", va="bottom", fontsize=7, rotation=90)
            named(axis, list(values))
            axis.set_ylabel(f"predicted sigma\n{unit}", fontsize=9)
        figure.suptitle(title)
        return figure

    caption = "Standard deviation that identification would leave to each parameter, predicted."
    return Drawing("predicted_sigma", caption, draw)
