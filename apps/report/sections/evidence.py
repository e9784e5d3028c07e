"""Sections that show what an answer rests on: torques, joints, excitation, essential parameters."""

from collections.abc import Mapping, Sequence

from ....common.schema import present
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.estimate import Fit
from ....estimation.fit.least_squares import Excitation
from ....estimation.results.parts import EliminationDocument, ResidualDocument
from ....estimation.results.payload import JointsMassDocument, array
from ...numbers import percent, with_interval
from ..blocks import Block, Cell, Details, Notes, Section, Table, Text, columns, with_sigma
from ..figures.parameters import essential_figure, excitation_figure
from ..figures.payload import joints_figure
from ..figures.signals import prediction_figure, words_of, worst_joint_figure


def residual_text(fit: Fit | ResidualDocument) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = " ".join(f"{100.0 * value:.1f}" for value in array(fit.relative_per_joint, 0))
    return f"{100.0 * float(array(fit.relative)):.2f} % (joints {joints} %)"


def worst_torque(predictions: Sequence[TorquePrediction]) -> list[Block]:
    """The worst joint's torque, for the first page: held out before fitted, with payload before without."""
    shown = min(predictions, key=lambda each: (not each.held_out, not each.loaded), default=None)
    return [Text("The worst joint", "heading"), worst_joint_figure(shown)] if shown else []


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


def by_joints_table(masses: Sequence[JointsMassDocument]) -> Table:
    """The mass by groups of joints with intervals, and each joint's share of the payload that the others show."""
    rows: list[tuple[Cell, ...]] = []
    for group in masses:
        mass: tuple[str, str] = ("not visible", "-")
        if group.mass is not None:
            mass = with_interval(group.mass, *array(group.interval95, 2).tolist())
        share = present(group.share)
        ratio: Cell = "-" if share is None else with_sigma(share, float(array(group.share_sigma)))
        rows.append((group.name, "kg", *mass, ratio))
    title = "The mass as each joint sees it, and its torque over what the other joints' payload demands"
    return Table(title, columns(("", "unit"), ("mass", "95 % interval", "share")), rows, style="tight")


def joints_section(
    masses: Sequence[JointsMassDocument], mass: float, interval: tuple[float, float], mounting: int | None = None
) -> Section:
    """Mass by groups of joints, and each joint's share, beside the mass by all of them.

    Args:
        masses: by some joints.
        mass: by all [kg].
        interval: its 95 % interval [kg]; nan where there is none.
        mounting: number of a known weight, where there are such.
    """
    words = (
        "Each joint weighs the payload with its own torque: where they differ, a drive gain, a friction model or "
        "the robot's description is wrong."
    )
    number = "" if mounting is None else f"_{mounting}"
    drawn = joints_figure(masses, mass, interval, f"by_joints{number}")
    blocks: list[Block] = [Text(words), by_joints_table(masses), *([drawn] if drawn else [])]
    return Section(f"joints{number}", "The payload as each joint sees it", blocks)


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


def elimination_notes(elimination: EliminationDocument | None, prefix: str = "") -> list[str]:
    """Lines on essential parameters; none where nothing was eliminated."""
    if elimination is None:
        return []
    line = (
        f"{prefix}{elimination.essential} of {len(elimination.path) - 1} parameters essential "
        f"({elimination.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative "
        f"sigma {elimination.largest_relative_sigma_percent:.3g} %."
    )
    return [line, *(f"  - {warning}" for warning in elimination.warnings)]


def essential_section(elimination: EliminationDocument | None, title: str) -> Section:
    """The path as a figure, the parameters by name, and what speaks against them."""
    heading = "Essential parameters"
    if elimination is None:
        words = "Parameters are eliminated for method 4 only, robot and payload together; it was not used here."
        return Section("essential", heading, [Text(words)])
    names = ", ".join(str(parameter.name) for parameter in elimination.parameters)
    blocks: list[Block] = [
        Text(elimination_notes(elimination)[0]),
        Text(f"Essential: {names}."),
        Notes(elimination.warnings),
        essential_figure(elimination, title),
    ]
    return Section("essential", heading, blocks)
