"""``dynident rollout``: how far the identified robot's motion strays from a recording's."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from .. import report, results, rollout
from . import ANSWERED
from .entry import Options, command
from .options import FilterOptions, PageOptions, RobotOptions
from .progress import status
from .values import HeldOutFile, Reads, RobotParametersFile, different, numbers, where, word

_Model = Annotated[str, Reads("other model"), Parameter(metavar="F.xml")]
_seconds = where(
    numbers,
    lambda times: min(times) > 0.0 and different(times),
    "a list of different times in seconds such as 0.1,0.5,1",
)


class _Rollout(Options):
    """The identified robot, recordings that it was not fitted to, and what is asked of them."""

    robot_parameters: RobotParametersFile
    """The --json of 'dynident identify'."""
    data: tuple[HeldOutFile, ...]
    """Recording without payload that was not fitted; repeatable."""
    against: tuple[_Model, ...] = ()
    """Another model of the arm, MJCF or URDF, moved by MuJoCo; repeatable."""
    horizons: Annotated[tuple[float, ...] | None, word(_seconds, "S1,S2,..")] = None
    """Times after the start [s] (default: 0.1,0.5,1,2)."""


@command
def run(*, arm: RobotOptions, request: _Rollout, processing: FilterOptions, files: PageOptions) -> int:
    """Run it."""
    stored = results.read_stored_robot(request.robot_parameters)
    setup = processing.setup(arm.load(), stored)
    recordings, values = setup.read(request.data), stored.possible_values
    models: dict[str, rollout.Arm] = {}
    for path in request.against:
        model = rollout.MujocoArm(path, setup.robot)
        if model.name in models:
            raise InputError(f"{path}: two models are called {model.name}: rename a file")
        models[model.name] = model
    with status("reading") as progress:
        rollouts = rollout.roll_out_all(
            setup.robot,
            values,
            recordings,
            estimation.Settings(setup.processing, progress=progress),
            request.horizons or rollout.HORIZONS,
            models,
        )
    shown = report.rollout_report(rollouts, setup.robot.title or setup.robot.name)
    files.give(shown, lambda: report.documents.rollouts_document(setup.robot.name, rollouts), setup.in_words())
    return ANSWERED
