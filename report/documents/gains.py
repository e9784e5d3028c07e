"""The document of ``gains``."""

from ...estimation.files import StoredGains
from ...estimation.files.parts import ProcessingDocument, RobustDocument
from ...estimation.files.stored import GainsTable, LoadDocument
from ...estimation.gains import DriveGains
from ...model import INERTIAL, Processing
from .parts import equation_rate, residual_document


def gains_document(gains: DriveGains, processing: Processing) -> StoredGains:
    """What ``dynident gains --json`` writes, and ``--drive-gains`` reads."""
    robust, load = gains.robust, gains.load
    return StoredGains(
        robot=gains.robot,
        processing=ProcessingDocument(
            rate=processing.rate,
            cutoff=processing.cutoff,
            decimate=processing.decimate,
            equation_rate=equation_rate(processing),
            slow_fraction=processing.slow_fraction,
            slow_speed=processing.slow_speed,
        ),
        load=LoadDocument(
            known=dict(zip(load.known, load.values.tolist(), strict=True)),
            mass_sigma=load.mass_sigma,
            identified=dict(zip(INERTIAL, gains.payload.vector.tolist(), strict=True)),
        ),
        drive_gains=GainsTable(
            values=gains.values,
            sigma=gains.values * gains.larger_relative_sigma,
            relative_sigma=gains.larger_relative_sigma,
            relative_sigma_formula=gains.relative_sigma,
            relative_sigma_robust=gains.relative_sigma_robust,
            relative_covariance=gains.larger_relative_covariance,
            without_constraints=gains.free_values,
            identified=gains.identified,
            rests_on=tuple(gains.identifiability),
        ),
        fingerprints=gains.recordings,
        robust=RobustDocument(robust.blocks, robust.block_length)
        if robust
        else RobustDocument(None, unavailable=gains.without_robust or None),
        relative_residual=residual_document(gains.fit),
    )
