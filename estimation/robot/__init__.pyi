from .equations import base_problem as base_problem
