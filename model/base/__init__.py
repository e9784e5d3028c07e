"""Base parameters: what the torques determine, two ways.

parameters.py holds the result; rank.py finds it by QR on random states, grouping.py by Khalil's closed-form rules.
"""
