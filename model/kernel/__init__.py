"""Evaluates a scalar CasADi function on many samples at once.

program.py reads CasADi's own operation list and writes it as C that works on several samples per instruction, or as
readable C for a single one; cache.py compiles that once and keeps it. Without a compiler, kernel.py writes it as
Python of NumPy's operations.
"""
