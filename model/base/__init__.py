"""Base parameters: the combinations of standard parameters that torques determine, found two ways.

parameters.py has what torques show and finds it by QR on random states, closed_form.py by Khalil's rules.
"""
