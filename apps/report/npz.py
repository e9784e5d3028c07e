"""The observation system as an NPZ file.

``columns``, ``W`` (r x c), ``Y``, ``joint`` (from 1), ``recording`` (from 0, in ``sources``), ``t``, ``loaded``,
``weights`` (per joint) and ``row_weights``; ``rows``, ``effective_rows`` and ``factor0`` to ``factor<n-1>``: R of
the QR decomposition of each joint's [W_j Y_j], which ``Equations.load`` reads, and of coupled drives
``shared<joint>_<motor>`` (from 0), Q_j' times what another joint's motor makes of Y_j; ``known``: values of the
first columns, where they are known.
"""

import io
from pathlib import Path
from typing import Any

import numpy as np

from ...common.files import write_bytes
from ...estimation.answers.system import ObservationSystem


def write_npz(path: str | Path, system: ObservationSystem) -> None:
    """Write a system; the file's name is kept as it is.

    Raises:
        OSError: if it cannot be written.
    """
    reduced = system.reduced
    arrays: dict[str, Any] = reduced.arrays()
    if system.known is not None:
        arrays["known"] = system.known
    content = io.BytesIO()
    np.savez_compressed(
        content,
        W=system.W,
        Y=system.Y,
        joint=system.joint,
        recording=system.recording,
        t=system.t,
        loaded=system.loaded,
        sources=np.array(system.sources),
        weights=system.weights,
        row_weights=system.weights[system.joint - 1],
        **arrays,
    )
    write_bytes(path, content.getvalue())
