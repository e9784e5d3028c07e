"""``dynident rollout``: how far the identified robot's motion strays from a recording's."""

from __future__ import annotations

from dataclasses import dataclass

from ... import model
from ...common.errors import InputError
from .. import report, results, rollout
from . import ANSWERED
from .options import FilterOptions, Options, PageOptions, RobotOptions, option
from .progress import status
from .values import seconds_list


@dataclass(frozen=True)
class _Rollout(Options):
    """The identified robot, recordings that it was not fitted to, and what is asked of them."""

    robot_parameters: str = option(
        reads="robot's parameters", required=True, metavar="JSON", help="the --json of 'dynident identify'"
    )
    data: tuple[str, ...] = option(
        reads="held out",
        action="append",
        required=True,
        metavar="LOG",
        help="recording without payload that was not fitted; repeatable",
    )
    against: tuple[str, ...] = option(
        reads="other model",
        action="append",
        default=[],
        metavar="F.xml",
        help="another model of the arm, MJCF or URDF, moved by MuJoCo; repeatable",
    )
    horizons: tuple[float, ...] | None = option(
        type=seconds_list, metavar="S1,S2,..", help="times after the start [s] (default: 0.1,0.5,1,2)"
    )

    def models(self, robot: model.Robot) -> dict[str, rollout.Arm]:
        """The other models by the names of their files."""
        models: dict[str, rollout.Arm] = {}
        for path in self.against:
            arm = rollout.MujocoArm(path, robot)
            if arm.name in models:
                raise InputError(f"{path}: two models are called {arm.name}: rename a file")
            models[arm.name] = arm
        return models


def run(arm: RobotOptions, request: _Rollout, processing: FilterOptions, files: PageOptions) -> int:
    """Run it."""
    stored = results.read_stored_robot(request.robot_parameters)
    setup = processing.setup(arm.load(), stored)
    recordings = setup.read(request.data)
    with status("reading") as progress:
        rollouts = rollout.roll_out_all(
            setup.robot,
            stored.possible_values,
            recordings,
            setup.processing,
            request.horizons or rollout.HORIZONS,
            request.models(setup.robot),
            progress,
        )
    files.show(report.rollout_screen(rollouts))
    files.write_json(lambda: report.documents.rollouts_document(setup.robot.name, rollouts))
    title = setup.robot.title or setup.robot.name
    files.write_page(
        lambda: report.rollout_page(rollouts, title, files.provenance(setup.in_words(), request, arm, processing))
    )
    return ANSWERED
