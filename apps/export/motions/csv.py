"""Samples as CSV: time, positions, speeds and accelerations."""

from ...recordings import csv_text
from ..format import Format
from ..motion import DIGITS, WrittenMotion


def _write(motion: WrittenMotion) -> str:
    samples = motion.sampled()
    return csv_text(samples.t, {"q": samples.q, "qd": samples.qd, "qdd": samples.qdd}, f"%.{DIGITS}f")


FORMAT = Format(
    title="CSV",
    source="the columns' names",
    write=_write,
    remarks=("Columns: t [s], positions [rad or m], speeds, accelerations.",),
)
