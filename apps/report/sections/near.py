"""A motion near a pose: what will be visible, what it will tell, what its file says about it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .... import __version__
from ....common.arrays import Array
from ....model import INERTIAL, InertialParameters, Motion, Robot
from ....model.inertia import PayloadSpread
from ....model.visibility import PayloadVisibility
from ....trajectories import Design, NearMotion, NearShape
from ....trajectories.design.full_trajectory import Rung
from ...export.motions.written import assumed_line, rests_on
from ..blocks import Block, Notes, Page, Pair, Remarks, Screen, Section, Table, Text, columns, tables_of
from ..figures.motion import motion_figure
from ..provenance import Provenance
from .bounded import holding_tables, payload_notes
from .data import report_page
from .description import assumed_notes
from .design import how_to_run, limits_banner, limits_in_words, limits_table

_DIGITS = {"kg": 3, "mm": 1, "kg m²": 4}
_MOTION = "Positions and speeds of every joint between its limits, and torques where they are known, over time."


def visibility_table(visibility: PayloadVisibility) -> Table:
    """Each of the ten, before any motion."""
    joints = ", ".join(map(str, visibility.joints))
    rows = [(kind, visibility.parameters[kind], visibility.combination(kind)) for kind in INERTIAL]
    title = f"Visible to joint{'s' * (len(visibility.joints) > 1)} {joints}: {visibility.rank} of 10"
    return Table(title, columns(("parameter", "visible", "as part of")), rows)


def prediction_table(spread: PayloadSpread, expected: InertialParameters) -> Table:
    """Standard deviations to come."""
    place = ", ".join(f"{1e3 * x:g}" for x in expected.com)
    sigmas = [("mass", "kg", spread.mass)]
    sigmas += [(f"centre of mass {axis}", "mm", 1e3 * x) for axis, x in zip("xyz", spread.com, strict=True)]
    sigmas += [(f"inertia {a}{a} at com", "kg m²", x) for a, x in zip("XYZ", spread.moments, strict=True)]
    rows = [
        (name, unit, f"{sigma:.{_DIGITS[unit]}f}" if np.isfinite(sigma) else "not visible")
        for name, unit, sigma in sigmas
    ]
    title = f"Predicted for {expected.mass:g} kg at ({place}) mm"
    return Table(title, columns(("quantity", "unit"), ("sigma",)), rows, style="tight")


class NearResult(NamedTuple):
    """A motion near a pose, and what it will tell of a payload.

    Attributes:
        design: of the series; its score tells the limits.
        shape: what was asked of the motion.
        visibility: what can be seen at all.
        spread: predicted standard deviations, of white noise.
        ladder: the runs up to full speed; none where the motion holds for every payload.
    """

    design: Design
    shape: NearShape
    visibility: PayloadVisibility
    spread: PayloadSpread
    ladder: tuple[Rung, ...] = ()

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.design.problem.robot

    @property
    def motion(self) -> NearMotion:
        """The motion with its repeats and transfers."""
        assert isinstance(self.design.plan, NearMotion)
        return self.design.plan


def near_screen(result: NearResult, expected: InertialParameters, hints: Sequence[str]) -> Screen:
    """What the motion will tell of a payload, and what to do next; then what can be seen at all.

    Args:
        expected: about what the payload is.
        hints: what else could be done.
    """
    title = result.robot.title or result.robot.name
    joints = ", ".join(map(str, result.shape.joints))
    limits = limits_in_words(result.design.score)
    after = "Next: add --samples, --ros2 or --urscript, run it without and with the payload, then 'dynident weigh'."
    first: list[Block] = [
        Notes([f"Motion of joints {joints} of {title}: {limits}"]),
        prediction_table(result.spread, expected),
        *ladder_tables(result.ladder),
        Notes([after]),
        Remarks([*hints, *near_notes(result)]),
    ]
    brakes = holding_tables(result.design.problem, result.design.score)
    details = f"which parameters these joints show{', what brakes hold' if brakes else ''}"
    return Screen(first, [visibility_table(result.visibility), *brakes], details)


def near_notes(result: NearResult) -> list[str]:
    """Duration, speeds, limits; where the prediction comes from."""
    motion = result.motion
    two = (
        f", at {len(motion.poses)} poses, {motion.transfer:.1f} s from one to the other" if motion.transfer else ""
    )
    periods = "one period" if motion.repeats == 1 else f"{motion.repeats} periods"
    lines = [
        f"{motion.duration:.1f} s: {periods} of {motion.period:.2f} s{two}; {_before(result)}.",
        "Sigma by (17)-(19) for white torque noise; constant torques and Coulomb friction are estimated too. Real "
        "recordings have 1.6 to 4 times as much.",
    ]
    if not result.design.problem.torque_limited:
        lines.append(
            "Torque limits are NOT checked: the description has no torque limits or no parameters "
            "(--robot-parameters or --arm-mass); the rehearsal does not show them either."
        )
    lines += payload_notes(result.design.problem, result.design.score)
    return [*lines, *assumed_notes(result.robot, *rests_on(result.design.problem))]


def _before(result: NearResult) -> str:
    slower = [rung.motion.duration for rung in result.ladder if rung.speed < 1.0]
    if slower:
        return f"the slower runs before it take {', '.join(f'{duration:.0f}' for duration in slower)} s"
    if result.ladder:
        return "the first run may be at full speed"
    return f"the rehearsal, once at a tenth of the speed, takes {result.motion.slowed(0.1).duration:.0f} s"


def ladder_tables(ladder: Sequence[Rung]) -> list[Table]:
    """Speed of each run, the mass that it bears, and the bound that it leaves; nothing without a ladder."""
    rows = [
        (f"run {k}", f"{100.0 * rung.speed:.0f}", f"{rung.mass:.2f}", f"{rung.bound:.2f}")
        for k, rung in enumerate(ladder, 1)
    ]
    headings = columns(("step",), ("speed %", "bears kg", "then at most kg"))
    title = "Ladder: go on only if the run before shows at most what the next one bears"
    return [Table(title, headings, rows, style="tight")] if rows else []


def near_head(result: NearResult, speed: float) -> tuple[str, ...]:
    """Lines of plain ASCII at the head of a motion's file."""
    shape, motion = result.shape, result.motion if speed == 1.0 else result.motion.slowed(speed)
    kind = "Motion that weighs a payload" if speed == 1.0 else f"REHEARSAL at {100 * speed:g} % of the speed"
    joints = ", ".join(map(str, shape.joints))
    name = (result.robot.title or result.robot.name).encode("ascii", "replace").decode("ascii")
    lines = [f"{kind}: {name}, by dynident {__version__}.", f"Joints {joints} move, the others are held."]
    for k, pose in enumerate(shape.poses, 1):
        lines.append(f"Pose {k} [rad or m]: {', '.join(f'{x:.5f}' for x in pose)}.")
    lines.append(f"Range to either side [rad or m]: {', '.join(f'{x:.5f}' for x in shape.ranges)}.")
    lines.append(f"Duration {motion.duration:.6g} s; seed {result.design.seed}.")
    if not result.design.problem.torque_limited:
        lines.append("Torque limits were not checked.")
    return (*lines, *assumed_line(result.design.problem))


