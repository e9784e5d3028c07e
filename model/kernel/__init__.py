"""Evaluates a scalar CasADi function on many samples at once: kernel.py writes code, cache.py compiles it once."""
