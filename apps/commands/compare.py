"""``dynident compare``: recordings of one robot without payload, side by side."""

from __future__ import annotations

from dataclasses import dataclass

from ... import estimation
from ...common.errors import InputError
from ...common.files import checksum
from .. import fleet, report
from . import ANSWERED
from .options import Options, ProcessingOptions, ResultOptions, RobotOptions, option
from .progress import bar


@dataclass(frozen=True)
class _Logs(Options):
    """Recordings of one robot."""

    logs: tuple[str, ...] = option(
        "logs", reads="without payload", nargs="+", metavar="LOG", help="recordings of one robot without payload"
    )

    def check(self) -> None:
        """Refuse a single recording, and one that is given twice."""
        if len(self.logs) < 2:
            raise InputError("one recording: give two or more to compare")
        first = dict[str, str]()
        for path in self.logs:
            if first.setdefault(checksum(path), path) != path or self.logs.count(path) > 1:
                raise InputError(f"{path} is given twice: a recording counts once")


def run(arm: RobotOptions, request: _Logs, processing: ProcessingOptions, files: ResultOptions) -> int:
    """Run it."""
    request.check()
    setup = processing.setup(arm.load())
    results, settings = [], estimation.Settings(setup.processing)
    with bar("identifying") as progress:
        for k, path in enumerate(request.logs, 1):
            result = estimation.identify(setup.robot, setup.read([path]), settings, gains=setup.identified)
            results.append(result)
            progress(k / len(request.logs))
    compared = fleet.compared(request.logs, results)
    files.show(report.compared_screen(compared))
    files.write_json(lambda: report.documents.ComparedDocument.of(compared))
    return ANSWERED
