"""``dynident compare``: recordings of one robot without payload, side by side."""

from __future__ import annotations

from dataclasses import dataclass

from ... import estimation
from ...common.files import checksum
from .. import fleet, report
from . import ANSWERED
from .options import Options, ProcessingOptions, ResultOptions, RobotOptions, option, recipe_of
from .progress import bar


@dataclass(frozen=True)
class _Logs(Options):
    """Recordings of one robot."""

    logs: tuple[str, ...] = option(
        "logs", reads="without payload", nargs="+", metavar="LOG", help="recordings of one robot without payload"
    )


def run(arm: RobotOptions, request: _Logs, processing: ProcessingOptions, files: ResultOptions) -> int:
    """Run it."""
    setup = processing.setup(arm.load())
    recipe, passports = recipe_of("identify", setup, setup.identified), []
    with bar("identifying") as progress:
        for k, path in enumerate(request.logs, 1):
            result = estimation.identify(setup.robot, setup.read([path]), setup.processing, gains=recipe.gains)
            log = fleet.Log("without payload", path, checksum(path))
            passports.append(fleet.robot_passport(result, recipe, [log]))
            progress(k / len(request.logs))
    compared = fleet.compared(passports)
    files.show(report.compared_screen(compared))
    files.write_json(lambda: report.documents.compared_document(compared))
    return ANSWERED
