"""Drive gains: what the terminal prints, and the report."""

from ....estimation.answers.gains import DriveGains
from ..blocks import Banner, Block, Notes, Page, Screen, Table, columns
from ..provenance import Provenance, report_page
from .evidence import joints_section, torques_section
from .verdict import MEND, VERDICTS, reason_blocks, reason_lines, verdict_notes


def gains_screen(gains: DriveGains, document: str | None = None) -> Screen:
    """The verdict, one row a joint, the next command; then what it rests on.

    ``document``: the JSON file that was written, if any.
    """
    verdict, words = gains.verdict, VERDICTS[gains.verdict.level].words
    ask = "" if document else "add --json gains.json, then "
    after = f"Next: {ask}give --drive-gains {document or 'gains.json'} to 'dynident payload'."
    first: list[Block] = [
        Notes([f"Verdict: {'use every gain' if verdict.level == 'use' else words}."]),
        Notes(reason_lines(verdict), optional=True),
        gains_table(gains),
        Notes([after if verdict.level != "do_not_use" else MEND]),
        Notes(verdict_notes(verdict), optional=True),
    ]
    return Screen(first, [Notes(_notes(gains))], "the payload, residuals, where sigma comes from")


def gains_table(gains: DriveGains) -> Table:
    """Gains with standard deviations, what of the current is left unexplained, and what each rests on."""
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
    return Table(f"Drive gains of {gains.robot.name}", headings, rows, style="tight")


def gains_page(gains: DriveGains, provenance: Provenance) -> Page:
    """Verdict and gains first, then the weight as each joint sees it, and the torques that the gains give."""
    verdict, level = gains.verdict, gains.verdict.level
    sentence = "Every gain can be used." if level == "use" else VERDICTS[level].sentence
    why = [*reason_blocks(verdict), Notes(verdict_notes(verdict))]
    lead: list[Block] = [Banner(level, sentence), gains_table(gains), *why]
    # Of recordings that were not looked at joint by joint there is none.
    mounted = zip(gains.mountings.names, gains.loads, gains.by_joints, strict=True) if gains.by_joints else ()
    weights = [
        joints_section(by_joints, load.mass, (load.mass, load.mass), name)._replace(
            title=f"The known weight as each joint sees it{_mounted(gains, name)}"
        )
        for name, load, by_joints in mounted
    ]
    sections = (*weights, torques_section(gains.predictions))
    subtitle = f"Identified from recordings of motor currents with a known weight, {provenance.day}"
    title = f"Drive gains of the {gains.robot.title or gains.robot.name}"
    return report_page(title, subtitle, lead, sections, _notes(gains), provenance)


def _mounted(gains: DriveGains, name: int) -> str:
    return f", mounting {name}" if len(gains.loads) > 1 else ""


def _notes(gains: DriveGains) -> list[str]:
    lines = []
    for name, load, body in zip(gains.mountings.names, gains.loads, gains.payloads, strict=True):
        com = " ".join(f"{x:.4f}" for x in body.com)
        lines.append(
            f"Payload{_mounted(gains, name)}: {load.mass:.4g} kg as given (sigma {load.mass_sigma:.2g} kg), centre "
            f"of mass {com} m, {'as given' if load.com is not None else 'estimated'}."
        )
    lines += [
        "Every gain goes with the mass as given: 1 % of it is 1 % of each, which no recording shows"
        + (" unless weights differ." if len(gains.loads) > 1 else "."),
        f"Relative residual of the currents: {100 * gains.fit.relative:.2f} %.",
        "Without the constraint that robot and payload can exist: "
        + " ".join(f"{value:.3f}" for value in gains.free_values)
        + ".",
    ]
    if gains.disagreement > 1.0:
        lines.append(
            f"Every sigma is {gains.disagreement:.2g} times as large as errors alone make it: joints disagree."
        )
    if gains.robust is None:
        return [*lines, f"sigma by the formula for white noise alone: {gains.without_robust}"]
    lines.append(
        f"sigma: the larger of the formula's and that of a jackknife over {gains.robust.blocks} blocks of "
        f"{gains.robust.block_length:.2g} s or more."
    )
    return [*lines, *([gains.robust.warning] if gains.robust.warning else [])]
