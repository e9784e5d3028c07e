"""The payload by the four methods of the paper, behind one signature."""

from .answer import PayloadAnswer, answer_payload
from .from_change import payload_map
from .global_fit import combined
from .methods import METHODS, identify_payload, usable_methods
from .problem import PAYLOAD, PayloadProblem, difference_problem, loaded_problem, payload_problem
from .result import PayloadEstimate

__all__ = [
    "METHODS",
    "PAYLOAD",
    "PayloadAnswer",
    "PayloadEstimate",
    "PayloadProblem",
    "answer_payload",
    "combined",
    "difference_problem",
    "identify_payload",
    "loaded_problem",
    "payload_map",
    "payload_problem",
    "usable_methods",
]
