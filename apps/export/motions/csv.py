"""Samples as CSV: time, positions, speeds and accelerations."""

import io

import numpy as np

from ..format import Format
from ..motion import DIGITS, WrittenMotion, motion_head


def _write(motion: WrittenMotion) -> str:
    samples, n = motion.sampled(), motion.robot.n
    header = ["t", *(f"{kind}{j}" for kind in ("q", "qd", "qdd") for j in range(1, n + 1))]
    table = np.column_stack([samples.t, samples.q, samples.qd, samples.qdd])
    text = io.StringIO()
    np.savetxt(text, table, delimiter=",", header=",".join(header), comments="", fmt=f"%.{DIGITS}f")
    return text.getvalue()


FORMAT = Format(
    title="CSV",
    source="the columns' names",
    head=motion_head,
    write=_write,
    remarks=("Columns: t [s], positions [rad or m], speeds, accelerations.",),
)
