from .identification import base_problem as base_problem
