"""From recordings to parameters. Imports only the model room."""

from .alignment import AlignedPair, aligned
from .bounding import InEllipsoid, InHull
from .cone import SolverFailed
from .constrained import Active, ConstrainedEstimate, CvxpyProblem, build_constrained, constrained
from .constraints import CentreOfMassInBox, Constraint, KnownMass, MassBounds, PossibleBody
from .decimation import decimated, noise_bandwidth
from .estimate import Estimate, Fit, fit
from .filtering import measurement, resampled
from .identification import Identification, base_problem, identify
from .least_squares import ordinary, weighted
from .observation import Observation, Observer
from .payload import (
    PAYLOAD,
    PayloadEstimate,
    PayloadProblem,
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
    "Active",
    "AlignedPair",
    "CentreOfMassInBox",
    "ConstrainedEstimate",
    "Constraint",
    "CvxpyProblem",
    "Estimate",
    "Fit",
    "Identification",
    "InEllipsoid",
    "InHull",
    "KnownMass",
    "MassBounds",
    "Observation",
    "Observer",
    "PayloadEstimate",
    "PayloadProblem",
    "PossibleBody",
    "ReducedProblem",
    "SolverFailed",
    "aligned",
    "base_problem",
    "build_constrained",
    "combined",
    "constrained",
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
