"""Evaluates a scalar CasADi function on many samples at once.

program.py reads CasADi's own operation list; c_path.py writes it as C that works on several samples per
instruction, or as readable C for a single one, and cache.py compiles that once and keeps it; without a compiler,
kernel.py writes it as Python of NumPy's operations.
"""
