"""A designed or replayed motion: what the terminal prints, and the report."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....common.arrays import Array
from ....model import INERTIAL, InertialParameters, Motion, Robot
from ....model.drives import parameter_kind
from ....model.inertia import payload_spread
from ....trajectories import Design, DesignProblem, Score
from ....trajectories.design.floor import Floor
from ...export.motions.written import rests_on
from ..blocks import Banner, Block, Notes, Page, Pair, Remarks, Screen, Section, Table, Text, columns
from ..figures.motion import motion_figure, sigma_figure
from ..provenance import Provenance
from .bounded import holding_tables, payload_notes
from .data import report_page
from .description import assumed_notes

_WRITERS = "--samples, --ros2, --urscript or --val3"
_PAYLOAD = "dynident payload --unloaded A --loaded B"
_MOST_SHOWN = 12
_SHOWN = 8  # of more parameters: the least known
_MASS, _ARM, _GYRATION = 3.0, 0.1, 0.055  # kg, m, m: a payload that stands for those to come
_KINDS = ("position", "speed", "acceleration", "torque")
_GROUPS = (
    ("inertia", "kg m²", ("XX", "XY", "XZ", "YY", "YZ", "ZZ")),
    ("first moments", "kg m", ("MX", "MY", "MZ")),
    ("masses", "kg", ("M",)),
    ("rotor inertia", "kg m² or kg", ("IA", "IAM")),
    ("Coulomb friction", "N·m or N", ("FS", "FSM")),
    ("viscous friction", "N·m·s or N·s/m", ("FV", "FVM")),
    ("constant torques", "N·m or N", ("OFF",)),
)
"""Kinds of parameters in words, their unit, and the letters they are called by."""


def design_screen(
    problem: DesignProblem,
    score: Score,
    title: str,
    reference: Mapping[str, float],
    labels: Mapping[str, str],
    floor: Floor | None = None,
    replay: Score | None = None,
    designed: bool = True,
) -> Screen:
    """Which limits hold, what the motion would teach, what to do next; then every parameter.

    Args:
        reference: values that standard deviations are relative to.
        labels: how to call parameters, by their names.
        replay: what a controller's own profiles would make of it.
        designed: whether the motion is new; one that was only judged is written already.
    """
    kind = problem.criterion.kind
    notes = [replay_note(kind, replay)] if replay is not None else []
    notes += payload_notes(problem, score)
    notes += assumed_notes(problem.robot, *rests_on(problem))
    notes += [floor_note(kind, floor)] if floor is not None else []
    lines = [f"Criterion {criterion_text(kind, score.value)}."]
    after = "Next: add --samples, --ros2, --urscript or --val3, run it, then 'dynident check LOG'."
    first: list[Block] = [
        Notes([f"{title}: {limits_in_words(score)}"]),
        limits_table(score),
        taught_table(problem, score),
        Notes([*lines, *([after] if designed else [])]),
        Remarks(notes),
    ]
    brakes = holding_tables(problem, score)
    details = [score_table(problem, score, title), *sigma_tables(score, reference, labels), *brakes]
    return Screen(first, details, f"condition numbers, every parameter{', what brakes hold' if brakes else ''}")


def limits_in_words(score: Score) -> str:
    """Whether the motion keeps its limits, and which were not checked."""
    checked = [limit.name for limit in score.limits]
    missing = [kind for kind in _KINDS if not any(name.startswith(kind) for name in checked)]
    unchecked = f" NOT checked: {', '.join(missing)}." if missing else ""
    if score.feasible:
        return f"keeps every limit{' that was checked' if missing else ''}.{unchecked}"
    return f"does NOT keep {', '.join(dict.fromkeys(_missed(score)))}.{unchecked}"


def _missed(score: Score) -> list[str]:
    return [limit.name for limit in score.limits if str(limit) in score.violations]


def limits_table(score: Score) -> Table:
    """How near each limit comes, SI units."""
    rows = [
        (
            limit.name,
            f"{limit.value:.4g}",
            f"{limit.limit:.4g}",
            limit.worst,
            f"violated by {limit.violation:.4g}" if str(limit) in score.violations else "met",
        )
        for limit in score.limits
    ]
    headings = (*columns(("limit",), ("comes to", "limit")), *columns(("at", "")))
    return Table(f"Nearest to its limits, SI units, in {score.duration:.4g} s", headings, rows, style="tight")


def taught_table(problem: DesignProblem, score: Score) -> Table:
    """What one run of the motion would tell, 1 sigma, in units of the answer.

    Of a payload mass, centre of mass and inertia there, of one of the rated mass 100 mm from the flange; of a robot
    its parameters kind by kind.
    """
    learnt, last = score.learnt, str(problem.robot.n)
    length = problem.goal.data_length
    recorded = f"{length:g} s of data" if length else "one run"
    if learnt.covariance is None:
        return Table(f"From {recorded}: not every parameter can be told", columns(("",)), [])
    if tuple(problem.names) == tuple(f"{kind}{last}" for kind in INERTIAL):
        return _payload_taught(problem.robot, learnt.covariance, recorded)
    rows = []
    for words, unit, kinds in _GROUPS:
        sigma = [s for name, s in learnt.sigma.items() if parameter_kind(name) in kinds]
        if sigma:
            rows.append((words, str(len(sigma)), f"{np.median(sigma):.2g}", f"{max(sigma):.2g}", unit))
    headings = (*columns(("",), ("number", "median", "largest")), *columns(("",)))
    return Table(f"From {recorded}, of the robot, 1 sigma", headings, rows, style="tight")


def _payload_taught(robot: Robot, covariance: Array, recorded: str) -> Table:
    """Standard deviations of a payload's mass, centre of mass and inertia there."""
    mass = robot.rated_payload if np.isfinite(robot.rated_payload) else _MASS
    body = InertialParameters.from_com(mass, [0.0, 0.0, _ARM], _GYRATION**2 * mass * np.eye(3))
    spread = payload_spread(body.vector, covariance, range(len(INERTIAL)))
    rows = [("mass", f"{spread.mass:.2g}", "kg")]
    rows += [(f"centre of mass {axis}", f"{1e3 * x:.2g}", "mm") for axis, x in zip("xyz", spread.com, strict=True)]
    rows += [(f"inertia {a}{a} at com", f"{x:.2g}", "kg m²") for a, x in zip("XYZ", spread.moments, strict=True)]
    title = f"From {recorded}, of a payload of {mass:g} kg {1e3 * _ARM:g} mm away"
    return Table(title, (*columns(("",), ("1 sigma",)), *columns(("",))), rows, style="tight")


