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
    PayloadAnswer,
    PayloadEstimate,
    PayloadProblem,
    answer_payload,
    combined,
    difference_problem,
    identify_payload,
    loaded_problem,
    payload_problem,
    usable_methods,
)
from .problem import ReducedProblem, merged
from .records import read_recording
from .reduction import reduced, reduced_measurement, reduced_stream

__all__ = [
    "PAYLOAD",
    "AlignedPair",
    "Estimate",
    "Fit",
    "Identification",
    "Observation",
    "Observer",
    "PayloadAnswer",
    "PayloadEstimate",
    "PayloadProblem",
    "ReducedProblem",
    "aligned",
    "answer_payload",
    "base_problem",
    "combined",
    "decimated",
    "difference_problem",
    "fit",
    "identify",
    "identify_payload",
    "loaded_problem",
    "measurement",
    "merged",
    "noise_bandwidth",
    "ordinary",
    "payload_problem",
    "read_recording",
    "reduced",
    "reduced_measurement",
    "reduced_stream",
    "resampled",
    "usable_methods",
    "weighted",
]
