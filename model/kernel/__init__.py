"""Evaluates a scalar CasADi function on many samples at once.

program.py reads CasADi's own operation list, numpy_path.py runs it over blocks of samples, c_path.py writes
it as C that works on several samples per instruction, or as readable C for a single one; cache.py compiles
once and keeps it.
"""
