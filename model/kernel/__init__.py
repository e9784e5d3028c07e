"""Evaluates a scalar CasADi function on many samples at once.

program.py reads CasADi's own operation list, numpy_path.py runs it over blocks of samples, c_path.py writes
it as C that works on several samples per instruction, cache.py compiles that once and keeps it. c_scalar.py
writes the same list as readable C for a single sample.
"""