def criterion_text(kind: str, value: float) -> str:
    """A criterion's value in words, as a solver works with it."""
    if not np.isfinite(value):
        return f"{kind}: not every parameter can be told"
    if kind == "d":
        return f"d: uncertainty {np.exp(0.5 * value):.4g} (geometric mean of sigma)"
    if kind == "a":
        return f"a: relative sigma {100.0 * np.exp(value):.4g} % (root mean square)"
    return f"{kind}: condition number {np.exp(value):.4g}"


def score_table(problem: DesignProblem, score: Score, title: str) -> Table:
    """What the motion would teach, and how near each limit comes."""
    learnt, length = score.learnt, problem.goal.data_length
    recorded = f"{length:g} s of data, the motion repeated" if length else "recorded once"
    rows = [
        ("duration", f"{score.duration:.4g}", f"s; {recorded}"),
        ("parameters", str(len(problem.names)), f"criterion {problem.criterion.kind}"),
        ("condition number", _finite(learnt.condition_number), "of W in SI units"),
        ("", _finite(learnt.condition_number_scaled), "columns scaled to norm 1"),
        ("log det", _finite(learnt.log_det), "of the information matrix"),
    ]
    for limit in score.limits:
        missed = str(limit) in score.violations
        state = f"violated by {limit.violation:.4g}" if missed else "met"
        rows.append((limit.name, f"{limit.value:.4g}", f"{limit.worst}, limit {limit.limit:.4g}: {state}"))
    return Table(title, columns(("",), ("value",), ("",)), rows, ("log det",))


