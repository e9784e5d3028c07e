"""Base parameters: what the torques determine, three ways.

parameters.py holds the result; rank.py finds it by QR on random states, grouping.py by Khalil's closed-form rules,
local_transfers.py by transfers across single joints, without rules or samples.
"""

from ...common.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
