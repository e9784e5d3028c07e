"""The report of a payload."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...estimation import PayloadAnswer
from ...estimation.files import StoredPayload
from ...estimation.payload import Excitation, TorquePrediction
from ..controllers.payload_file import is_flange
from ..figures import Drawing, flange_figure, worst_joint_figure
from ..tables import data_notes
from .centre import centre_section
from .consistency import consistency_section
from .controller import controller_block
from .data import data_section
from .essential import essential_section
from .excitation import excitation_section
from .joints import joints_section
from .markup import Html, joined, paragraph, tag
from .methods import methods_section
from .page import Page, Section
from .provenance import Provenance, files_table, foot
from .svg import figure_html
from .torques import shown, torques_section
from .verdict import agreement, improvements, pair, quantities_table, reasons, verdict_of


def payload_page(
    answer: PayloadAnswer,
    document: StoredPayload,
    predictions: Sequence[TorquePrediction],
    excited: Excitation | None,
    provenance: Provenance,
    warnings: Sequence[str] = (),
    others: int = 0,
    extra: Sequence[Section] = (),
    origin: str = "Identified from recordings of joint positions and torques",
) -> Page:
    """First page for the one who types the number in, the rest for the one who asks why.

    Args:
        answer: the payload.
        document: the same as ``payload_document`` gives it.
        predictions: recordings to draw, held out or not.
        excited: of robot and payload together.
        provenance: command, files, date.
        warnings: what speaks against the essential parameters.
        others: number of recordings that are not drawn.
        extra: sections to stand behind the payload's.
        origin: what kind of data it is, below the title.
    """
    robot = answer.problem.robot
    title = robot.title or robot.name
    labels = dict(zip(answer.problem.base.columns, answer.problem.base.names, strict=True))
    first = _First.of(answer, predictions)
    sections = (
        centre_section(answer),
        consistency_section(answer),
        methods_section(answer),
        joints_section(answer),
        *extra,
        torques_section(predictions, others),
        excitation_section(excited, labels),
        essential_section(answer.elimination, warnings, title, labels),
        data_section(data_notes(answer), provenance),
    )
    block = controller_block(document, "this report", title)
    head = joined(
        tag("h1", f"Payload on the {title}"),
        paragraph(f"{origin}, {provenance.day}", class_="sub"),
        first.html(answer, predictions, block),
        files_table(provenance),
    )
    return Page(f"Payload on the {title}", head, sections, foot(provenance), first.drawings)


class _First(NamedTuple):
    """Figures of the first page; ``worst`` only where there is a recording to draw."""

    flange: Drawing
    worst: Drawing | None

    @staticmethod
    def of(answer: PayloadAnswer, predictions: Sequence[TorquePrediction]) -> _First:
        best, prediction = answer.recommended, shown(predictions)
        flange = flange_figure(best, answer.verdict.level == "use", is_flange(best.frame))
        return _First(flange, worst_joint_figure(prediction) if prediction else None)

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        return (self.flange,) if self.worst is None else (self.flange, self.worst)

    def html(self, answer: PayloadAnswer, predictions: Sequence[TorquePrediction], block: Html) -> Html:
        worst = joined(tag("h3", "The worst joint"), figure_html(self.worst)) if self.worst else Html()
        why = joined(tag("h3", "Reasons for the verdict"), reasons(answer.verdict))
        how = joined(tag("h3", "How to improve it"), improvements(answer, predictions))
        what = joined(tag("h3", "What to type into the controller"), block)
        return joined(
            verdict_of(answer.verdict),
            pair(joined(quantities_table(answer), agreement(answer), why), figure_html(self.flange)),
            pair(what, joined(worst, how)),
        )
