"""``dynident compare``: recordings of one robot without payload, side by side."""

from __future__ import annotations

from ... import estimation
from ...common.errors import InputError
from ...common.files import checksum
from .. import fleet, report
from . import ANSWERED
from .entry import command
from .options import ProcessingOptions, ResultOptions, RobotOptions
from .progress import bar
from .values import DataFile


@command
def run(
    data: tuple[DataFile, ...], *, arm: RobotOptions, processing: ProcessingOptions, files: ResultOptions
) -> int:
    """Run it.

    Args:
        data: Recordings of one robot without payload.
    """
    if len(data) < 2:
        raise InputError("one recording: give two or more to compare")
    first = dict[str, str]()
    for path in data:
        if first.setdefault(checksum(path), path) != path or data.count(path) > 1:
            raise InputError(f"{path} is given twice: a recording counts once")
    setup = processing.setup(arm.load())
    results, settings = [], estimation.Settings(setup.processing)
    with bar("identifying") as progress:
        for k, path in enumerate(data, 1):
            result = estimation.identify(setup.robot, setup.read([path]), settings, gains=setup.identified)
            results.append(result)
            progress(k / len(data))
    compared = fleet.compared(data, results)
    files.show(report.compared_report(compared))
    files.write_json(lambda: report.documents.ComparedDocument.of(compared))
    return ANSWERED
