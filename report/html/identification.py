"""The report of a robot's own parameters."""

from __future__ import annotations

from collections.abc import Sequence

from ...estimation import Identification
from ...estimation.diagnosis import robot_verdict
from ...estimation.payload import Excitation, TorquePrediction
from ...estimation.possible import PossibleRobot, PriorRobot
from ..figures import worst_joint_figure
from ..numbers import percent
from ..robot_tables import constrained_notes, standard_table
from ..tables import robot_notes, robot_table
from .data import data_section
from .essential import essential_section
from .excitation import excitation_section
from .markup import Html, bullets, joined, paragraph, printed_table, table, tag
from .page import Page, Section
from .provenance import Provenance, files_table, foot
from .svg import figure_html
from .torques import shown, torques_section
from .verdict import verdict_box

_GOOD = "The model explains the torques: the parameters can be used."
_BAD = "Do not use these parameters: the model does not explain the torques."


def identification_page(
    result: Identification,
    constrained: PossibleRobot | None,
    predictions: Sequence[TorquePrediction],
    excited: Excitation,
    provenance: Provenance,
    warnings: Sequence[str] = (),
    others: int = 0,
) -> Page:
    """Verdict and residuals first, then parameters, torques and excitation; arguments as for ``payload_page``."""
    title = result.robot.title or result.robot.name
    labels = dict(zip(result.base.columns, result.base.names, strict=True))
    against = robot_verdict(result.estimate.fit).reasons
    first = shown(predictions)
    worst = worst_joint_figure(first) if first else None
    head = joined(
        tag("h1", f"Dynamic parameters of the {title}"),
        paragraph(f"Identified from recordings without payload, {provenance.day}", class_="sub"),
        verdict_box("do_not_use" if against else "use", _BAD if against else _GOOD),
        bullets(against),
        _summary(result),
        figure_html(worst) if worst else Html(),
        files_table(provenance),
    )
    sections = (
        robot_section(result, constrained),
        torques_section(predictions, others),
        excitation_section(excited, labels),
        essential_section(result.elimination, warnings, title, labels),
        data_section(robot_notes(result), provenance),
    )
    return Page(f"Dynamic parameters of the {title}", head, sections, foot(provenance), (worst,) if worst else ())


def robot_section(result: Identification, constrained: PossibleRobot | None) -> Section:
    """Base parameters with groupings and sigma, beside those of a robot that can exist."""
    tables = [printed_table(robot_table(result, constrained.values.tolist() if constrained else None))]
    if isinstance(constrained, PriorRobot):
        tables.append(printed_table(standard_table(constrained, result.robot.title or result.robot.name)))
    notes = constrained_notes(constrained) if constrained else []
    return Section("parameters", "Base parameters of the robot", joined(*tables, bullets(notes)))


def _summary(result: Identification) -> Html:
    raw, scaled = result.problem.condition_numbers()
    fits = [("data that were fitted", result.estimate.fit)]
    if result.validation is not None:
        fits.append(("recording held out", result.validation))
    rows = [
        (name, percent(fit.relative), *(percent(float(share)) for share in fit.relative_per_joint))
        for name, fit in fits
    ]
    joints = (f"joint {j}" for j in range(1, result.robot.n + 1))
    words = (
        f"{result.problem.equations} equations, {len(result.base.columns)} base parameters, "
        f"{len(result.essential)} of them essential; condition number {raw:.3g} (SI units, unweighted), "
        f"{scaled:.3g} with columns scaled."
    )
    return joined(paragraph(words), table("Relative residual", ("", "all", *joints), rows))
