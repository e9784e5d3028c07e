"""Parts that several reports share: verdict, errors of the gains, torques, joints, and how well parameters show."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from msgspec import UnsetType

from ....common.schema import present
from ....estimation import Gains
from ....estimation.answers.system import TorquePrediction
from ....estimation.diagnosis.evidence import Verdict
from ....estimation.fit.estimate import Fit
from ....estimation.fit.linear_problem import Excitation
from ....estimation.fit.own_equations import TermChoice
from ....estimation.payload.by_joints import JointsMass
from ....estimation.results.parts import EliminationDocument, ProcessingDocument, ResidualDocument
from ....estimation.results.payload import PayloadData, array
from ....estimation.results.robot import RobotResult
from ...numbers import percent, with_interval
from ..blocks import Block, Notes, OnPage, Section, Table, Text, with_sigma
from ..figures.parameters import GOOD, elimination_figure, excitation_figure
from ..figures.payload import joints_figure
from ..figures.signals import prediction_figure, words_of, worst_joint_figure

MEND = "Next: fix what the reasons name, run 'dynident check' on the logs, and record again."
"""It follows an answer that is not to be used."""
VERDICTS = {
    "use": "use mass, centre of mass and inertia",
    "mass_and_com_only": "use mass and centre of mass, not the inertia",
    "identified_only": "use only the gains that were identified",
    "do_not_use": "do not use these numbers",
}
"""Each level in words, after "Verdict:"."""


def reason_blocks(verdict: Verdict) -> list[Block]:
    """The reasons for the verdict."""
    reasons = [f"  - {reason}" for reason in verdict.reasons]
    nothing = Notes(["All checks passed."], optional=True)
    return [Text("Reasons for the verdict", heading=True), Notes(reasons, optional=True) if reasons else nothing]


def verdict_notes(verdict: Verdict) -> list[str]:
    """The notes of a verdict."""
    return [f"Note: {text}." for text in verdict.notes]


def gain_error_notes(processing: ProcessingDocument, gains: Gains | None) -> list[str]:
    """Lines on the errors of the drive gains that intervals allow for, and on the gains themselves."""
    # Torque sensors on the link side have scales, motors have gains.
    scales = "scales of the torque sensors" if processing.torque_side == "link" else "drive gains"
    each = "motor" if processing.coulomb else "joint"
    if gains is None or not (gains.identified or any((*gains.per_joint, gains.common))):
        return [f"{scales.capitalize()} are taken as exact; errors in them would not show in any residual."]
    if gains.identified:
        sigmas = np.sqrt(np.diag(gains.covariance(len(gains.identified))))
        percents = ", ".join(f"{100.0 * sigma:.2g}" for sigma in sigmas)
        line = f"The intervals allow for the errors of the identified drive gains: {percents} % per {each}."
    else:
        percents = ", ".join(f"{100.0 * sigma:g}" for sigma in gains.per_joint)
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        source = ", the default (--gain-sigma changes it)" if gains.assumed else ""
        line = f"The intervals allow for errors of the {scales}: {percents} % per {each}{common}{source}."
    return [line, *gains.notes]


def friction_notes(terms: Sequence[TermChoice]) -> list[str]:
    """Line on friction beside Coulomb and viscous and by how much it lowers the error, or why none was tried."""
    kept = [
        f"{term.name} ({100.0 * term.fall:.0f} ± {100.0 * term.error:.0f} %)"
        for term in terms
        if term.kept and term.fall is not None and term.error is not None
    ]
    if kept:
        falls = "in brackets, how much each lowers the squared error on held-out data (--friction)"
        return [f"Friction terms beyond Coulomb and viscous: {', '.join(kept)}; {falls}."]
    untried = [term for term in terms if term.fall is None]
    return (
        [f"Load-dependent and root-of-speed friction were not tried: {present(untried[0].why_not)}."]
        if untried
        else []
    )


def jackknife(blocks: int, length: float) -> str:
    """Say by which blocks of time, of a length [s], robust standard deviations were found."""
    return f"jackknife over {blocks} blocks of {length:.2g} s or more"


def residual_text(fit: Fit | ResidualDocument) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = " ".join(f"{100.0 * value:.1f}" for value in array(fit.relative_per_joint, 0))
    return f"{100.0 * float(array(fit.relative)):.2f} % (joints {joints} %)"


def conditioning(equations: int | UnsetType, parameters: int | UnsetType, of: PayloadData | RobotResult) -> str:
    """Number of equations and parameters, and the condition number."""
    raw, scaled = array(of.condition_number), array(of.condition_number_scaled)
    size = f"{equations} equations{f', {parameters} parameters' if present(parameters) else ''}"
    return f"{size}; condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled."


Predictions = Callable[[], Sequence[TorquePrediction]]
"""Recordings to draw, computed when a page asks for them."""


def worst_torque(predictions: Predictions) -> OnPage:
    """The worst joint's torque, for the first page: held out before fitted, with payload before without."""

    def drawn() -> list[Block]:
        shown = min(predictions(), key=lambda each: (not each.held_out, not each.loaded), default=None)
        return [Text("The worst joint", heading=True), worst_joint_figure(shown)] if shown else []

    return OnPage(drawn)


