"""What an answer rests on: torques, joints, excitation, essential parameters."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ....estimation.answers.prediction import TorquePrediction
from ....estimation.fit.essential import Elimination
from ....estimation.fit.estimate import Fit
from ....estimation.fit.least_squares import Excitation
from ....estimation.payload.by_joints import ByJoints, JointShare, JointsMass
from ...numbers import percent, with_interval
from ..blocks import Block, Cell, Details, Drawing, Notes, Section, Spread, Table, Text, columns
from ..figures.parameters import essential_figure, excitation_figure
from ..figures.signals import prediction_figure, words_of, worst_joint_figure


def residual_text(fit: Fit) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = " ".join(f"{100.0 * value:.1f}" for value in fit.relative_per_joint)
    return f"{100.0 * fit.relative:.2f} % (joints {joints} %)"


def worst_joint(predictions: Sequence[TorquePrediction]) -> Drawing | None:
    """The figure of the first page: held out before fitted, with payload before without."""
    shown = min(predictions, key=lambda each: (not each.held_out, not each.loaded), default=None)
    return worst_joint_figure(shown) if shown else None


def torques_section(predictions: Sequence[TorquePrediction], others: int = 0) -> Section:
    """Residuals of every recording as a table, and a figure of each.

    Args:
        predictions: recordings to draw.
        others: number of recordings that were used and are not drawn.
    """
    joints = range(1, len(predictions[0].t) + 1) if predictions else ()
    rows = [
        (words_of(prediction), *(percent(float(share)) for share in prediction.relative_per_joint))
        for prediction in predictions
    ]
    words = (
        "Residual: measured less predicted torque. A residual that repeats or lasts, seen in the autocorrelation, "
        "is an error of the model; white noise would stay within the dashed lines."
    )
    if not any(prediction.held_out for prediction in predictions):
        words += (
            " No recording was held out (--validate): these are the data that were fitted, and look better than "
            "others would."
        )
    if others:
        words += f" {others} more recordings were used and are not drawn."
    headings = columns(("norm of the residual over norm of the torque",), [f"joint {j}" for j in joints])
    drawings = [prediction_figure(each, f"torques_{k}") for k, each in enumerate(predictions, 1)]
    blocks: list[Block] = [Text(words), Table("Relative residual", headings, rows), *drawings]
    return Section("torques", "Measured and predicted torques", blocks)


def by_joints_table(by_joints: ByJoints) -> Table:
    """The mass by groups of joints with intervals, and each joint's share of the payload that the others show."""
    rows: list[tuple[Cell, ...]] = []
    for group, share in _with_shares(by_joints):
        cells = ["not visible", "", ""]
        if group.mass is not None and group.interval95 is not None:
            cells = [f"{x:.4g}" for x in (group.mass, *group.interval95)]
        last = Spread(f"{share.share:.3f}", f"{share.sigma:.2g}") if share and share.share is not None else ""
        rows.append((group.name, "kg", *cells, last))
    title = "The mass as each joint sees it, and its torque over what the other joints' payload demands"
    return Table(title, columns(("", "unit"), ("mass", "95 %", "interval", "share")), rows)


def mass_by_joints_note(by_joints: ByJoints) -> str:
    """One line below the payload's tables."""
    visible = [group for group in by_joints.masses if group.mass is not None]
    hidden = ", ".join(group.name for group in by_joints.masses if group.mass is None)
    if not visible:
        return "Mass: no joint sees it alone."
    masses = ", ".join(f"{group.name} {group.mass:.4g} ± {group.sigma:.2g}" for group in visible)
    return f"Mass [kg] by the torques of {masses}" + (f"; not visible to {hidden}." if hidden else ".")


def joints_section(by_joints: ByJoints, drawings: Sequence[Block] = ()) -> Section:
    """Mass by groups of joints, and each joint's share; ``drawings``: its figure, unless it stands elsewhere."""
    rows = []
    for group, share in _with_shares(by_joints):
        mass = ("not visible", "-")
        if group.mass is not None and group.interval95 is not None:
            mass = with_interval(group.mass, *group.interval95)
        rows.append((group.name, *mass, _share(share)))
    headings = columns(("",), ("mass [kg]", "95 % interval", "share of the others' payload"))
    words = (
        "Each joint weighs the payload with its own torque: where they differ, a drive gain, a friction model or "
        "the robot's description is wrong."
    )
    blocks = [Text(words), Table("Mass by groups of joints", headings, rows), *drawings]
    return Section("joints", "The payload as each joint sees it", blocks)


def _with_shares(by_joints: ByJoints) -> Iterator[tuple[JointsMass, JointShare | None]]:
    """Each group of joints; a single joint with its share."""
    shares = {share.joint: share for share in by_joints.shares}
    for group in by_joints.masses:
        yield group, shares.get(group.joints[0]) if len(group.joints) == 1 else None


def _share(share: JointShare | None) -> str:
    if share is None or share.share is None:
        return "-"
    return f"{share.share:.2f} ± {share.sigma:.2f}" if np.isfinite(share.sigma) else f"{share.share:.2f}"


def excitation_section(excitation: Excitation | None, labels: Mapping[str, str]) -> Section:
    """A figure, and the numbers to be opened."""
    title = "Excitation of each parameter"
    if excitation is None:
        words = (
            "The robot's parameters were read from a file, without the equations they come from: what its motion "
            "excited stands in the report of that identification."
        )
        return Section("excitation", title, [Text(words)])
    numbers = zip(excitation.names, excitation.signal, excitation.independent, excitation.share, strict=True)
    rows = [
        (
            labels.get(name, name),
            f"{signal:.3g}",
            f"{independent:.3g}",
            percent(float(share)),
            percent(1.0 / float(independent) if independent else float("inf")),
        )
        for name, signal, independent, share in numbers
    ]
    headings = columns(("",), ("torque over noise", "its own part", "share", "relative sigma"))
    words = (
        "A parameter is well known where its torque is large against the noise and no combination of others "
        "imitates it. Sigmas here are the formula's, for white noise; a small value of a parameter makes them "
        "large too."
    )
    table = Details("Numbers", [Table("Excitation", headings, rows)])
    return Section("excitation", title, [Text(words), excitation_figure(excitation, labels), table])


def elimination_notes(elimination: Elimination | None, warnings: Sequence[str], prefix: str = "") -> list[str]:
    """Lines on essential parameters; none where nothing was eliminated."""
    if elimination is None:
        return []
    line = (
        f"{prefix}{len(elimination.essential)} of {len(elimination.path.order)} parameters essential "
        f"({elimination.rule.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative "
        f"sigma {100.0 * elimination.largest_relative_sigma:.3g} %."
    )
    return [line, *(f"  - {warning}" for warning in warnings)]


def essential_section(
    elimination: Elimination | None, warnings: Sequence[str], title: str, labels: Mapping[str, str]
) -> Section:
    """The path as a figure, the parameters by name, and what speaks against them.

    Args:
        elimination: None where nothing was eliminated.
        warnings: what speaks against the essential parameters.
        labels: name of a parameter -> how it is called.
    """
    heading = "Essential parameters"
    if elimination is None:
        words = "Parameters are eliminated for method 4 only, robot and payload together; it was not used here."
        return Section("essential", heading, [Text(words)])
    names = ", ".join(labels.get(name, name) for name in elimination.essential)
    blocks: list[Block] = [
        Text(elimination_notes(elimination, ())[0]),
        Text(f"Essential: {names}."),
        Notes(warnings),
        essential_figure(elimination, title, labels),
    ]
    return Section("essential", heading, blocks)
