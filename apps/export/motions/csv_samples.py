"""Samples as CSV: t, q1..qn, qd1..qdn, qdd1..qddn in seconds, rad or m; lines of remarks before the header.

``dynident score`` and ``dynident simulate --trajectory`` read it.
"""

import io

import numpy as np

from .written import DIGITS, WrittenMotion


def csv_text(written: WrittenMotion, rate: float) -> str:
    """The file.

    Args:
        rate: samples per second [Hz].
    """
    motion, n = written.sampled(rate), written.robot.n
    header = ["t", *(f"{kind}{j}" for kind in ("q", "qd", "qdd") for j in range(1, n + 1))]
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in written.head)
    text.write("# Columns: t [s], positions [rad or m], speeds, accelerations.\n")
    table = np.column_stack([motion.t, motion.q, motion.qd, motion.qdd])
    np.savetxt(text, table, delimiter=",", header=",".join(header), comments="", fmt=f"%.{DIGITS}f")
    return text.getvalue()
