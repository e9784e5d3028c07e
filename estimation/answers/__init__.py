"""Whole answers, one function a question; the only place that calls several floors."""
