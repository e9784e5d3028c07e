"""Drive gains, and what their errors do to other answers."""

import numpy as np

from ...estimation import Gains
from ...estimation.gains import DriveGains
from ...model import Robot
from ..blocks import Block, Notes, Table, columns


def gains_screen(gains: DriveGains) -> list[Block]:
    """One row a joint, and the lines below."""
    headings = columns(("motor",), ("N·m/A", "sigma", "%", "residual %"), ("rests on",))
    sigma = gains.larger_relative_sigma
    rows = [
        (
            str(j + 1),
            f"{gains.values[j]:.3f}",
            f"{gains.values[j] * sigma[j]:.2g}",
            f"{100 * sigma[j]:.2g}",
            f"{100 * gains.fit.relative_per_joint[j]:.1f}",
            words,
        )
        for j, words in enumerate(gains.identifiability)
    ]
    return [Table(f"Drive gains of {gains.robot}", headings, rows, style="roomy"), Notes(_notes(gains))]


def _notes(gains: DriveGains) -> list[str]:
    com = gains.payload.com
    given = not gains.load.free or "MX_L" in gains.load.known
    lines = [
        f"Payload: {gains.load.mass:.4g} kg as given (sigma {gains.load.mass_sigma:.2g} kg), centre of mass "
        f"{com[0]:.4f} {com[1]:.4f} {com[2]:.4f} m" + (" as given." if given else ", estimated."),
        f"Relative residual of the currents: {100 * gains.fit.relative:.2f} %.",
        "Without the constraint that robot and payload can exist: "
        + " ".join(f"{value:.3f}" for value in gains.free_values)
        + ".",
    ]
    if gains.robust is None:
        return [*lines, f"sigma by the formula for white noise alone: {gains.without_robust}"]
    lines.append(
        f"sigma: the larger of the formula's and that of a jackknife over {gains.robust.blocks} blocks of "
        f"{gains.robust.block_length:.2g} s or more."
    )
    return [*lines, *([gains.robust.warning] if gains.robust.warning else [])]


def scales_in_words(robot: Robot) -> str:
    """What a robot's torques are to scale by: torque sensors on the link side have scales, motors have gains."""
    return "scales of the torque sensors" if robot.drives.side == "link" else "drive gains"


def gain_error_notes(robot: Robot, gains: Gains | None, what: str = "Intervals") -> list[str]:
    """What ``what`` hold of the gains' errors, and what else there is to know of them."""
    scales, each = scales_in_words(robot), "motor" if robot.coupling else "joint"
    if gains is None:
        return [f"{scales.capitalize()} are taken as exact: --gain-sigma 2% adds what no residual shows."]
    if gains.identified:
        sigmas = np.sqrt(np.diag(gains.covariance(len(gains.identified))))
        percents = ", ".join(f"{100.0 * sigma:.2g}" for sigma in sigmas)
        line = f"{what} include errors of the drive gains as they were identified: {percents} % per {each}."
    else:
        percents = ", ".join(f"{100.0 * sigma:g}" for sigma in gains.per_joint)
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        line = f"{what} include errors of the {scales}: {percents} % per {each}{common}."
    return [line, *gains.notes]
