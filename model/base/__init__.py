"""Base parameters: what the torques determine, three ways.

parameters.py holds the result; rank.py finds it by QR on random states, grouping.py by Khalil's closed-form rules,
local_transfers.py by transfers across single joints, without rules or samples.
"""
