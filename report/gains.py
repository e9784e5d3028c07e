"""Drive gains as JSON."""

from typing import Any

import numpy as np

from ..estimation import GainErrors
from ..estimation.gains import DriveGains
from ..model import INERTIAL, Processing


def gain_errors_document(gains: GainErrors) -> dict[str, Any]:
    """What was said of the gains' errors; where gains were identified, their covariance, recordings and payload."""
    document: dict[str, Any] = {"per_joint": gains.per_joint, "common": gains.common}
    if gains.identified:
        document["identified"] = gains.identified
    if any(gains.recordings):
        document |= {"recordings": gains.recordings._asdict(), "mass": gains.mass}
    return document | ({"notes": gains.notes} if gains.notes else {})


def gains_document(gains: DriveGains, processing: Processing) -> dict[str, Any]:
    """What ``dynident gains --json`` writes, and ``--drive-gains`` reads."""
    robust = gains.relative_sigma_robust
    return {
        "robot": gains.robot,
        "processing": {
            "rate_hz": processing.rate,
            "cutoff_hz": processing.cutoff,
            "decimate": processing.decimate,
            "slow_fraction": processing.slow_fraction,
        },
        "load": {
            "known": dict(zip(gains.load.known, gains.load.values, strict=True)),
            "mass_sigma": gains.load.mass_sigma,
            "identified": dict(zip(INERTIAL, gains.payload.vector, strict=True)),
        },
        "drive_gains": {
            "values": gains.values,
            "sigma": gains.values * gains.larger_relative_sigma,
            "relative_sigma": gains.larger_relative_sigma,
            "relative_sigma_formula": gains.relative_sigma,
            "relative_sigma_robust": robust if robust is not None else None,
            "relative_covariance": gains.larger_relative_covariance,
            "without_constraints": gains.free_values,
            "identified": list(gains.identified),
            "rests_on": list(gains.identifiability),
        },
        "recordings": gains.recordings._asdict(),
        "robust": {"blocks": gains.robust.blocks, "block_length_s": gains.robust.block_length}
        if gains.robust
        else {"blocks": None, "unavailable": gains.without_robust or None},
        "relative_residual": {"all": gains.fit.relative, "per_joint": np.asarray(gains.fit.relative_per_joint)},
    }
