"""The payload by the four methods of the paper, behind one signature."""

from ..error_model import error_model
from .answer import PayloadAnswer, answer_payload
from .blocks import PairedMeasurement, PayloadBlocks, payload_blocks
from .by_joints import ByJoints, JointShare, JointsMass, payload_by_joints
from .constrained import ConstrainedPayload, constrain_payload
from .equations import difference_problem, loaded_problem
from .frame import frame_change, in_payload_frame
from .from_change import payload_map
from .gains import payload_gain_sensitivity
from .global_fit import combined, combined_problem, essential_combined, selected
from .methods import METHODS, identify_payload, usable_methods
from .over_time import Stretch, payload_over_time
from .problem import FixedWeights, PayloadProblem, payload_problem
from .result import PayloadEstimate
from .robust import Method, robust_covariance, with_robust

__all__ = [
    "METHODS",
    "ByJoints",
    "ConstrainedPayload",
    "FixedWeights",
    "JointShare",
    "JointsMass",
    "Method",
    "PairedMeasurement",
    "PayloadAnswer",
    "PayloadBlocks",
    "PayloadEstimate",
    "PayloadProblem",
    "Stretch",
    "answer_payload",
    "combined",
    "combined_problem",
    "constrain_payload",
    "difference_problem",
    "error_model",
    "essential_combined",
    "frame_change",
    "identify_payload",
    "in_payload_frame",
    "loaded_problem",
    "payload_blocks",
    "payload_by_joints",
    "payload_gain_sensitivity",
    "payload_map",
    "payload_over_time",
    "payload_problem",
    "robust_covariance",
    "selected",
    "usable_methods",
    "with_robust",
]