def torques_section(predictions: Predictions, recordings: int = 0) -> Section:
    """Residuals of some recordings as a table, and a figure of each; ``recordings``: so many were used."""

    def drawn() -> list[Block]:
        shown = predictions()
        text = (
            "Residual: measured minus predicted torque. A residual that repeats or persists shows up in the "
            "autocorrelation and is an error of the model; white noise would stay within the dashed lines."
        )
        if not any(prediction.held_out for prediction in shown):
            text += (
                " No recording was held out (--validate), so this is the fit itself; new data would fit less well."
            )
        if recordings > len(shown):
            text += f" {recordings - len(shown)} more recordings were used but are not drawn."
        rows = [(words_of(each), *(percent(float(ratio)) for ratio in each.relative_per_joint)) for each in shown]
        joints = [f"joint {j}" for j in range(1, len(shown[0].t) + 1)] if shown else []
        headings = ("norm of the residual over norm of the torque", *joints)
        drawings = [prediction_figure(each, f"torques_{k}") for k, each in enumerate(shown, 1)]
        return [Text(text), Table("Relative residual", headings, rows), *drawings]

    return Section("torques", "Measured and predicted torques", [OnPage(drawn)])


def joints_section(
    masses: Sequence[JointsMass], mass: float, interval: tuple[float, float], mounting: int | None = None
) -> Section:
    """Mass [kg] by groups of joints and each joint's share; ``mounting``: number of a known weight, if any."""
    rows = []
    for group in masses:
        ends = array(group.interval95, 2).tolist()
        cells = ("not visible", "-") if group.mass is None else with_interval(group.mass, *ends)
        share = present(group.share)
        ratio = "-" if share is None else with_sigma(share, float(array(group.share_sigma)))
        rows.append((group.name, "kg", *cells, ratio))
    text = (
        "Each joint weighs the payload with its own torque. Where they differ, a drive gain, the friction model or "
        "the robot's description is wrong. Ratio: the joint's payload torque over what the other joints predict."
    )
    number = "" if mounting is None else f"_{mounting}"
    headings = ("", "unit", "mass", "95 % interval", "ratio")
    drawn = joints_figure(masses, mass, interval, f"by_joints{number}")
    blocks: list[Block] = [Text(text), Table("Mass by joints", headings, rows), *drawn]
    return Section(f"joints{number}", "The payload as each joint sees it", blocks)


def excitation_section(make: Callable[[], Excitation | None], labels: Mapping[str, str]) -> Section:
    """A figure, and the numbers to be opened; ``labels`` are shown in the place of parameters' names."""

    def shown() -> list[Block]:
        excitation = make()
        if excitation is None:
            text = (
                "The robot's parameters were read from a file, without their equations. The report of that "
                "identification shows what its motion excited."
            )
            return [Text(text)]
        names, weak, rows = [labels.get(name, name) for name in excitation.names], list[str](), []
        columns = zip(names, excitation.signal, excitation.independent, excitation.share, strict=True)
        for name, signal, own, ratio in columns:
            relative = percent(1.0 / float(own) if own else float("inf"))
            rows.append((name, f"{signal:.3g}", f"{own:.3g}", percent(float(ratio)), relative))
            weak += [name] if own < GOOD else []
        text = (
            "A parameter is well determined where its torque is large compared with the noise and no combination "
            "of others can imitate it. Sigmas here are the formula's, for white noise; they are relative, so a "
            "small parameter has a large one."
        )
        known = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
        headings = ("", "torque over noise", "its own part", "share", "relative sigma")
        numbers = OnPage(lambda: [Table("Excitation", headings, rows)], "Numbers")
        return [Text(text), excitation_figure(excitation, names, known), numbers]

    return Section("excitation", "Excitation of each parameter", [OnPage(shown)])


def essential_section(elimination: EliminationDocument | None, title: str) -> Section:
    """The path of the elimination as a figure, the parameters by name, and what speaks against them."""
    heading = "Essential parameters"
    if elimination is None:
        text = "Parameters are eliminated in method 4 only, for robot and payload together; it was not used here."
        return Section("essential", heading, [OnPage(lambda: [Text(text)])])
    text = (
        f"{elimination.essential} of {len(elimination.path) - 1} parameters are essential "
        f"({elimination.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative sigma "
        f"{elimination.largest_relative_sigma_percent:.3g} %."
    )
    lines = [
        text,
        f"Essential: {', '.join(str(parameter.name) for parameter in elimination.parameters)}.",
        "Setting the others to zero biases these values, so the intervals above come from the full model.",
        *(f"  - {warning}" for warning in elimination.warnings),
    ]
    return Section("essential", heading, [Notes(lines), elimination_figure(elimination, title, text)])
