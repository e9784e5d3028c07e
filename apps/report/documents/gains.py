"""The document of ``gains``."""

from msgspec import UNSET

from ....estimation.answers.gains import DriveGains
from ....model import INERTIAL, Processing
from ...results import StoredGains
from ...results.parts import ProcessingDocument, ResidualDocument, RobustDocument
from ...results.stored import GainsTable, LoadDocument, MountingDocument
from .parts import equation_rate, verdict_document


def gains_document(gains: DriveGains, processing: Processing) -> StoredGains:
    """What ``dynident gains --json`` writes, and ``--drive-gains`` reads."""
    robust = gains.robust
    return StoredGains(
        robot=gains.robot.name,
        processing=ProcessingDocument(
            rate=processing.rate,
            cutoff=processing.cutoff,
            decimate=processing.decimate,
            equation_rate=equation_rate(processing),
            slow_fraction=processing.slow_fraction,
            slow_speed=processing.slow_speed,
        ),
        load=_load(gains),
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
        relative_residual=ResidualDocument.of(gains.fit),
        disagreement=gains.disagreement,
        verdict=verdict_document(gains.verdict),
    )


def _load(gains: DriveGains) -> LoadDocument:
    tens = [dict(zip(INERTIAL, body.vector.tolist(), strict=True)) for body in gains.payloads]
    each = tuple(MountingDocument(name, ten) for name, ten in zip(gains.mountings.names, tens, strict=True))
    return LoadDocument(
        known=gains.known,
        mass_sigma=max(load.mass_sigma for load in gains.loads),
        identified=tens[0],
        mountings=each if len(each) > 1 else UNSET,
    )
