"""What ``payload`` and ``weigh`` share: recordings compared with some without payload, and the answer's files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from ... import estimation
from ...common.errors import InputError
from .. import report, results
from .options import PageOptions, Setup


class Compared(Protocol):
    """What a command's own options name to compare with."""

    @property
    def unloaded(self) -> tuple[str, ...]:
        """Recordings without payload."""

    @property
    def robot_parameters(self) -> str | None:
        """The ``--json`` of an earlier ``identify``."""


def check_compared(request: Compared) -> None:
    """Refuse recordings with a payload that nothing stands beside."""
    if not request.unloaded and not request.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")


def stored_robot(request: Compared) -> results.StoredRobot | None:
    """The robot of an earlier run, where one is named."""
    return results.read_stored_robot(request.robot_parameters) if request.robot_parameters else None


@contextmanager
def constraints_solved() -> Iterator[None]:
    """Constraints that leave no body are the user's to mend.

    Raises:
        InputError: where the solver finds none.
    """
    try:
        yield
    except estimation.SolverError as error:
        raise InputError(str(error)) from None


def show_payload(
    answer: estimation.PayloadAnswer,
    setup: Setup,
    files: PageOptions,
    page: Callable[[results.StoredPayload], report.Page],
    measured: bool = False,
) -> None:
    """Print the answer, write its document and its page.

    Args:
        page: makes the report of the document; called only where it is asked for.
        measured: whether an inertia that was to be assumed is measured.
    """
    files.show(report.payload_screen(answer, files.document, measured))
    document = report.documents.payload_document(answer, setup.processing, setup.gains)
    files.write_json(lambda: document)
    files.write_page(lambda: page(document))
