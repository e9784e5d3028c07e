"""From recordings to parameters. Imports only the model room."""

from .alignment import AlignedPair, aligned
from .decimation import decimated, noise_bandwidth
from .estimate import Estimate, Fit, fit
from .filtering import measurement, resampled
from .identification import Identification, base_problem, identify
from .least_squares import ordinary, weighted
from .observation import Observation, Observer
from .payload import (
    PAYLOAD,
    PairedMeasurement,
    PayloadBlocks,
    PayloadEstimate,
    PayloadProblem,
    combined,
    difference_problem,
    identify_payload,
    loaded_problem,
    payload_blocks,
    payload_problem,
    usable_methods,
)
from .problem import ReducedProblem, merged
from .records import read_recording
from .reduction import reduced, reduced_measurement, reduced_stream
from .robust import RobustCovariance, jackknife

__all__ = [
    "PAYLOAD",
    "AlignedPair",
    "Estimate",
    "Fit",
    "Identification",
    "Observation",
    "Observer",
    "PairedMeasurement",
    "PayloadBlocks",
    "PayloadEstimate",
    "PayloadProblem",
    "ReducedProblem",
    "RobustCovariance",
    "aligned",
    "base_problem",
    "combined",
    "decimated",
    "difference_problem",
    "fit",
    "identify",
    "identify_payload",
    "jackknife",
    "loaded_problem",
    "measurement",
    "merged",
    "noise_bandwidth",
    "ordinary",
    "payload_blocks",
    "payload_problem",
    "read_recording",
    "reduced",
    "reduced_measurement",
    "reduced_stream",
    "resampled",
    "usable_methods",
    "weighted",
]
