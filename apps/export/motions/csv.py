"""Samples as CSV: time, positions, speeds and accelerations."""

from functools import partial

from ...recordings import csv_text
from ..format import Format
from ..motion import DIGITS, WrittenMotion


@partial(
    Format,
    title="CSV",
    source="the columns' names",
    remarks=("Columns: t [s], positions [rad or m], speeds, accelerations.",),
)
def _write(motion: WrittenMotion) -> str:
    samples = motion.sampled()
    return csv_text(samples.t, {"q": samples.q, "qd": samples.qd, "qdd": samples.qdd}, f"%.{DIGITS}f")
