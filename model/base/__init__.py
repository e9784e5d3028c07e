"""Base parameters: the combinations of standard parameters that torques determine, found two ways.

parameters.py holds the result; rank.py finds it by QR on random states, closed_form.py by Khalil's rules.
"""
