"""``dynident design``: the most informative motion a robot may make."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ... import trajectories
from ...common.files import made_folder, write_text
from .. import export, report
from .. import view as views
from . import ANSWERED
from .motion_pages import FIGURE_RATE, Judged, show
from .motion_request import Asked, build_request
from .motion_search import best_motion, floor_of
from .options import (
    GoalOptions,
    LimitOptions,
    MotionFiles,
    Options,
    RehearsedRobotOptions,
    ShapeOptions,
    ViewOptions,
    option,
)
from .values import positive, whole

_REPLAY_RATE = 500.0  # Hz


@dataclass(frozen=True)
class _Search(Options):
    """How a motion is searched for."""

    GROUP = "search"

    seed: int = option(type=whole, default=0, help="of the random starts (default: 0)")
    starts: int | None = option(type=positive, metavar="K", help="random starts (default: 6 by d and a, else 3)")
    bound: bool = option(action="store_true", help="estimate the floor over all motions, and the gap")


@dataclass(frozen=True)
class _DesignFiles(MotionFiles):
    """Formats of the motion, and the folder of a VAL3 application."""

    val3: str | None = option(
        writes="folder",
        metavar="DIR",
        help="VAL3 application of via points, best with --segments trapezoid; made if missing",
    )

    def write(self, written: export.motions.WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        super().write(written)
        if self.val3:
            folder = made_folder(self.val3)
            for name, text in export.motions.val3_files(written, folder.name).items():
                write_text(folder / name, text)


def run(
    arm: RehearsedRobotOptions,
    shape: ShapeOptions,
    goal: GoalOptions,
    limits: LimitOptions,
    search: _Search,
    files: _DesignFiles,
    view: ViewOptions,
) -> int:
    """Run it."""
    view.check_view()
    robot = arm.load()
    lengths = Asked(shape.shape(), shape.known_length(), shape.max_duration, shape.start_pose(robot))
    request = build_request(robot, lengths, goal, limits)
    robot, kind = request.problem.robot, request.problem.criterion.kind
    files.check(robot)
    if files.val3:
        export.motions.check_val3(robot, not shape.fourier, Path(files.val3).name)

    def words(best: float | None) -> str:
        text = None if best is None else report.criterion_text(kind, best)
        return f"; best: {text or 'no motion within the limits yet'}"

    design = best_motion(request.problem, search.seed, search.starts, words)
    floor = floor_of(request.problem, design.score, search.seed) if search.bound else None
    title, samples = f"Motion of {robot.title or robot.name}", design.motion(FIGURE_RATE)
    replay = _replayed(design) if files.val3 else None
    judged = Judged(title, design.score, samples, design, floor, replay)
    written = export.motions.WrittenMotion(
        robot, design.plan, request.problem.bounds, export.motions.design_head(design)
    )
    bounded = request.problem.payloads is not None
    files.check_replays(limits.whole(request.problem), written, val3=files.has("val3") and bounded)
    show(files, request, judged, limits, goal, arm)
    files.write(written)
    view.write_view(lambda: views.view_of(robot, samples, problem=request.problem))
    return ANSWERED


def _replayed(design: trajectories.Design) -> trajectories.Score:
    """What a controller would make of the via points if its profiles are trapezoidal, as ``--val3`` asks for."""
    problem = design.problem
    written = export.motions.WrittenMotion(problem.robot, design.plan, problem.bounds, ())
    return trajectories.score_motion(problem, export.motions.val3_replay(written).motion(_REPLAY_RATE))