def sigma_tables(score: Score, reference: Mapping[str, float], labels: Mapping[str, str]) -> list[Table]:
    """Predicted standard deviations; of many parameters the least known. None where not all can be told."""
    sigma = score.learnt.sigma
    if not np.isfinite(list(sigma.values())).all():
        return []
    relative = score.relative_sigma(dict(reference))
    shown = list(sigma)
    if len(sigma) > _MOST_SHOWN:
        shown = sorted(sigma, key=lambda name: -relative.get(name, 0.0))[: _SHOWN if relative else 0]
    if not shown:
        return []
    rows = []
    for name in shown:
        value = f"{reference[name]:.4g}" if name in reference else ""
        percent = f"{100.0 * relative[name]:.2g}" if name in relative else ""
        rows.append((labels.get(name, name), f"{sigma[name]:.3g}", value, percent))
    least = f", the {len(shown)} least known of {len(sigma)}" if len(shown) < len(sigma) else ""
    return [Table(f"Predicted sigma{least}", columns(("",), ("sigma", "value", "%")), rows)]


def floor_note(kind: str, floor: Floor) -> str:
    """How far a motion is from the best that states within the limits allow."""
    if kind == "d":
        times = f"its uncertainty is {np.exp(0.5 * floor.gap):.3g} times the floor's"
    elif kind == "a":
        times = f"its relative sigma is {np.exp(floor.gap):.3g} times the floor's"
    else:
        times = f"its condition number is {np.exp(floor.gap):.3g} times the floor's"
    return (
        f"Floor over {floor.states} weighted states within the limits, continuity ignored: "
        f"{criterion_text(kind, floor.value)}; {times}."
    )


def replay_note(kind: str, replay: Score) -> str:
    """What a controller's own profiles between the via points would make of the motion."""
    limits = f"but {'; '.join(replay.violations)}" if replay.violations else "every limit met"
    return (
        f"Replayed by trapezoidal moves as --val3 asks for: {criterion_text(kind, replay.value)} in "
        f"{replay.duration:.4g} s, {limits}. Score the controller's log by 'dynident score'."
    )


def design_page(
    problem: DesignProblem,
    score: Score,
    motion: Motion,
    design: Design | None,
    screen: Sequence[Block],
    reference: Mapping[str, float],
    labels: Mapping[str, str],
    provenance: Provenance,
) -> Page:
    """What the motion would teach, and its limits.

    Args:
        design: the designed motion; None where one was only judged.
        screen: what the terminal shows of it.
        reference: values that standard deviations are relative to.
        labels: how to call parameters, by their names.
    """
    title = problem.robot.title or problem.robot.name
    drawings: list[Block] = [motion_figure(problem, motion, f"{title}: motion between its limits")]
    if np.isfinite(list(score.learnt.sigma.values())).all():
        drawings.append(sigma_figure(score, f"{title}: what the motion would teach", reference, labels))
    sections = [Section("motion", "Motion and what it would teach", [*screen, *drawings])]
    how: list[Block] = []
    if design is not None:
        how = [Text("How to run it", "heading"), how_to_run(score.duration, _WRITERS, _PAYLOAD)]
    taught: list[Block] = [Text("What it will teach", "heading"), taught_table(problem, score)]
    lead: list[Block] = [limits_banner(score), Pair([limits_table(score)], taught), *how]
    return report_page(f"Motion for the {title}", provenance.day, lead, sections, (), provenance)


def limits_banner(score: Score) -> Banner:
    """Whether the motion may be run: every limit holds, some were not checked, or one does not hold."""
    words = limits_in_words(score)
    level = "do_not_use" if not score.feasible else "mass_and_com_only" if "NOT checked" in words else "use"
    return Banner(level, f"The motion {words}")


def how_to_run(duration: float, writers: str, answers: str) -> Block:
    """From the file to the payload.

    Args:
        duration: of one run [s].
        writers: options that write the motion for a controller.
        answers: the command that takes both recordings.
    """
    steps = [
        f"Write it for the controller: add {writers} to the command below.",
        "Run it slowly first, and look at cables, fixtures and people: nothing here knows of them.",
        f"Record {duration:.3g} s of positions and torques or currents, without and with the payload, by the "
        "same program.",
        f"Look at each recording by 'dynident check LOG', then '{answers}'.",
    ]
    return Notes(steps)


def _finite(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "rank-deficient"
