"""Parts that several reports share: verdict, errors of the gains, torques, joints."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from msgspec import UnsetType

from ....common.schema import present
from ....estimation import Gains
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.estimate import Fit
from ....estimation.results.parts import ProcessingDocument, ResidualDocument, TermDocument, VerdictDocument
from ....estimation.results.payload import JointsMassDocument, PayloadData, array
from ....estimation.results.robot import RobotResult
from ...numbers import percent, with_interval
from ..blocks import Block, Notes, OnPage, Section, Table, Text, with_sigma
from ..figures.payload import joints_figure
from ..figures.signals import prediction_figure, words_of, worst_joint_figure

MEND = "Next: mend what the reasons name, record again, and look at the logs by 'dynident check'."
"""It follows an answer that is not to be used."""
VERDICTS = {
    "use": "use mass, centre of mass and inertia",
    "mass_and_com_only": "use mass and centre of mass",
    "identified_only": "use the gains that are identified",
    "do_not_use": "do not use",
}
"""Each level in words, after "Verdict:"."""


def reason_blocks(verdict: VerdictDocument) -> list[Block]:
    """The reasons for the verdict."""
    reasons = [f"  - {reason}" for reason in verdict.reasons]
    nothing = Notes(["No check found anything against the numbers."], optional=True)
    return [Text("Reasons for the verdict", heading=True), Notes(reasons, optional=True) if reasons else nothing]


def verdict_notes(verdict: VerdictDocument) -> list[str]:
    """The notes of a verdict."""
    return [f"Note: {text}." for text in present(verdict.notes) or ()]


def gain_error_notes(processing: ProcessingDocument, gains: Gains | None) -> list[str]:
    """Lines on the errors of the drive gains that intervals allow for, and on the gains themselves."""
    # Torque sensors on the link side have scales, motors have gains.
    scales = "scales of the torque sensors" if processing.torque_side == "link" else "drive gains"
    each = "motor" if processing.coulomb else "joint"
    if gains is None or not (gains.identified or any((*gains.per_joint, gains.common))):
        return [f"{scales.capitalize()} are taken as exact: no residual shows their errors."]
    if gains.identified:
        sigmas = np.sqrt(np.diag(gains.covariance(len(gains.identified))))
        percents = ", ".join(f"{100.0 * sigma:.2g}" for sigma in sigmas)
        line = f"Intervals include errors of the drive gains as they were identified: {percents} % per {each}."
    else:
        percents = ", ".join(f"{100.0 * sigma:g}" for sigma in gains.per_joint)
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        source = ", as is usual: nothing is said of them (--gain-sigma)" if gains.assumed else ""
        line = f"Intervals include errors of the {scales}: {percents} % per {each}{common}{source}."
    return [line, *gains.notes]


def friction_notes(terms: Sequence[TermDocument], values: Mapping[str, str] = MappingProxyType({})) -> list[str]:
    """Line on the friction beside Coulomb and viscous: what it is, and by how much it lowers the error."""
    falls = {
        term.name: f"({100.0 * float(array(term.fall)):.0f} ± {100.0 * float(array(term.error)):.0f} %)"
        for term in terms
        if term.kept
    }
    if falls or values:
        parts = (" ".join((name, *filter(None, (values.get(name), falls.get(name))))) for name in falls or values)
        why = "; by so much a joint's squared error falls on blocks of time that were held out" if falls else ""
        return [f"Friction beside Coulomb and viscous: {', '.join(parts)}{why} (--friction)."]
    untried = [term for term in terms if term.fall is None or not np.isfinite(array(term.fall))]
    return [f"Friction by load or root of speed was not tried: {present(untried[0].why_not)}."] if untried else []


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
            "Residual: measured less predicted torque. A residual that repeats or lasts, seen in the "
            "autocorrelation, is an error of the model; white noise would stay within the dashed lines."
        )
        if not any(prediction.held_out for prediction in shown):
            fitted = "these are the data that were fitted, and look better than others would"
            text += f" No recording was held out (--validate): {fitted}."
        if recordings > len(shown):
            text += f" {recordings - len(shown)} more recordings were used and are not drawn."
        rows = [(words_of(each), *(percent(float(ratio)) for ratio in each.relative_per_joint)) for each in shown]
        joints = [f"joint {j}" for j in range(1, len(shown[0].t) + 1)] if shown else []
        headings = ("norm of the residual over norm of the torque", *joints)
        drawings = [prediction_figure(each, f"torques_{k}") for k, each in enumerate(shown, 1)]
        return [Text(text), Table("Relative residual", headings, rows), *drawings]

    return Section("torques", "Measured and predicted torques", [OnPage(drawn)])


def joints_section(
    masses: Sequence[JointsMassDocument], mass: float, interval: tuple[float, float], mounting: int | None = None
) -> Section:
    """Mass [kg] by groups of joints and each joint's share; ``mounting``: number of a known weight, if any."""
    rows = []
    for group in masses:
        cells: tuple[str, str] = ("not visible", "-")
        if group.mass is not None:
            cells = with_interval(group.mass, *array(group.interval95, 2).tolist())
        share = present(group.share)
        ratio = "-" if share is None else with_sigma(share, float(array(group.share_sigma)))
        rows.append((group.name, "kg", *cells, ratio))
    text = (
        "Each joint weighs the payload with its own torque: where they differ, a drive gain, a friction model or "
        "the robot's description is wrong. Share: its torque over what the other joints' payload demands."
    )
    number = "" if mounting is None else f"_{mounting}"
    headings = ("", "unit", "mass", "95 % interval", "share")
    drawn = joints_figure(masses, mass, interval, f"by_joints{number}")
    blocks: list[Block] = [Text(text), Table("Mass by joints", headings, rows), *drawn]
    return Section(f"joints{number}", "The payload as each joint sees it", blocks)