def second_pose_note(first: Array, second: Array) -> str:
    """Where a second pose would be."""
    turns = enumerate(np.degrees(second - first), 1)
    joints = " and ".join(f"joint {j} by {turn:+.0f} deg" for j, turn in turns if abs(turn) > 1.0)
    return (
        f"A second wrist pose ({joints}) would tell clearly more: add --second-pose auto if the robot may go there."
    )


def near_page(result: NearResult, motion: Motion, screen: Screen, provenance: Provenance) -> Page:
    """What the motion shows of a payload, and the motion between its limits.

    Args:
        screen: what the terminal shows of it.
    """
    robot, plan = result.robot, result.motion
    title = f"Motion that weighs a payload: {robot.title or robot.name}"
    joints = ", ".join(map(str, result.shape.joints))
    score = result.design.score
    shows: list[Block] = [Text("What it will tell", "heading"), *tables_of(screen.first)]
    lead: list[Block] = [
        limits_banner(score),
        Text(f"{plan.duration:.1f} s; joints {joints} move, the others are held."),
        Pair([limits_table(score)], shows),
        Text("How to run it", "heading"),
        how_to_run(plan.duration, "--samples, --ros2 or --urscript", "dynident weigh --unloaded A --loaded B"),
    ]
    drawn = motion_figure(result.design.problem, motion, title, _MOTION)
    sections = [
        Section("payload", "What it shows of a payload", screen.blocks),
        Section("motion", "The motion between its limits", [drawn]),
    ]
    return report_page(title, provenance.day, lead, sections, (), provenance)
