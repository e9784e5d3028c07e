"""Drive gains: the verdict, one row a joint, the next command; then what it rests on."""

import numpy as np

from ....common.schema import present
from ....estimation.results.payload import array, numbers
from ....estimation.results.robot import GainsResult, MountingDocument
from ..blocks import Notes, Report, Table, Text
from .evidence import (
    MEND,
    VERDICTS,
    jackknife,
    joints_section,
    reason_blocks,
    torques_section,
    verdict_notes,
    worst_torque,
)


def gains_report(gains: GainsResult, document: str | None = None) -> Report:
    """Gains with their verdict, the weight as each joint sees it, and the torques that the gains give.

    ``document``: the JSON file that was written, if any.
    """
    level, made, mounted = gains.judged.level, gains.working, bool(gains.load and gains.load.mountings)
    ask = "" if document or not made else "add --json gains.json, then "
    after = f"Next: {ask}give --drive-gains {document or 'gains.json'} to 'dynident payload'."
    drives, residual = gains.drive_gains, present(gains.relative_residual)
    sigma, n = np.sqrt(np.diag(drives.relative_covariance)), len(drives.values)
    unexplained = array(residual.relative_per_joint if residual else None, n)
    parts = zip(drives.values, sigma, unexplained, drives.rests_on or ("",) * n, strict=True)
    rows = [
        (str(j), f"{value:.3f}", f"{value * ratio:.2g}", f"{100 * ratio:.2g}", f"{100 * left:.1f}", word)
        for j, (value, ratio, left, word) in enumerate(parts, start=1)
    ]
    headings = ("motor", "N·m/A", "sigma", "%", "residual %", "rests on")
    first = [
        Text(f"Verdict: {'use every gain' if level == 'use' else VERDICTS[level]}.", level=level),
        Table(f"Drive gains of {gains.robot}", headings, rows),
        Notes([after if level != "do_not_use" else MEND]),
        *reason_blocks(gains.judged),
        Notes(verdict_notes(gains.judged), optional=True),
        worst_torque(lambda: made.predictions),
    ]
    sections = []
    of_joints = zip(made.mountings, made.loads, made.by_joints, strict=True) if made else ()
    for name, load, by_joints in of_joints:
        section = joints_section(by_joints.masses, load.mass, (load.mass, load.mass), name)
        title = f"The known weight as each joint sees it{f', mounting {name}' if mounted else ''}"
        sections.append(section._replace(title=title))
    sections.append(torques_section(lambda: made.predictions))
    title = f"Drive gains of the {gains.robot_title or gains.robot}"
    subtitle = "Identified from recordings of motor currents with a known weight"
    more = "the payload, residuals, origin of sigma"
    return Report(title, first, sections, more, subtitle, _notes(gains, mounted))


def _notes(gains: GainsResult, mounted: bool) -> list[str]:
    robust, residual, load = present(gains.robust), present(gains.relative_residual), gains.load
    lines = list[str]()
    if load:
        known, sigma = present(load.known) or {}, float(array(load.mass_sigma))
        mountings = load.mountings or (MountingDocument(1, present(load.identified) or {}),)
        for k, mounting in enumerate(mountings, start=1):
            number, ten = str(k) if k > 1 else "", numbers(mounting.identified)
            com = " ".join(f"{x:.4f}" for x in ten[6:9] / ten[9])
            lines.append(
                f"Payload{f', mounting {mounting.mounting}' if mounted else ''}: "
                f"{known.get(f'M_L{number}', np.nan):.4g} kg as given (sigma {sigma:.2g} kg), centre of mass {com} "
                f"m, {'as given' if f'MX_L{number}' in known else 'estimated'}."
            )
    unconstrained = " ".join(f"{value:.3f}" for value in array(gains.drive_gains.without_constraints, 0))
    lines += [
        "Every gain scales with the mass given: an error of 1 % in it is 1 % in each gain, and shows nowhere"
        + (" unless weights differ." if mounted else "."),
        f"Relative residual of the currents: {100 * array(residual.relative if residual else None):.2f} %.",
        f"Without the constraint that robot and payload can exist: {unconstrained}.",
    ]
    if (ratio := present(gains.disagreement) or 1.0) > 1.0:
        lines.append(f"Every sigma is {ratio:.2g} times larger because the joints disagree.")
    if robust is None or robust.blocks is None:
        return [*lines, f"sigma comes from the formula for white noise: {(robust and robust.unavailable) or ''}"]
    by = jackknife(robust.blocks, float(array(robust.block_length)))
    return [
        *lines,
        f"sigma: the larger of the formula's and that of a {by}.",
        *([robust.warning] if robust.warning else []),
    ]
